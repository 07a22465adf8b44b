#pragma once

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
#include <vector>

#include "apps/room/auralizer/change_queue.h"
#include "apps/room/auralizer/frame_computer.h"
#include "apps/room/auralizer/pause_fade.h"
#include "apps/room/auralizer/room_renderer.h"
#include "apps/room/auralizer/source_register.h"
#include "apps/room/auralizer/source_slots.h"
#include "aula/auralizer.h"

namespace aula {

/// Playback of a room: the changes made by commands, the frames computed from them and the
/// renderer. The base class of both clocks. Commands are those of Auralizer, with checked
/// arguments.
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
    void set_paused(bool paused) { pause_.set_paused(paused); }
    virtual void commit(std::int64_t /*until*/) {}
    AuralizerStatus status() const;
    const FrameComputer& computer() const { return computer_; }
    std::int64_t tail_samples() const { return tail_samples_.load(); }
    double heard_length_s() const { return computer_.response_length_s() + headphones_s(); }

    /// See Auralizer::impulse_response().
    std::vector<std::vector<float>> impulse_response(SourceId source, std::size_t listener) const;

    virtual int latency_samples() const = 0;
    virtual void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                        int samples) = 0;

 protected:
    /// `block`: the largest number of samples that the renderer processes together. `hrtf`: that of
    /// the options, or null to read it.
    RoomPlayback(const Scene& scene, const AuralizerOptions& options, int block,
                 std::shared_ptr<const Hrtf> hrtf);

    // [propagation thread]
    virtual void compute_frames(Auralizer& auralizer) = 0;

    /// Calls AuralizerOptions::before_frame; changes that it makes have this sample time.
    void call_before_frame(Auralizer& auralizer, std::int64_t sample, double time_s);

    /// Applies all changes up to a sample to the room. Sources that have rung out at sample `now`
    /// end.
    void apply_changes(std::int64_t until, std::int64_t now, double time_s);

    /// The same, and returns the room for a frame.
    FrameRoom take_changes(std::int64_t until, std::int64_t now, double time_s);

    /// tail_samples() of the frame that was computed last.
    std::int64_t newest_tail_samples() const;

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

    const double rate_hz_;
    const std::function<void(Auralizer&, double)> before_frame_;
    const std::shared_ptr<const HeadphoneFilter> headphones_;  ///< null: none
    FrameComputer computer_;
    RoomRenderer renderer_;                   ///< used by the rendering thread
    SourceSlots renderer_slots_;              ///< the assignment last sent to the renderer
    PauseFade pause_;                         ///< used by the rendering thread
    std::atomic<std::int64_t> rendered_ = 0;  ///< samples
    std::atomic<std::int64_t> tail_samples_;  ///< of the newest frame that is rendered

    mutable std::mutex mutex_;  ///< of what follows
    std::condition_variable changed_;
    bool stop_ = false;
    std::exception_ptr failure_;                ///< of the propagation thread
    std::optional<std::int64_t> frame_sample_;  ///< while before_frame is called

 private:
    std::int64_t tail_of(double longest_delay_s) const;
    double headphones_s() const;

    std::thread::id frame_thread_;  ///< protected by the mutex, like the following members
    SourceRegister sources_;
    ChangeQueue<FrameRoom> changes_;
    FrameRoom room_;  ///< with all changes up to the newest frame; used by the propagation thread
};

}  // namespace aula
