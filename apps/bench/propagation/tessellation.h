#pragma once

#include <cstddef>

#include "engine/scene/scene.h"

namespace aula::bench {

/// Divides every triangle of a scene into n^2 alike ones, n the least that gives `triangles`
/// altogether. The surface stays where it was, and as tight: pieces share their corners to the bit.
void tessellate(Scene& scene, std::size_t triangles);

}  // namespace aula::bench
