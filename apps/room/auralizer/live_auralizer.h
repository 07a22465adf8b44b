#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "apps/room/auralizer/real_time_playback.h"
#include "apps/room/frames/frame_maker.h"
#include "aula/auralizer.h"

namespace aula {

/// An Auralizer on the real-time clock for live playback, which starts and ends its frames, follows
/// them, and plays signals of its own. Its scenes are exchanged with their sources.
class LiveAuralizer {
 public:
    using Hooks = RealTimePlayback::Hooks;

    /// Builds the engine and the renderer; the clock of the options is ignored.
    LiveAuralizer(const Scene& scene, AuralizerOptions options);

    Auralizer& room() noexcept { return room_; }
    const Auralizer& room() const noexcept { return room_; }

    /// What is built for the first scene. [before start()]
    std::shared_ptr<BuiltRoom> first() { return playback_.first(); }

    /// Sets the sample time of the first sample. [before start()]
    void begin_at(std::int64_t sample) { playback_.begin_at(sample); }

    /// Computes the frame of a time and hands it over. Returns the object that computed it. Poses
    /// set before start() do not count for latencies. [before start()]
    const FrameMaker& compute_first(double time_s) { return playback_.compute_first(time_s); }

    /// Starts to compute frames. `before_frame`: see AuralizerOptions.
    void start(std::function<void(double time_s)> before_frame, Hooks hooks);

    /// Ends the frames and frees the engine. The newest responses remain audible.
    void stop();

    /// Builds another scene with its sources. The output is that of the present one, except HRTF
    /// and headphones. Throws InputError. [any thread]
    std::shared_ptr<BuiltRoom> build(const Scene& scene, const AuralizerOptions& options) const;

    /// Exchanges the scene: the next frame is the first one of `next`. Returns the number of the
    /// scene; the first one has 0. [any thread]
    std::uint64_t begin(std::shared_ptr<BuiltRoom> next);

    /// See RealTimePlayback::wait_for(). [any thread]
    void wait_for(std::uint64_t scene) { playback_.wait_for(scene); }

    /// Sets poses and gains of all sources, objects, gains of parts and rays of a scene, given by
    /// its number, from the next frame on. [any thread]
    void set_state(std::uint64_t scene, RoomState state);

    /// As Auralizer::render(); a scene with signals does not use the inputs. [audio thread,
    /// wait-free]
    void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                int samples) noexcept AULA_NONBLOCKING {
        playback_.render(inputs, outputs, samples);
    }

    /// Sample time: of the next sample. [any thread]
    std::int64_t rendered_samples() const noexcept AULA_NONBLOCKING {
        return playback_.rendered_samples();
    }

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
