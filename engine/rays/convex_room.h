#pragma once

#include <cstddef>
#include <span>

#include "engine/rays/ray_scene.h"

namespace aula {

/// Scenes of more triangles are not compared.
constexpr std::size_t kMostConvexTriangles = 256;

/// True for an empty closed room, such as a box: nothing moves, the triangles surround its middle
/// once, and each of them has all others, and all of `inside`, on one side. All points of the room
/// then see each other, and no face lies on another one.
bool is_convex_room(const RayScene& scene, std::span<const Vec3> inside);

}  // namespace aula
