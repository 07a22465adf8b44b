#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

/// Cause of a gap in the output, from the durations of the preceding callbacks.
enum class UnderrunCause {
    ours,     ///< a callback was late and computed for much of its block's duration
    machine,  ///< a callback was late but computed little: its thread was not scheduled
    host      ///< all callbacks were in time: the sound system was late
};

/// A gap in the output.
struct Underrun {
    double time_s = 0;  ///< duration of the sound played before
    UnderrunCause cause = UnderrunCause::host;
};

/// The cause of the lateness of a callback that took `wall_s` for a block of `sound_s`, with
/// `cpu_s` of CPU time. None if it was in time.
std::optional<UnderrunCause> lateness_cause(double wall_s, double cpu_s, double sound_s);

/// Measures the load and the underruns of an output. Getters may be called on any thread.
class OutputMeter {
 public:
    explicit OutputMeter(double sample_rate_hz) : sample_rate_hz_(sample_rate_hz) {}

    /// Called at the beginning and the end of each callback. `underflow`: the sound system reports
    /// a gap. [audio thread; wait-free except a thread's first call, which requests real-time
    /// priority]
    void begin(bool underflow) noexcept AULA_NONBLOCKING;
    void end(int samples) noexcept AULA_NONBLOCKING;

    /// Counts a callback that took `wall_s`, with `cpu_s` of CPU time. Called by end().
    /// [audio thread, wait-free]
    void count_call(double wall_s, double cpu_s, int samples) noexcept AULA_NONBLOCKING;

    /// Must be called before another thread calls begin().
    void restart() { known_thread_ = false; }

    std::uint64_t underruns() const { return ours_ + others_; }
    std::uint64_t own_underruns() const { return ours_; }
    std::vector<Underrun> first_underruns() const;  ///< the first 64

    double load() const { return load_; }  ///< duration of callbacks re their blocks, smoothed
    double mean_load() const;
    double worst_load() const { return worst_load_; }

    /// Whether the thread has real-time priority; true before the first callback.
    bool realtime() const { return realtime_; }

    std::chrono::steady_clock::duration silence() const;  ///< time since the last callback
    void touch();                                         ///< restarts that time

 private:
    using Clock = std::chrono::steady_clock;
    static_assert(std::atomic<double>::is_always_lock_free);

    double sample_rate_hz_;
    Clock::time_point start_;
    double cpu_start_s_ = 0;
    // Times of the newest late callbacks, samples; -1: none.
    std::int64_t ours_at_ = -1;
    std::int64_t machines_at_ = -1;
    std::int64_t last_samples_ = 0;  ///< length of the last block
    std::atomic<bool> known_thread_{false};
    std::atomic<bool> realtime_{true};
    std::atomic<std::uint64_t> ours_{0};
    std::atomic<std::uint64_t> others_{0};
    struct Kept {
        std::atomic<double> time_s{0};
        std::atomic<UnderrunCause> cause{UnderrunCause::host};
    };
    std::array<Kept, 64> kept_{};
    std::atomic<double> load_{0};
    std::atomic<double> worst_load_{0};
    std::atomic<double> busy_s_{0};
    std::atomic<std::int64_t> samples_{0};
    std::atomic<Clock::rep> last_call_{0};
};

}  // namespace aula
