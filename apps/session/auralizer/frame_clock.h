#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace aula {

/// When live frames are due: at even times of the sound, which a device plays by a clock of its
/// own. Frame k is taken up in the time of frame k and due, to be handed over, a frame later.
/// [propagation thread]
class FrameClock {
 public:
    using Clock = std::chrono::steady_clock;

    /// The sound begins now.
    explicit FrameClock(Clock::time_point now) : zero_(now) {}

    /// On to the next frame, `frame_s` after the one before.
    void next(double frame_s);

    /// The time of the frame in hand, of all sound that was played, in s.
    double time_s() const { return time_s_; }

    /// When the frame's time is.
    Clock::time_point due() const { return at(time_s_); }

    /// When it is to be handed over.
    Clock::time_point end() const { return at(time_s_ + frame_s_); }

    /// When its computation begins: as late as it can, so that it knows the newest pose and still
    /// is ready in time: before its end by the longest of the last frames and 2 ms.
    Clock::time_point begin() const;

    /// Goes on to the newest frame whose time has come; how many were left out.
    std::uint64_t leave_out_missed(Clock::time_point now);

    /// What a frame took to compute, in s.
    void took(double seconds);

    /// Follows the sound: `played_s` of it were played at `now`. A little at each call, as it is
    /// played in blocks and no device's clock is quite this one; if they are far apart, because a
    /// device is gone or has come back, at once: time waits for the sound.
    void follow(double played_s, Clock::time_point now);

 private:
    Clock::time_point at(double seconds) const;

    Clock::time_point zero_;  ///< where the sound's time zero lies
    double time_s_ = 0;
    double frame_s_ = 0;
    std::deque<double> recent_s_;
};

}  // namespace aula
