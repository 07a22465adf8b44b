#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/scene/scene.h"

namespace aula {

/// Where everything is in one frame.
struct FrameInput {
    double time_s = 0;            ///< to which objects follow their paths without `objects`
    std::vector<Vec3> sources;    ///< one for each source
    std::vector<Vec3> listeners;  ///< as many as in every other frame, at least one
    std::vector<RigidTransform> objects{};  ///< one for each object of the scene, or empty
};

/// What a frame cost and what the caches hold.
struct FrameStatistics {
    double trace_s = 0;  ///< wall-clock parts of the step
    double cache_s = 0;
    double gather_s = 0;
    double specular_s = 0;
    std::uint64_t segments = 0;     ///< ray segments traced, source and gather rays
    std::size_t cache_entries = 0;  ///< diffuse path cache entries, or occupied patches
    std::size_t memory_bytes = 0;   ///< of the caches
};

}  // namespace aula
