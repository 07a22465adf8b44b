#include "engine/rays/receiver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "engine/base/sampling.h"
#include "engine/base/tolerances.h"

namespace aula {

Receiver make_receiver(const RayScene& scene, const Vec3& position, float radius_m) {
    constexpr std::uint32_t kProbes = 512;  // error 0.3 % for half a sphere
    const float largest_m = radius_m * Receiver::radius_factor(Receiver::kSpheres - 1);
    const ScrambledSobol sobol(1);
    std::vector<Ray> probes(kProbes);
    for (std::uint32_t i = 0; i < kProbes; ++i) {
        probes[i] = {position, uniform_direction(sobol.point(i)), largest_m};
    }
    std::vector<Hit> hits(kProbes);
    scene.intersect(probes, hits);
    Receiver receiver{position, radius_m, Receiver::filled(0),
                      scene.clear_m(position, largest_m + 2 * tolerances::kOffset_m)};
    for (std::size_t k = 0; k < Receiver::kSpheres; ++k) {
        // A cone that ends at r of R contains (r / R)^3 of its part of the sphere.
        const float sphere_m = radius_m * Receiver::radius_factor(k);
        float share = 0;
        for (const Hit& hit : hits) {
            const float r = std::min(hit.distance_m, sphere_m) / sphere_m;
            share += r * r * r / kProbes;
        }
        receiver.seen_share[k] = std::max(share, 1e-3F * receiver.seen_share[0]);
    }
    receiver.seen_share[0] = std::max(receiver.seen_share[0], 1e-3F);
    return receiver;
}

std::optional<Receiver::Chord> Receiver::chord(const RayScene& scene, const Vec3& origin,
                                               const Vec3& direction, float length_m,
                                               std::size_t sphere, float nearest_m,
                                               float half_chord_2) const {
    const float half_chord_m = std::sqrt(half_chord_2);
    const float enter_m = std::max(0.0F, nearest_m - half_chord_m);
    const float leave_m = std::min(length_m, nearest_m + half_chord_m);
    if (leave_m <= enter_m) return std::nullopt;
    // The visibility of a long chord is unbiased if a random point of the chord decides. The point
    // is derived from the last bits of the chord's position.
    const float share =
        sphere == 0 ? 0.5F
                    : RandomStream::to_unit(static_cast<std::uint32_t>(
                          mix64(std::bit_cast<std::uint32_t>(nearest_m) ^
                                std::uint64_t{std::bit_cast<std::uint32_t>(half_chord_2)} << 32)));
    const float at_m = enter_m + share * (leave_m - enter_m);
    const float sphere_m = radius_m * radius_factor(sphere);
    if (sphere_m + tolerances::kOffset_m >= clear_m) {
        // A segment ends on a surface: its last points may be rounded to the other side. The tested
        // point is before the end, where only rays that are nearly parallel to the surface are
        // within rounding of it, and the test passes it by as much as it may be off its ray.
        constexpr auto kBeforeEnd_m = static_cast<float>(tolerances::kSame_m);
        const float tested_m = std::min(at_m, std::max(length_m - kBeforeEnd_m, 0.5F * length_m));
        const Vec3 line = origin + tested_m * direction - position;
        const float past_m = tolerances::kRounding * (glm::length(origin) + length_m);
        const float past = past_m / std::max(glm::length(line), kBeforeEnd_m);
        if (!scene.visible(position, position + (1 + past) * line, 0)) return std::nullopt;
    }
    // The volume average of fluence, energy * chord / (4/3 pi R^3), over the visible part.
    const float volume_m3 = seen_share[sphere] * 4.0F / 3.0F * std::numbers::pi_v<float> *
                            sphere_m * sphere_m * sphere_m;
    return Chord{at_m, (leave_m - enter_m) / volume_m3};
}

}  // namespace aula
