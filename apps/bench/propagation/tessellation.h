#pragma once

#include <cstddef>

#include "aula/engine/scene.h"

namespace aula::bench {

/// Divides every triangle of a scene into n^2 congruent ones, with the least n that gives at least
/// `triangles` in total. The surface keeps its shape and stays closed: neighbours share corners to
/// the bit.
void tessellate(Scene& scene, std::size_t triangles);

}  // namespace aula::bench
