#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "audio/base/realtime.h"

namespace aula {

/// Why there was a gap in the output, by what the calls shortly before took.
enum class UnderrunCause {
    ours,     ///< one was late and had computed for a good part of the time that its sound lasts
    machine,  ///< one was late though it computed little: its thread was not run
    host      ///< all were in time: the sound system came late itself
};

/// A gap in the output.
struct Underrun {
    double time_s = 0;  ///< sound played until then
    UnderrunCause cause = UnderrunCause::host;
};

/// Who is to blame for a call that took `wall_s` for sound of `sound_s`, its thread being run for
/// `cpu_s` of it: ours, the machine, or nobody where it was in time.
std::optional<UnderrunCause> lateness_cause(double wall_s, double cpu_s, double sound_s);

/// Counts what happens on a device's thread; everybody may read.
class OutputMeter {
 public:
    explicit OutputMeter(double sample_rate_hz) : sample_rate_hz_(sample_rate_hz) {}

    /// Around each call for sound. [audio thread, wait-free but for the first call of a thread,
    /// which asks for real-time priority]
    void begin(bool underflow) noexcept AULA_NONBLOCKING;
    void end(int samples) noexcept AULA_NONBLOCKING;

    /// What end() counts: a call that took `wall_s`, its thread being run for `cpu_s` of it.
    /// [audio thread, wait-free]
    void count_call(double wall_s, double cpu_s, int samples) noexcept AULA_NONBLOCKING;

    /// A new thread calls from now on.
    void restart() { known_thread_ = false; }

    std::uint64_t underruns() const { return ours_ + others_; }
    std::uint64_t own_underruns() const { return ours_; }
    std::vector<Underrun> first_underruns() const;  ///< as many as are kept

    double load() const { return load_; }  ///< share of the time that sound takes, smoothed
    double mean_load() const;
    double worst_load() const { return worst_load_; }

    /// False where the system refused it; true as long as no call came.
    bool realtime() const { return realtime_; }

    std::chrono::steady_clock::duration silence() const;  ///< since the last call
    void touch();                                         ///< begins that time anew

 private:
    using Clock = std::chrono::steady_clock;
    static_assert(std::atomic<double>::is_always_lock_free);

    double sample_rate_hz_;
    Clock::time_point start_;
    double cpu_start_s_ = 0;
    // The newest late calls, in samples; -1: none.
    std::int64_t ours_at_ = -1;
    std::int64_t machines_at_ = -1;
    std::int64_t last_samples_ = 0;  ///< of the last call
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
