#pragma once

#include "apps/room/base/playback_options.h"
#include "aula/auralizer.h"

namespace aula {

/// The options of an auralizer on the real-time clock that renders a scene.
inline AuralizerOptions auralizer_options(const Scene& scene, const PlaybackOptions& options) {
    AuralizerOptions of_scene{options};
    of_scene.max_sources = scene.sources.size();
    of_scene.max_memory_bytes = options.max_memory_bytes;
    return of_scene;
}

}  // namespace aula
