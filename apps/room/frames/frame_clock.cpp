#include "apps/room/frames/frame_clock.h"

#include <algorithm>
#include <cmath>

namespace aula {

namespace {

// Correcting a fiftieth of the deviation per frame leaves less than 0.1 ms of the jitter caused by
// playback in blocks.
constexpr double kCorrection = 0.02;

// A larger deviation from the sound means that the device is lost, or was.
constexpr double kLost_s = 0.5;

constexpr double kMargin_s = 0.002;
constexpr std::size_t kRecent = 30;

FrameClock::Clock::duration duration_of(double seconds) {
    return std::chrono::duration_cast<FrameClock::Clock::duration>(
        std::chrono::duration<double>(seconds));
}

}  // namespace

FrameClock::FrameClock(Clock::time_point now, double time_s)
    : zero_(now - duration_of(time_s)), time_s_(time_s) {}

void FrameClock::next(double frame_s) {
    time_s_ += frame_s_;
    frame_s_ = frame_s;
}

FrameClock::Clock::time_point FrameClock::at(double seconds) const {
    return zero_ + duration_of(seconds);
}

FrameClock::Clock::time_point FrameClock::begin() const {
    double longest_s = kMargin_s;
    for (const double s : recent_s_) longest_s = std::max(longest_s, s);
    return end() - duration_of(longest_s + kMargin_s);
}

std::uint64_t FrameClock::skip_missed(Clock::time_point now) {
    const double now_s = std::chrono::duration<double>(now - zero_).count();
    const double missed = std::max(0.0, std::floor((now_s - time_s_) / frame_s_));
    time_s_ += missed * frame_s_;
    return static_cast<std::uint64_t>(missed);
}

void FrameClock::took(double seconds) {
    recent_s_.push_back(seconds);
    if (recent_s_.size() > kRecent) recent_s_.pop_front();
}

void FrameClock::resume(double played_s, Clock::time_point now) {
    zero_ = now - duration_of(played_s);
}

void FrameClock::follow(double played_s, Clock::time_point now) {
    const double ahead_s = played_s - std::chrono::duration<double>(now - zero_).count();
    const bool lost = std::abs(ahead_s) > kLost_s;
    if (lost) time_s_ += ahead_s;
    zero_ -= duration_of((lost ? 1 : kCorrection) * ahead_s);
}

void run_frames(FrameClock& clock, double frame_s, LiveFrames& frames) {
    for (;;) {
        clock.next(frame_s);
        if (!frames.wait_until(clock.due()) || !frames.publish_frame(clock)) return;
        if (const std::uint64_t missed = clock.skip_missed(FrameClock::Clock::now()); missed > 0)
            frames.skip_frames(missed);
        if (!frames.wait_until(clock.begin())) return;
        clock.took(frames.compute_frame(clock));
    }
}

}  // namespace aula
