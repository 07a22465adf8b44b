#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace aula {

/// Schedules live frames at regular times of the sound that a device plays by its clock. Frame k is
/// computed during its period and due at the end of it. [propagation thread]
class FrameClock {
 public:
    using Clock = std::chrono::steady_clock;

    /// `time_s` of the sound have been played at `now`, when the first frame starts.
    explicit FrameClock(Clock::time_point now, double time_s = 0);

    /// Advances to the next frame, which lasts `frame_s`. It starts at the end of the present one.
    void next(double frame_s);

    /// Time of the current frame in the played sound, in s.
    double time_s() const { return time_s_; }

    /// Start of the current frame.
    Clock::time_point due() const { return at(time_s_); }

    /// When the current frame must be ready.
    Clock::time_point end() const { return at(time_s_ + frame_s_); }

    /// When the computation begins: before end() by the longest of the recent frames and 2 ms, so
    /// that it uses the newest pose.
    Clock::time_point begin() const;

    /// Skips to the newest frame whose time has come. Returns the number of skipped frames.
    std::uint64_t skip_missed(Clock::time_point now);

    /// Records the computation time of a frame, in s.
    void took(double seconds);

    /// Aligns the clock with the sound, of which `played_s` were played at `now`: gradually, since
    /// sound is played in blocks and device clocks drift; in one step if they are far apart, as
    /// after the loss of a device.
    void follow(double played_s, Clock::time_point now);

    /// Aligns the clock after a stop of the sound, of which `played_s` were played at `now`. The
    /// current frame keeps its time in the sound.
    void resume(double played_s, Clock::time_point now);

 private:
    Clock::time_point at(double seconds) const;

    Clock::time_point zero_;  ///< time zero of the sound
    double time_s_ = 0;
    double frame_s_ = 0;
    std::deque<double> recent_s_;
};

/// What run_frames() does with frames. [propagation thread]
class LiveFrames {
 public:
    virtual ~LiveFrames() = default;
    /// Waits for a time. False: no frame follows.
    virtual bool wait_until(FrameClock::Clock::time_point time) = 0;
    /// Publishes the newest frame, if there is one, and waits until no pause lasts. False: no frame
    /// follows.
    virtual bool publish_frame(FrameClock& clock) = 0;
    /// Notes that frame times were missed.
    virtual void skip_frames(std::uint64_t /*count*/) {}
    /// Computes the frame of the clock. Returns the computation time in s.
    virtual double compute_frame(FrameClock& clock) = 0;
};

/// At each frame time publishes the frame that was computed since the frame time before, then
/// computes the next one.
void run_frames(FrameClock& clock, double frame_s, LiveFrames& frames);

}  // namespace aula
