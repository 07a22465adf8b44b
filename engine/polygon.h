#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/scene.h"

namespace aula {

/// Cuts a polygon, convex or not, nearly planar, into triangles with its own winding. Gives
/// indices into `corners`; empty if the polygon has no area or crosses itself so that it cannot be
/// cut. Corners on a straight edge may be left out.
std::vector<std::array<std::uint32_t, 3>> triangulate(const std::vector<Vec3>& corners);

}  // namespace aula
