#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "aula/engine/vec3.h"

namespace aula {

/// A unit of length.
struct LengthUnit {
    double metres;
    const char* name;
};

/// The unit of a model of the size x, y, z with z up, if it is not metres: where it would be more
/// than 60 m high or 300 m wide, the first of millimetres, centimetres and inches in which it is a
/// room or a building from 1.8 m to 60 m high.
std::optional<LengthUnit> guess_unit(const glm::dvec3& size);

/// "18 x 12 x 4.8"
std::string size_text(const Vec3& size);

}  // namespace aula
