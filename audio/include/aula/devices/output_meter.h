#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

/// Cause of a gap in the output, as the durations of the preceding callbacks show it.
enum class UnderrunCause {
    rendering,    ///< a callback was late and computed for much of its block's duration
    scheduling,   ///< a callback was late but computed little: its thread was not scheduled
    sound_system  ///< all callbacks were in time: the sound system was late
};

/// A gap in the output.
struct Underrun {
    double time_s = 0;                                  ///< duration of the sound played before it
    UnderrunCause cause = UnderrunCause::sound_system;  ///< what was late
};

/// The cause of the lateness of a callback that took `wall_s`, `cpu_s` of it CPU time, for a block
/// that lasts `sound_s`. Empty if it was in time.
std::optional<UnderrunCause> lateness_cause(double wall_s, double cpu_s, double sound_s);

/// Measures the load and the underruns of an output. Getters may be called on any thread.
class OutputMeter {
 public:
    /// A meter for an output of that sample rate.
    explicit OutputMeter(double sample_rate_hz) : sample_rate_hz_(sample_rate_hz) {}

    /// To be called at the beginning of each callback. `underflow`: the sound system reports a gap.
    /// [audio thread; wait-free except the first call, which requests real-time priority]
    void begin(bool underflow) noexcept AULA_NONBLOCKING;

    /// To be called at the end of each callback, which has written `samples` samples.
    /// [audio thread, wait-free]
    void end(int samples) noexcept AULA_NONBLOCKING;

    /// Counts a callback that took `wall_s`, `cpu_s` of it CPU time. Called by end().
    /// [audio thread, wait-free]
    void count_call(double wall_s, double cpu_s, int samples) noexcept AULA_NONBLOCKING;

    /// To be called before another thread calls begin(), whose first call then requests real-time
    /// priority, for an output of that sample rate.
    void restart(double sample_rate_hz);

    /// Number of gaps of all causes.
    std::uint64_t underruns() const { return rendering_underruns_ + other_underruns_; }
    /// Number of gaps of the cause UnderrunCause::rendering.
    std::uint64_t rendering_underruns() const { return rendering_underruns_; }
    /// The first 64 gaps.
    std::vector<Underrun> first_underruns() const;

    /// Duration of the callbacks relative to their blocks, 1 at the limit, smoothed over 0.5 s.
    double load() const { return load_; }
    /// Total duration of the callbacks relative to that of their blocks.
    double mean_load() const;
    /// Largest duration of a callback relative to its block.
    double worst_load() const { return worst_load_; }

    /// True if the thread of the callbacks has real-time priority, and before the first callback.
    bool realtime() const { return realtime_; }

    /// Time since the end of the last callback, or since touch().
    std::chrono::steady_clock::duration silence() const;
    /// Restarts the time that silence() measures.
    void touch();

 private:
    using Clock = std::chrono::steady_clock;
    static_assert(std::atomic<double>::is_always_lock_free);

    double sample_rate_hz_;
    Clock::time_point start_;
    double cpu_start_s_ = 0;
    // Times of the newest late callbacks, samples; -1: none.
    std::int64_t late_rendering_at_ = -1;
    std::int64_t late_scheduling_at_ = -1;
    std::int64_t last_samples_ = 0;  ///< length of the last block
    std::atomic<bool> known_thread_{false};
    std::atomic<bool> realtime_{true};
    std::atomic<std::uint64_t> rendering_underruns_{0};
    std::atomic<std::uint64_t> other_underruns_{0};
    struct FirstUnderrun {
        std::atomic<double> time_s{0};
        std::atomic<UnderrunCause> cause{UnderrunCause::sound_system};
    };
    std::array<FirstUnderrun, 64> first_underruns_{};
    std::atomic<double> load_{0};
    std::atomic<double> worst_load_{0};
    std::atomic<double> busy_s_{0};
    std::atomic<std::int64_t> samples_{0};
    std::atomic<double> sound_s_{0};  ///< duration of these samples
    std::atomic<Clock::rep> last_call_{0};
};

}  // namespace aula
