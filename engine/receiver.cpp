#include "engine/receiver.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/sampling.h"

namespace aula {

Receiver make_receiver(const RayScene& scene, const Vec3& position, float radius_m) {
    constexpr std::uint32_t kLooks = 512;  // 0.3 % for half a sphere
    const ScrambledSobol sobol(1);
    std::vector<Ray> looks(kLooks);
    for (std::uint32_t i = 0; i < kLooks; ++i) {
        looks[i] = {position, uniform_direction(sobol.point(i)), radius_m};
    }
    std::vector<Hit> hits(kLooks);
    scene.intersect(looks, hits);
    // A cone that ends after r of R holds (r / R)^3 of its part of the sphere.
    float share = 0;
    for (const Hit& hit : hits) {
        const float r = std::min(hit.distance_m, radius_m) / radius_m;
        share += r * r * r / kLooks;
    }
    return {position, radius_m, std::max(share, 1e-3F)};
}

std::optional<Receiver::Chord> Receiver::chord(const RayScene& scene, const Vec3& origin,
                                               const Vec3& direction, float length_m,
                                               float nearest_m, float half_chord_2) const {
    const float half_chord_m = std::sqrt(half_chord_2);
    const float enter_m = std::max(0.0F, nearest_m - half_chord_m);
    const float leave_m = std::min(length_m, nearest_m + half_chord_m);
    if (leave_m <= enter_m) return std::nullopt;
    const float middle_m = (enter_m + leave_m) / 2;
    if (seen_share < 1 && !scene.visible(position, origin + middle_m * direction)) {
        return std::nullopt;
    }
    // The volume average of fluence: energy * chord / (4/3 pi R^3), as far as it is seen.
    const float volume_m3 =
        seen_share * 4.0F / 3.0F * std::numbers::pi_v<float> * radius_m * radius_m * radius_m;
    return Chord{middle_m, (leave_m - enter_m) / volume_m3};
}

}  // namespace aula
