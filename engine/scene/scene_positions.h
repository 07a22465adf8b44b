#pragma once

#include <vector>

#include "aula/engine/scene.h"

namespace aula {

/// Positions of the sources, then of the listener; for a source or listener with a path, the
/// positions of its keyframes.
std::vector<Vec3> scene_positions(const Scene& scene);

}  // namespace aula
