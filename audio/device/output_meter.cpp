#include "aula/devices/output_meter.h"

#include <time.h>

#include <algorithm>

#include "audio/base/assume_nonblocking.h"

namespace aula {

namespace {

constexpr double kLoadSmoothing_s = 0.5;

/// A server reports a gap with a delay of up to this.
constexpr double kReportDelay_s = 0.2;

/// The lateness of a callback that computed for more than this share of its block's duration is
/// attributed to rendering.
constexpr double kComputingShare = 0.5;

// Both only read a clock, if by a system call.
std::chrono::steady_clock::time_point clock_now() noexcept AULA_NONBLOCKING {
    return assume_nonblocking([] { return std::chrono::steady_clock::now(); });
}

/// CPU time of this thread.
double thread_cpu_s() noexcept AULA_NONBLOCKING {
    timespec time{};
    assume_nonblocking([&] { clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time); });
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

std::optional<UnderrunCause> lateness_cause(double wall_s, double cpu_s, double sound_s) {
    if (wall_s <= sound_s) return std::nullopt;
    return cpu_s > kComputingShare * sound_s ? UnderrunCause::rendering : UnderrunCause::scheduling;
}

void OutputMeter::begin(bool underflow) noexcept {
    start_ = clock_now();
    if (!known_thread_.load(std::memory_order_relaxed)) {
        // System calls that set attributes of this thread, once: none of them waits.
        const bool realtime = assume_nonblocking([] { return take_realtime_priority(); });
        realtime_.store(realtime, std::memory_order_relaxed);
        known_thread_.store(true, std::memory_order_relaxed);
    }
    cpu_start_s_ = thread_cpu_s();
    if (!underflow) return;
    const std::int64_t now = samples_.load(std::memory_order_relaxed);
    // Large blocks at low sample rates are longer than kReportDelay_s.
    const auto report_delay =
        std::max(static_cast<std::int64_t>(kReportDelay_s * sample_rate_hz_), 2 * last_samples_);
    const auto recent = [&](std::int64_t at) { return at >= 0 && now - at <= report_delay; };
    const UnderrunCause cause = recent(late_rendering_at_)    ? UnderrunCause::rendering
                                : recent(late_scheduling_at_) ? UnderrunCause::scheduling
                                                              : UnderrunCause::sound_system;
    const std::uint64_t count = rendering_underruns_.load(std::memory_order_relaxed) +
                                other_underruns_.load(std::memory_order_relaxed);
    if (count < first_underruns_.size()) {
        first_underruns_[count].time_s.store(sound_s_.load(std::memory_order_relaxed),
                                             std::memory_order_relaxed);
        first_underruns_[count].cause.store(cause, std::memory_order_relaxed);
    }
    (cause == UnderrunCause::rendering ? rendering_underruns_ : other_underruns_)
        .fetch_add(1, std::memory_order_release);
}

void OutputMeter::end(int samples) noexcept {
    const Clock::time_point end = clock_now();
    count_call(std::chrono::duration<double>(end - start_).count(), thread_cpu_s() - cpu_start_s_,
               samples);
    last_call_.store(end.time_since_epoch().count(), std::memory_order_relaxed);
}

void OutputMeter::count_call(double wall_s, double cpu_s, int samples) noexcept {
    const double sound_s = static_cast<double>(samples) / sample_rate_hz_;
    const double now = wall_s / sound_s;
    if (const auto cause = lateness_cause(wall_s, cpu_s, sound_s)) {
        (*cause == UnderrunCause::rendering ? late_rendering_at_ : late_scheduling_at_) =
            samples_.load(std::memory_order_relaxed);
    }
    const double before = load_.load(std::memory_order_relaxed);
    load_.store(before + std::min(1.0, sound_s / kLoadSmoothing_s) * (now - before),
                std::memory_order_relaxed);
    if (now > worst_load_.load(std::memory_order_relaxed)) {
        worst_load_.store(now, std::memory_order_relaxed);
    }
    busy_s_.store(busy_s_.load(std::memory_order_relaxed) + wall_s, std::memory_order_relaxed);
    samples_.store(samples_.load(std::memory_order_relaxed) + samples, std::memory_order_relaxed);
    sound_s_.store(sound_s_.load(std::memory_order_relaxed) + sound_s, std::memory_order_relaxed);
    last_samples_ = samples;
}

std::vector<Underrun> OutputMeter::first_underruns() const {
    std::vector<Underrun> all;
    const std::uint64_t kept = std::min<std::uint64_t>(underruns(), first_underruns_.size());
    for (std::size_t i = 0; i < kept; ++i)
        all.push_back({first_underruns_[i].time_s, first_underruns_[i].cause});
    return all;
}

double OutputMeter::mean_load() const {
    const double sound_s = sound_s_;
    return sound_s > 0 ? busy_s_ / sound_s : 0;
}

std::chrono::steady_clock::duration OutputMeter::silence() const {
    return Clock::duration{Clock::now().time_since_epoch().count() - last_call_.load()};
}

void OutputMeter::restart(double sample_rate_hz) {
    known_thread_ = false;
    sample_rate_hz_ = sample_rate_hz;
    // Times of the output before it.
    late_rendering_at_ = late_scheduling_at_ = -1;
}

void OutputMeter::touch() { last_call_ = Clock::now().time_since_epoch().count(); }

}  // namespace aula
