#pragma once

#include <vector>

#include "aula/engine/scene.h"

namespace aula {

/// Positions of the sources; for a source with a path, the positions of its keyframes.
std::vector<Vec3> source_positions(const Scene& scene);

/// The same of the listener.
std::vector<Vec3> listener_positions(const Scene& scene);

/// Positions of the sources, then of the listener.
std::vector<Vec3> scene_positions(const Scene& scene);

}  // namespace aula
