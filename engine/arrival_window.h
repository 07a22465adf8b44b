#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "engine/energy_response.h"
#include "engine/path_tracer.h"

namespace aula {

/// The arrivals between one source and one listener over the last frames, as they came and
/// whichever end the rays left from: plain path tracing with a window of one frame, and what no
/// gather finds of `patch`. Frames from which source, listener or scene have moved by more than
/// `reach_m` together are left out, and once anything has moved those older than the window.
/// [propagation thread]
class ArrivalWindow {
 public:
    /// What the arrivals of a frame depend on.
    struct State {
        std::uint64_t frame = 0;
        Vec3 source{0};
        Vec3 listener{0};
        double travel_m = 0;  ///< how far anything in the scene has moved since the start
    };

    /// `window_frames` >= 1. What does not fit in `memory_bytes` is forgotten, oldest first.
    ArrivalWindow(int window_frames, float reach_m, std::size_t memory_bytes)
        : window_frames_(static_cast<std::size_t>(window_frames)),
          reach_m_(reach_m),
          memory_bytes_(memory_bytes) {}

    /// Forgets what no longer holds. Call once for each frame, in order.
    void advance(const State& now);

    /// Takes arrivals of the present frame, after advance(); those of its rays from either end.
    void add(std::span<const Arrival> arrivals, int rays);

    /// True if every frame held is as the present one: none is from before a change.
    bool settled() const;

    /// True if as many frames are held as ever will be.
    bool full() const { return frames_.size() == window_frames_; }

    /// Adds the arrivals, each at its own delay, over the rays of their frames.
    void add_to(EnergyResponse& response) const;

    std::size_t memory_bytes() const;

 private:
    struct Frame {
        State state;
        std::vector<Arrival> arrivals;
        int rays = 0;
    };
    double moved_m(const Frame& frame) const;
    bool holds(const Frame& frame) const;

    std::size_t window_frames_;
    float reach_m_;
    std::size_t memory_bytes_;
    State now_;
    std::deque<Frame> frames_;
};

}  // namespace aula
