#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/scene/scene.h"

namespace aula {

/// The positions of all objects, sources and listeners in one frame.
struct FrameInput {
    double time_s = 0;                      ///< of the objects' trajectories, if `objects` is empty
    std::vector<Vec3> sources;              ///< one for each source
    std::vector<Vec3> listeners;            ///< the same number in every frame, at least one
    std::vector<RigidTransform> objects{};  ///< one for each object of the scene, or empty
};

/// The cost of a frame and the size of the caches.
struct FrameStatistics {
    double trace_s = 0;  ///< wall-clock times of parts of the step
    double cache_s = 0;
    double gather_s = 0;
    double specular_s = 0;
    std::uint64_t segments = 0;     ///< traced ray segments, of emitted and gather rays
    std::size_t cache_entries = 0;  ///< diffuse path cache entries, or occupied patches
    std::size_t memory_bytes = 0;   ///< of the caches
};

}  // namespace aula
