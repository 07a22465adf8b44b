#pragma once

#include <glm/vec3.hpp>

namespace aula {

/// A position in metres or a direction, in a right-handed frame with z up.
using Vec3 = glm::vec3;

}  // namespace aula
