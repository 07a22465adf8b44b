#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// Which sides of every triangle face the space that sound is in: bit 0 the side of its normal, bit
/// 1 the other. Looking from outside, what shows only other sides can be left out, so that one sees
/// in. Small triangles that no ray met show both.
std::vector<std::uint8_t> sounding_sides(const RayScene& rays, std::span<const Vec3> inside);

}  // namespace aula
