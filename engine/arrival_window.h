#pragma once

#include <deque>
#include <span>
#include <vector>

#include "engine/energy_response.h"
#include "engine/path_tracer.h"

namespace aula {

/// The arrivals of one source at one listener over the last frames, as they came: plain path
/// tracing with a window of one frame, and the high specular orders of `patch`. Frames from which
/// source, listener or scene have moved by more than `reach_m` together are left out. [propagation
/// thread]
class ArrivalWindow {
 public:
    /// `window_frames` >= 1.
    ArrivalWindow(int window_frames, float reach_m)
        : window_frames_(static_cast<std::size_t>(window_frames)), reach_m_(reach_m) {}

    /// `travel_m`: how far anything in the scene has moved since the start.
    void add_frame(const Vec3& source, const Vec3& listener, double travel_m,
                   std::span<const Arrival> arrivals, int rays);

    /// Adds the arrivals, each at its own delay, over the rays of their frames.
    void add_to(EnergyResponse& response) const;

    std::size_t memory_bytes() const;

 private:
    struct Frame {
        Vec3 source;
        Vec3 listener;
        double travel_m;
        std::vector<Arrival> arrivals;
        int rays;
    };
    bool still_holds(const Frame& frame) const;

    std::size_t window_frames_;
    float reach_m_;
    std::deque<Frame> frames_;
};

}  // namespace aula
