#pragma once

#include <glm/geometric.hpp>
#include <optional>

#include "engine/ray_scene.h"

namespace aula {

/// A sphere that rays are to cross: a listener's or, where a listener emits, a source's. Walls may
/// hide a part of it; what it does not see is not heard, and the rest stands for the whole.
struct Receiver {
    /// What a ray has of the sphere.
    struct Chord {
        float middle_m = 0;  ///< along the ray
        float share_1_m2 =
            0;  ///< its length over the sphere's volume: fluence of a ray of energy 1
    };

    Vec3 position{0};
    float radius_m = 0.5F;
    float seen_share = 1;  ///< of the sphere's volume, as seen from its middle

    /// The part of a ray's first `length_m` that the receiver hears, if any.
    std::optional<Chord> chord(const RayScene& scene, const Vec3& origin, const Vec3& direction,
                               float length_m) const {
        const Vec3 to_centre = position - origin;
        const float nearest_m = glm::dot(to_centre, direction);
        const float half_chord_2 =
            radius_m * radius_m - (glm::dot(to_centre, to_centre) - nearest_m * nearest_m);
        if (half_chord_2 <= 0) return std::nullopt;
        return chord(scene, origin, direction, length_m, nearest_m, half_chord_2);
    }

 private:
    std::optional<Chord> chord(const RayScene& scene, const Vec3& origin, const Vec3& direction,
                               float length_m, float nearest_m, float half_chord_2) const;
};

/// How much of a sphere a receiver sees. [propagation thread]
Receiver make_receiver(const RayScene& scene, const Vec3& position, float radius_m);

}  // namespace aula
