#pragma once

#include <array>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <vector>

#include "aula/engine/directivity.h"
#include "aula/engine/vec3.h"

namespace aula {

/// Lines on the lobe of a directive source: in each direction the distance from the source is
/// proportional to the pressure in an octave band, or to its RMS over all for kAllBands. It is
/// `radius_m` in the loudest direction. `rotation` leads from the local axes of the source to the
/// world axes.
std::vector<std::array<Vec3, 2>> lobe_lines(const Directivity& directivity, std::size_t band,
                                            const Vec3& source, const glm::mat3& rotation,
                                            float radius_m);

}  // namespace aula
