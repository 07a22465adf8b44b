#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/vec3.h"

namespace aula {

/// Where everything is in one frame. Moving geometry follows its own path to `time_s`.
struct FrameInput {
    double time_s = 0;
    std::vector<Vec3> sources;    ///< one for each source of the scene
    std::vector<Vec3> listeners;  ///< as many as in every other frame, at least one
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
