#pragma once

#include <future>
#include <memory>
#include <thread>

#include "apps/session/auralizer/room_playback.h"
#include "aula/auralizer.h"

namespace aula {

/// The playback and the propagation thread, which builds it and computes its frames.
struct Auralizer::State {
    State(const Scene& scene, AuralizerOptions options);

    /// Builds the playback. [propagation thread]
    void build();
    void end();

    void check_object(std::size_t object) const;

    const Scene scene;
    const AuralizerOptions options;
    std::unique_ptr<RoomPlayback> playback;
    std::promise<void> built;    ///< the playback, or what prevents it
    std::promise<void> started;  ///< the auralizer is complete
    std::thread thread;
};

}  // namespace aula
