#pragma once

#include <glm/vec3.hpp>

namespace aula {

/// A position in metres or a direction, in right-handed axes with z up. A GLM vector of floats with
/// the members x, y and z.
using Vec3 = glm::vec3;

}  // namespace aula
