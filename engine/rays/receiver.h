#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "engine/rays/ray_scene.h"

namespace aula {

/// The detection spheres around a receiver: a listener or, where a listener emits, a source. Sphere
/// k has the radius `radius_m` 2^(k/4); most rays use sphere 0. Walls may hide part of a sphere:
/// only the part that is visible from its centre detects sound, and it represents the whole.
struct Receiver {
    /// The largest has 54 times the radius: that of a hall.
    static constexpr std::size_t kSpheres = 24;

    /// The part of a ray within a sphere.
    struct Chord {
        float at_m = 0;  ///< a point of the chord, along the ray: its middle, or in large spheres a
                         ///< random one
        float share_1_m2 =
            0;  ///< its length over the sphere's volume: fluence of a ray of energy 1
    };

    Vec3 position{0};
    float radius_m = 0.5F;
    /// [sphere] visible share of its volume, from its centre
    std::array<float, kSpheres> seen_share = filled(1);
    /// RayScene::clear_m of the centre: all of a smaller sphere is visible.
    float clear_m = std::numeric_limits<float>::infinity();

    /// The chord of a sphere on a ray's first `length_m`, if any.
    std::optional<Chord> chord(const RayScene& scene, const Vec3& origin, const Vec3& direction,
                               float length_m, std::size_t sphere = 0) const {
        const Vec3 to_centre = position - origin;
        const float nearest_m = glm::dot(to_centre, direction);
        const float sphere_m = radius_m * radius_factor(sphere);
        const float half_chord_2 =
            sphere_m * sphere_m - (glm::dot(to_centre, to_centre) - nearest_m * nearest_m);
        if (half_chord_2 <= 0) return std::nullopt;
        return chord(scene, origin, direction, length_m, sphere, nearest_m, half_chord_2);
    }

    /// 2^(sphere/4)
    static float radius_factor(std::size_t sphere) {
        return sphere == 0 ? 1 : static_cast<float>(std::exp2(static_cast<double>(sphere) / 4));
    }

    /// The largest sphere whose cross-section is at most `growth` >= 1 times that of sphere 0.
    static std::size_t sphere_of(float growth) {
        if (growth < 1.4142135F) return 0;
        return std::min(static_cast<std::size_t>(2 * std::log2(double{growth})), kSpheres - 1);
    }

    static constexpr std::array<float, kSpheres> filled(float share) {
        std::array<float, kSpheres> shares{};
        for (float& s : shares) s = share;
        return shares;
    }

 private:
    std::optional<Chord> chord(const RayScene& scene, const Vec3& origin, const Vec3& direction,
                               float length_m, std::size_t sphere, float nearest_m,
                               float half_chord_2) const;
};

/// A receiver with the visible shares of its spheres and its clear distance. [propagation thread]
Receiver make_receiver(const RayScene& scene, const Vec3& position, float radius_m);

}  // namespace aula
