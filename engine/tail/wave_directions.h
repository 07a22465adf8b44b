#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "aula/engine/vec3.h"

namespace aula {

/// Number of plane waves that make up a diffuse field at a time, at most.
inline constexpr std::size_t kPlaneWaves = 24;

/// The number of them for ambisonic channels up to an order.
constexpr std::size_t plane_waves(int order) { return order <= 1 ? kPlaneWaves / 2 : kPlaneWaves; }

/// Directions of arrival whose means of all polynomials up to degree 7 are those over the sphere (a
/// spherical 7-design: McLaren's improved snub cube, Hardin and Sloane 1996), in a random
/// orientation for each seed. The spherical harmonics up to order 3 are orthogonal over all of
/// them, those up to order 1 over the first half.
std::array<Vec3, kPlaneWaves> wave_directions(std::uint64_t seed);

}  // namespace aula
