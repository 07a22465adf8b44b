#include "engine/trace/specular_sum.h"

#include <algorithm>

namespace aula {

void SpecularSum::clear() {
    std::fill(sum_.energy.begin(), sum_.energy.end(), Bands{});
    std::fill(sum_.direction.begin(), sum_.direction.end(), Vec3(0));
    by_image_.clear();
    rays_ = 0;
}

void SpecularSum::add(const SegmentEnergy& sound, const Bands& energy, float length_m) {
    const Vec3 direction = energy.sum() * sound.from;
    if (sound.image != 0) {
        Detected& detected = by_image_[sound.image];
        detected.energy += energy;
        detected.direction += direction;
        detected.length_m += double{length_m};
        detected.count += 1;
        return;
    }
    const std::size_t bin = sum_.bins.index(double{length_m} / double{sum_.speed_of_sound_m_s});
    if (bin >= sum_.bins.count()) return;
    sum_.energy[bin] += energy;
    sum_.direction[bin] += direction;
}

void SpecularSum::add_to(const SpecularSound& images, EnergyResponse& response) const {
    if (rays_ == 0) return;
    const float scale = 1 / static_cast<float>(rays_);
    for (std::size_t k = 0; k < sum_.bins.count(); ++k) {
        response.energy[k] += sum_.energy[k] * scale;
        response.direction[k] += sum_.direction[k] * scale;
    }
    for (const auto& [image, detected] : by_image_) {
        if (images.has_tried(image)) continue;
        const std::size_t bin = response.bins.index(detected.length_m / detected.count /
                                                    double{response.speed_of_sound_m_s});
        if (bin >= response.bins.count()) continue;
        response.energy[bin] += detected.energy * scale;
        response.direction[bin] += detected.direction * scale;
    }
}

}  // namespace aula
