#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "apps/room/auralizer/built_room.h"
#include "apps/room/auralizer/change_queue.h"
#include "apps/room/auralizer/frame_computer.h"
#include "apps/room/auralizer/sounding_room.h"
#include "apps/room/auralizer/source_register.h"
#include "apps/room/base/pause_fade.h"
#include "apps/room/base/room_exchange.h"
#include "aula/auralizer.h"

namespace aula {

/// Playback of a room: the changes made by commands, the frames computed from them and the
/// renderers of the scenes that sound. The base class of both clocks. Commands are those of
/// Auralizer, with checked arguments.
class RoomPlayback {
 public:
    virtual ~RoomPlayback() = default;
    RoomPlayback(const RoomPlayback&) = delete;
    RoomPlayback& operator=(const RoomPlayback&) = delete;

    /// Computes frames until stop(). [propagation thread]
    void run(Auralizer& auralizer);
    void stop();

    // Commands have no effect after a failure of the propagation. [any thread]
    SourceId add_source(const NewSource& source, std::int64_t at);
    void remove_source(SourceId source, std::int64_t at);
    std::vector<SourceId> sources() const;
    void change_source(SourceId source, std::int64_t at, std::function<void(SourceState&)> change);
    void set_listener(std::size_t listener, const Pose& pose, std::int64_t at);
    void change_room(std::int64_t at, std::function<void(FrameRoom&)> change);
    /// A change of a scene, given by its number: without effect in another one.
    void change_scene(std::uint64_t number, std::int64_t at,
                      std::function<void(FrameRoom&)> change);
    /// Exchanges the scene from the first frame at or after a time on. Returns its number.
    std::uint64_t begin_scene(std::shared_ptr<BuiltRoom> next, std::int64_t at);
    void set_paused(bool paused) { pause_.set_paused(paused); }
    virtual void commit(std::int64_t /*until*/) {}
    AuralizerStatus status() const;
    /// A scene with its number, in the order of begin_scene(); the first one has 0.
    struct NumberedScene {
        std::shared_ptr<const Scene> scene;
        std::uint64_t number = 0;
    };
    /// The scene to which a command for a time refers.
    NumberedScene scene_at(std::int64_t at) const;
    /// The scene of the newest frame.
    std::shared_ptr<const BuiltRoom> present() const;
    /// The present room as another scene has it before its first frame.
    RoomState state_in(const BuiltRoom& next) const;
    std::int64_t tail_samples() const {
        return std::max(tail_samples_.load(), exchange_.tail_samples());
    }

    /// See Auralizer::impulse_response().
    std::vector<std::vector<float>> impulse_response(SourceId source, std::size_t listener) const;

    virtual int latency_samples() const = 0;
    virtual void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                        int samples) = 0;

 protected:
    /// `block`: the largest number of samples of render_rooms().
    RoomPlayback(std::shared_ptr<BuiltRoom> first, const AuralizerOptions& options, int block);

    // [propagation thread]
    virtual void compute_frames(Auralizer& auralizer) = 0;

    /// Calls AuralizerOptions::before_frame; changes that it makes have this sample time.
    void call_before_frame(Auralizer& auralizer, std::int64_t sample, double time_s);

    /// Applies all changes up to a sample to the room, unless another scene begins with them.
    /// Sources that have rung out at sample `now` end. Returns whether they were applied.
    bool apply_changes(std::int64_t until, std::int64_t now, double time_s);

    /// The same, also if a scene begins, provided that one may, and returns the room for a frame;
    /// none if the changes were not applied.
    std::optional<FrameRoom> take_changes(std::int64_t until, std::int64_t now, double time_s,
                                          bool may_begin_scene = true);

    /// tail_samples() of the frame that was computed last.
    std::int64_t newest_tail_samples() const;

    // Of the frame whose changes have been taken last.
    const std::shared_ptr<BuiltRoom>& built() { return built_; }
    std::uint64_t scene_number() const { return room_.scene; }
    FrameComputer& computer() { return built_->computer; }
    SoundingRoom& newest() { return *built_->sounding; }

    /// Whether another scene has begun with those changes.
    bool scene_begins() const { return built_ != present_; }

    /// Its first frame has been computed: frees the scene before it.
    void finish_beginning();

    /// Renders at most a block of samples, from `offset` of the inputs on, and overwrites the
    /// outputs. `weights`: a factor for each sample of the inputs, or empty. [rendering thread]
    void render_rooms(std::span<const SourceSignal> inputs, int offset,
                      std::span<const float> weights, std::span<float* const> outputs,
                      int samples) noexcept AULA_NONBLOCKING;

    // With the mutex locked:
    bool in_before_frame() const {
        return frame_sample_.has_value() && std::this_thread::get_id() == frame_thread_;
    }
    /// When a change that is made now takes effect.
    virtual ChangeTime time_of(std::int64_t at) const = 0;
    // Tell the renderer.
    virtual void begin_source(SourceId source, const ChangeTime& time) = 0;
    virtual void end_source(SourceId source, const ChangeTime& time) = 0;
    virtual void turn_head(std::size_t listener, const Pose& pose, const ChangeTime& time) = 0;
    /// The time of a pose that is set now (clock_ns()); 0 if its latency does not count.
    virtual std::int64_t pose_ns() const { return 0; }
    /// Tells the propagation thread that a scene is to begin.
    virtual void announce_scene() {}
    /// Another scene begins with the changes that are taken.
    virtual void take_scene(SoundingRoom& /*next*/) {}

    const double rate_hz_;
    const std::size_t listeners_;
    const std::function<void(Auralizer&, double)> before_frame_;
    Mailbox<SoundingRoom> rooms_{RoomExchange<SoundingRoom>::kMaxHeld};
    PauseFade pause_;                         ///< used by the rendering thread
    RoomExchange<SoundingRoom> exchange_;     ///< used by the rendering thread
    std::atomic<std::int64_t> rendered_ = 0;  ///< samples
    std::atomic<std::int64_t> tail_samples_;  ///< of the newest frame that is rendered

    mutable std::mutex mutex_;  ///< of what follows
    std::condition_variable changed_;
    bool stop_ = false;
    std::exception_ptr failure_;                ///< of the propagation thread
    std::optional<std::int64_t> frame_sample_;  ///< while before_frame is called

 private:
    /// A scene, and from when on commands refer to it.
    struct SceneTime {
        ChangeTime begin;
        std::uint64_t number = 0;
        std::shared_ptr<BuiltRoom> built;
    };

    const SceneTime& scene_of(const ChangeTime& time) const;
    bool apply(std::int64_t until, std::int64_t now, double time_s, bool may_begin_scene);

    // Used by the rendering thread.
    std::atomic<std::int64_t> muted_ = 0;  ///< samples
    std::vector<std::vector<float>> room_outputs_;
    std::vector<float*> room_pointers_;
    std::vector<float> room_weights_;

    std::thread::id frame_thread_;  ///< protected by the mutex, like the following members
    SourceRegister sources_;
    ChangeQueue<FrameRoom> changes_;
    std::uint64_t last_scene_ = 0;
    std::vector<SceneTime> scenes_;       ///< the present one and those that are to begin
    std::vector<SceneTime> ended_;        ///< until finish_beginning()
    std::uint64_t frame_scene_ = 0;       ///< to which commands of before_frame refer
    FrameRoom room_;                      ///< with all changes up to the newest frame
    std::shared_ptr<BuiltRoom> built_;    ///< see built(); the propagation thread changes both
    std::shared_ptr<BuiltRoom> present_;  ///< of the newest frame that is computed
};

}  // namespace aula
