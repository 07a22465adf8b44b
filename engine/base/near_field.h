#pragma once

#include <algorithm>
#include <glm/geometric.hpp>

#include "aula/engine/vec3.h"

namespace aula {

/// Nearer than this a source is as loud as at this distance, and its direction becomes indistinct:
/// there the model of a point source and a point of the ear has no meaning.
inline constexpr double kNearest_m = 0.1;

/// The direction of an offset from a listener or a source: a unit vector from kNearest_m on, and in
/// proportion shorter within it. It is continuous, and 0 where there is no direction.
inline Vec3 near_direction(const glm::dvec3& offset) {
    return Vec3(offset / std::max(glm::length(offset), kNearest_m));
}

}  // namespace aula
