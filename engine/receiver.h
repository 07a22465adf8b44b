#pragma once

#include "engine/ray_scene.h"

namespace aula {

/// A sphere that rays are to cross: a listener's or, where a listener emits, a source's. Walls may
/// hide a part of it; what it does not see is not heard, and the rest stands for the whole.
struct Receiver {
    Vec3 position{0};
    float seen_share = 1;  ///< of the sphere's volume, as seen from its middle
};

/// How much of a sphere a receiver sees. [propagation thread]
Receiver make_receiver(const RayScene& scene, const Vec3& position, float radius_m);

}  // namespace aula
