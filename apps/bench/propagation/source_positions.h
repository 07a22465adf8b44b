#pragma once

#include <vector>

#include "aula/engine/scene.h"

namespace aula::bench {

/// Positions of sources: the first one is the scene's; each further one is half-way along a random
/// ray from an earlier one, with no surface within 0.25 m.
std::vector<Vec3> source_positions(const Scene& scene, int count);

}  // namespace aula::bench
