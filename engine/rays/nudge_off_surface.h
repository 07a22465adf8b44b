#pragma once

#include "engine/rays/ray_scene.h"

namespace aula {

/// Moves a point that is within 0.5 mm of a surface 1 mm off it; returns any other unchanged. Of
/// the two sides of the surface the more enclosed one is chosen, or, if both are alike, the side
/// that the normal faces. [propagation thread]
Vec3 nudge_off_surface(const RayScene& scene, const Vec3& position);

}  // namespace aula
