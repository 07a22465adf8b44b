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

/// Plays a room on the real-time clock: frames are computed at regular times, and the renderer
/// takes the newest frame, routes and head poses from mailboxes.
class RealTimePlayback : public RoomPlayback, private LiveFrames {
 public:
    RealTimePlayback(std::shared_ptr<BuiltRoom> first, const AuralizerOptions& options);

    int latency_samples() const override { return 0; }
    void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                int samples) noexcept AULA_NONBLOCKING override;

    /// Functions that follow the frames; empty ones are not called. [propagation thread]
    struct Hooks {
        /// Time of the sound that the frames follow, in s; empty: the rendered time.
        std::function<double()> played_s{};
        /// After a frame, with the time until it is due, except the first frame of a scene.
        std::function<void(const FrameMaker& maker, double spare_s)> after_frame{};
        /// Before and after the first frame of a scene that replaces another one.
        std::function<void()> scene_begins{};
        std::function<void(const FrameMaker& maker)> scene_has_begun{};
    };

    // See LiveAuralizer. [before the frames start]
    void begin_at(std::int64_t sample) { rendered_ = sample; }
    std::shared_ptr<BuiltRoom> first() { return built(); }
    const FrameMaker& compute_first(double time_s);
    void set_hooks(Hooks hooks) { hooks_ = std::move(hooks); }

    /// Waits until the first frame of a scene, given by its number, or of a later one has been
    /// handed over, or no frame follows. [not the propagation thread]
    void wait_for(std::uint64_t scene);

    /// Frees the engine. [after the frames have ended]
    void free_engine() { computer().end(); }

    // See LiveAuralizer. [any thread]
    std::int64_t rendered_samples() const noexcept AULA_NONBLOCKING {
        return rendered_.load(std::memory_order_relaxed);
    }

    // See LiveAuralizer. [rendering thread]
    std::int64_t frame_pose_ns() const noexcept AULA_NONBLOCKING {
        const SoundingRoom* const room = exchange_.playing();
        return room != nullptr ? room->renderer.newest_stamp(0) : 0;
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
    void announce_scene() override;
    void take_scene(SoundingRoom& next) override;
    static void publish_routes(SoundingRoom& room);
    std::vector<std::unique_ptr<SoundingRoom>> take_silent_rooms();
    void note_scene();

    bool wait_until(Clock::time_point time) override;
    bool publish_frame(FrameClock& clock) override;
    void skip_frames(std::uint64_t count) override { computer().count_skipped_frames(count); }
    double compute_frame(FrameClock& clock) override;
    bool wait_out_pause(FrameClock& clock);
    double played_s() const;
    ListenerFrames compute(double time_s, bool is_first);
    void publish(ListenerFrames frames);
    void publish_head(std::size_t listener, const Pose& pose);
    void take_commands(SoundingRoom& room) noexcept AULA_NONBLOCKING;

    // Used by the propagation thread.
    Hooks hooks_;
    std::int64_t frame_due_ns_ = 0;  ///< due time of the present frame
    Auralizer* auralizer_ = nullptr;
    ListenerFrames computed_;  ///< not yet published; empty: none

    // Used by the rendering thread.
    std::int64_t head_pose_ns_ = 0;  ///< of the first listener's newest pose
    const int block_;
    std::vector<float*> part_outputs_;

    // Guarded by the mutex.
    bool running_ = false;                          ///< frames are computed at their times
    bool scene_waits_ = false;                      ///< another scene is to begin
    std::uint64_t heard_scene_ = 0;                 ///< number of the newest that has begun
    std::vector<SoundingRoom*> sounding_;           ///< all that sound or are to; the newest last
    std::vector<std::optional<Pose>> frame_heads_;  ///< [listener] poses for the next frame
};

}  // namespace aula
