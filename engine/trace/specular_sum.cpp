#include "engine/trace/specular_sum.h"

namespace aula {

void SpecularSum::clear() {
    sum_.clear_bins();
    by_image_.clear();
    rays_ = 0;
}

void SpecularSum::add(const SegmentEnergy& sound, const Bands& energy, float length_m) {
    const DirectionMoments directions = DirectionMoments::of(sound.from) * energy.sum();
    if (sound.image != 0) {
        Detected& detected = by_image_[sound.image];
        detected.energy += energy;
        detected.directions += directions;
        detected.length_m += double{length_m};
        detected.count += 1;
        return;
    }
    sum_.add(double{length_m}, energy, directions);
}

void SpecularSum::add_images_to(const SpecularSound& images, EnergyResponse& response) const {
    if (rays_ == 0) return;
    const float scale = 1 / static_cast<float>(rays_);
    for (const auto& [image, detected] : by_image_) {
        if (images.has_tried(image)) continue;
        response.add(detected.length_m / detected.count, detected.energy * scale,
                     detected.directions * scale);
    }
}

void SpecularSum::add_others_to(EnergyResponse& response) const {
    if (rays_ == 0) return;
    const float scale = 1 / static_cast<float>(rays_);
    for (std::size_t k = 0; k < sum_.bins.count(); ++k) {
        response.energy[k] += sum_.energy[k] * scale;
        response.directions[k] += sum_.directions[k] * scale;
    }
}

}  // namespace aula
