#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/vec3.h"

namespace aula {

/// The most corners of a polygon: the time to cut it grows with their square.
inline constexpr std::size_t kMostCorners = 4096;

/// Cuts a polygon, convex or not, nearly planar, into triangles with its own winding. Gives
/// indices into `corners`; empty if the polygon has no area or crosses itself so that it cannot be
/// cut. Corners on a straight edge may be left out.
std::vector<std::array<std::uint32_t, 3>> triangulate(const std::vector<Vec3>& corners);

}  // namespace aula
