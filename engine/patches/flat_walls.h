#pragma once

#include <vector>

#include "engine/patches/grid_axis.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// Which triangles of a scene count as walls.
enum class WallsOf { all_objects, static_objects };

/// The walls across a direction of unit length, by ascending position along it, from `origin` on.
/// Walls whose positions round to one millimetre are one, at the position of its largest triangle:
/// otherwise points off their surfaces would be on both sides of a cut.
std::vector<GridAxis::Wall> flat_walls(const RayScene& scene, const Vec3& origin,
                                       const Vec3& direction, WallsOf which);

}  // namespace aula
