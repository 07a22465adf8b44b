#pragma once

#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// The position at 1 mm from each surface that is within 0.5 mm of `position`; `position` itself if
/// there is none. Of the two sides of a surface the more enclosed one is chosen, or, if both are
/// alike, the side that the normal faces. On the surface half of its rays would be lost.
/// [propagation thread]
Vec3 nudge_off_surface(const RayScene& scene, const Vec3& position);

/// The same for each of several positions.
std::vector<Vec3> nudge_off_surfaces(const RayScene& scene, std::vector<Vec3> positions);

}  // namespace aula
