#pragma once

#include <future>
#include <memory>
#include <thread>

#include "apps/room/auralizer/room_playback.h"
#include "aula/auralizer.h"

namespace aula {

/// The playback and the propagation thread, which builds it and computes its frames.
struct Auralizer::State {
    /// `hrtf`: that of the options, or null to read it.
    State(const Scene& scene, AuralizerOptions options, std::shared_ptr<const Hrtf> hrtf = nullptr);

    /// Builds the playback. [propagation thread]
    void build();

    /// Starts the frames.
    void begin();

    /// Ends the frames and the thread.
    void end();

    void check_object(std::size_t object) const;

    const Scene scene;
    const AuralizerOptions options;
    const std::shared_ptr<const Hrtf> hrtf;
    std::unique_ptr<RoomPlayback> playback;
    std::promise<void> built;    ///< the playback, or the error that prevents it
    std::promise<bool> started;  ///< whether frames are requested
    bool is_started = false;     ///< the promise has been fulfilled
    std::thread thread;
};

}  // namespace aula
