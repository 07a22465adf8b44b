#pragma once

#include "apps/room/base/playback_options.h"
#include "aula/auralizer.h"

namespace aula {

/// The options of an auralizer on the real-time clock that renders a scene at a sample rate.
inline AuralizerOptions auralizer_options(const Scene& scene, const PlaybackOptions& options,
                                          double sample_rate_hz) {
    return {.sample_rate_hz = sample_rate_hz,
            .block = options.block,
            .output = options.output,
            .ambisonic_order = options.ambisonic_order,
            .hrtf = options.hrtf,
            .headphones = options.headphones,
            .half_precision_tail = options.half_precision_tail,
            .max_sources = scene.sources.size(),
            .max_memory_bytes = options.max_memory_bytes};
}

}  // namespace aula
