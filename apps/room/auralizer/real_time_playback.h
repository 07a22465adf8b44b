#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "apps/room/auralizer/room_playback.h"
#include "apps/room/frames/frame_clock.h"
#include "audio/base/mailbox.h"

namespace aula {

/// An orientation of a head, and when it was set (clock_ns(); 0 if its latency does not count).
struct HeadPose {
    Pose pose;
    std::int64_t set_ns = 0;
};

/// Plays a room on the real-time clock: frames are computed at regular times, and the renderer
/// takes the newest frame, routes and head poses from mailboxes.
class RealTimePlayback : public RoomPlayback, private LiveFrames {
 public:
    RealTimePlayback(const Scene& scene, const AuralizerOptions& options,
                     std::shared_ptr<const Hrtf> hrtf);

    int latency_samples() const override { return 0; }
    void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                int samples) noexcept AULA_NONBLOCKING override;

    // See LiveAuralizer. [before the frames start]
    void warm_up(double longest_s);
    const FrameMaker& compute_first(double time_s);
    void follow(std::function<double()> played_s,
                std::function<void(const FrameMaker&, double)> after_frame);

    /// Frees the engine. [after the frames have ended]
    void free_engine() { computer_.end(); }

    /// Turns a listener's head only. [any thread]
    void turn_head_now(std::size_t listener, const Pose& pose);

    // See LiveAuralizer. [rendering thread]
    std::int64_t frame_pose_ns() const noexcept AULA_NONBLOCKING {
        return renderer_.newest_stamp(0);
    }
    std::int64_t head_pose_ns() const noexcept AULA_NONBLOCKING { return head_pose_ns_; }

 private:
    using Clock = FrameClock::Clock;

    void compute_frames(Auralizer& auralizer) override;
    ChangeTime time_of(std::int64_t at) const override;
    void begin_source(SourceId source, const ChangeTime& time) override;
    void end_source(SourceId source, const ChangeTime& time) override;
    void turn_head(std::size_t listener, const Pose& pose, const ChangeTime& time) override;
    std::int64_t pose_ns() const override;
    void publish_routes();

    bool wait_until(Clock::time_point time) override;
    bool publish_frame(FrameClock& clock) override;
    void skip_frames(std::uint64_t count) override { computer_.count_skipped_frames(count); }
    double compute_frame(FrameClock& clock) override;
    bool wait_out_pause(FrameClock& clock);
    double played_s() const;
    ListenerFrames compute(double time_s);
    void publish(ListenerFrames frames);
    void publish_head(std::size_t listener, const Pose& pose);

    // Used by the propagation thread.
    std::function<double()> sound_time_s_;  ///< that frames follow; empty: the rendered time
    std::function<void(const FrameMaker&, double spare_s)> after_frame_;
    std::int64_t frame_due_ns_ = 0;  ///< due time of the present frame
    Auralizer* auralizer_ = nullptr;
    ListenerFrames computed_;  ///< not yet published; empty: none

    // Used by the rendering thread.
    std::int64_t head_pose_ns_ = 0;  ///< of the first listener's newest pose
    const int block_;
    std::vector<float*> part_outputs_;

    // Passed to the rendering thread. Writers lock the mutex.
    Mailbox<std::vector<SourceId>> routes_{1};               ///< [slot]
    std::vector<std::unique_ptr<Mailbox<HeadPose>>> heads_;  ///< [listener]

    // Guarded by the mutex.
    bool running_ = false;                          ///< frames are computed at their times
    std::vector<std::optional<Pose>> frame_heads_;  ///< [listener] poses for the next frame
};

}  // namespace aula
