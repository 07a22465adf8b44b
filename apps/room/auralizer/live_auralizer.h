#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "apps/room/auralizer/real_time_playback.h"
#include "apps/room/frames/frame_maker.h"
#include "audio/spatial/hrtf.h"
#include "aula/auralizer.h"

namespace aula {

/// An Auralizer on the real-time clock for live playback, which starts and ends its frames, follows
/// them, and reuses an HRTF.
class LiveAuralizer {
 public:
    /// Functions that the propagation thread calls.
    struct Hooks {
        /// Time of the sound that the frames follow, in s.
        std::function<double()> played_s;
        /// See AuralizerOptions::before_frame.
        std::function<void(double time_s)> before_frame;
        /// After a frame, with the time until it is due.
        std::function<void(const FrameMaker& maker, double spare_s)> after_frame;
    };

    /// Builds the engine and the renderer; the clock of the options is ignored. `hrtf`: that of the
    /// options, or null to read it if the output needs it.
    LiveAuralizer(const Scene& scene, AuralizerOptions options, std::shared_ptr<const Hrtf> hrtf);

    Auralizer& room() noexcept { return room_; }
    const Auralizer& room() const noexcept { return room_; }

    /// Fills the caches for the present room, for at most about `longest_s`. [before start()]
    void warm_up(double longest_s);

    /// Computes the frame of a time and hands it over. Returns the object that computed it. Poses
    /// set before start() do not count for latencies. [before start()]
    const FrameMaker& compute_first(double time_s);

    /// Starts to compute frames.
    void start(Hooks hooks);

    /// Ends the frames and frees the engine. The newest responses remain audible.
    void stop();

    /// Turns the head only, also after stop(). [any thread]
    void turn_head(const Pose& pose) { playback_.turn_head_now(0, pose); }

    /// As Auralizer::render(). [audio thread, wait-free]
    void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                int samples) noexcept AULA_NONBLOCKING {
        playback_.render(inputs, outputs, samples);
    }

    /// As Auralizer::tail_samples(). [audio thread]
    std::int64_t tail_samples() const noexcept AULA_NONBLOCKING { return playback_.tail_samples(); }

    /// When the pose of the newest frame, and the newest pose of the head, was set (clock_ns()); 0
    /// if its latency does not count. [audio thread]
    std::int64_t frame_pose_ns() const noexcept AULA_NONBLOCKING {
        return playback_.frame_pose_ns();
    }
    std::int64_t head_pose_ns() const noexcept AULA_NONBLOCKING { return playback_.head_pose_ns(); }

 private:
    std::function<void(double time_s)> before_frame_;
    Auralizer room_;
    RealTimePlayback& playback_;
};

}  // namespace aula
