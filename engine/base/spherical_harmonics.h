#pragma once

#include <cstddef>
#include <vector>

#include "aula/engine/vec3.h"

namespace aula {

/// Real spherical harmonics of a unit direction up to an order, ACN, SN3D: the squares of each
/// order sum to 1. Writes (order + 1)^2 numbers.
void spherical_harmonics(const Vec3& direction, int order, double* out);

}  // namespace aula
