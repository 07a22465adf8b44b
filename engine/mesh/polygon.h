#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "aula/engine/vec3.h"

namespace aula {

/// Largest number of corners of a polygon. The time of the triangulation is quadratic in it.
inline constexpr std::size_t kMaxCorners = 4096;

/// Triangulates a nearly planar polygon, convex or not, with its winding. Returns indices into
/// `corners`; empty if the polygon has no area or intersects itself such that ear clipping fails.
/// Corners on a straight edge may be omitted.
std::vector<std::array<std::uint32_t, 3>> triangulate(const std::vector<Vec3>& corners);

}  // namespace aula
