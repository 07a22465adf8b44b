#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// The sides of each triangle that face the sound field: bit 0 is the side of the normal, bit 1 the
/// opposite side. A cutaway view from outside omits triangles that are seen from their other side.
/// The sides are found by random walks from the points `inside`. Moving triangles, and small
/// triangles that no walk hits, have both sides.
std::vector<std::uint8_t> interior_sides(const RayScene& rays, std::span<const Vec3> inside);

}  // namespace aula
