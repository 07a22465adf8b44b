#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "apps/session/auralizer/frame_clock.h"
#include "apps/session/auralizer/room_playback.h"
#include "audio/base/mailbox.h"

namespace aula {

/// Plays a room on the real-time clock: frames are computed at regular times, and the renderer
/// takes the newest frame, routes and head poses from mailboxes.
class RealTimePlayback : public RoomPlayback {
 public:
    RealTimePlayback(const Scene& scene, const AuralizerOptions& options);

    int latency_samples() const override { return 0; }
    void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                int samples) noexcept AULA_NONBLOCKING override;

 private:
    using Clock = FrameClock::Clock;

    void compute_frames(Auralizer& auralizer) override;
    ChangeTime time_of(std::int64_t at) const override;
    void begin_source(SourceId source, const ChangeTime& time) override;
    void end_source(SourceId source, const ChangeTime& time) override;
    void turn_head(std::size_t listener, const Pose& pose, const ChangeTime& time) override;
    void publish_routes();

    bool wait_until(Clock::time_point time);
    bool wait_out_pause(FrameClock& clock);
    double played_s() const { return static_cast<double>(rendered_.load()) / rate_hz_; }
    void publish(ListenerFrames frames);
    void publish_head(std::size_t listener, const Pose& pose);

    // Of the rendering thread.
    const int block_;
    std::vector<float*> part_outputs_;

    // To the rendering thread. Writers lock the mutex.
    Mailbox<std::vector<SourceId>> routes_{1};           ///< [slot]
    std::vector<std::unique_ptr<Mailbox<Pose>>> heads_;  ///< [listener]

    // Guarded by the mutex.
    std::vector<std::optional<Pose>> frame_heads_;  ///< [listener] that the next frame brings
};

}  // namespace aula
