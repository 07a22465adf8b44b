#include "audio/output_meter.h"

#include <pthread.h>
#include <sched.h>

#include <algorithm>

namespace aula {

namespace {

constexpr double kLoadSmoothing_s = 0.5;

/// A server tells of a gap some time after it.
constexpr double kBlame_s = 0.2;

/// Below JACK's own threads (10 by default, its clients 5 below that) nothing is gained.
constexpr int kPriority = 60;

/// Asks for real-time priority unless this thread has it.
bool take_priority() noexcept {
    int policy = SCHED_OTHER;
    sched_param parameters{};
    if (pthread_getschedparam(pthread_self(), &policy, &parameters) == 0 &&
        (policy == SCHED_FIFO || policy == SCHED_RR)) {
        return true;
    }
    parameters.sched_priority = kPriority;
    return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

}  // namespace

void OutputMeter::begin(bool underflow) noexcept {
    start_ = Clock::now();
    if (!known_thread_.load(std::memory_order_relaxed)) {
        realtime_.store(take_priority(), std::memory_order_relaxed);
        known_thread_.store(true, std::memory_order_relaxed);
    }
    if (!underflow) return;
    const auto shortly = static_cast<std::int64_t>(kBlame_s * sample_rate_hz_);
    const bool ours =
        overrun_at_ >= 0 && samples_.load(std::memory_order_relaxed) - overrun_at_ <= shortly;
    const std::uint64_t count =
        ours_.load(std::memory_order_relaxed) + hosts_.load(std::memory_order_relaxed);
    if (count < times_.size()) {
        const double time_s =
            static_cast<double>(samples_.load(std::memory_order_relaxed)) / sample_rate_hz_;
        times_[count].store(ours ? -time_s : time_s, std::memory_order_relaxed);
    }
    (ours ? ours_ : hosts_).fetch_add(1, std::memory_order_release);
}

void OutputMeter::end(int samples) noexcept {
    const Clock::time_point end = Clock::now();
    const double busy_s = std::chrono::duration<double>(end - start_).count();
    const double sound_s = static_cast<double>(samples) / sample_rate_hz_;
    const double now = busy_s / sound_s;
    if (now > 1) overrun_at_ = samples_.load(std::memory_order_relaxed);
    const double before = load_.load(std::memory_order_relaxed);
    load_.store(before + std::min(1.0, sound_s / kLoadSmoothing_s) * (now - before),
                std::memory_order_relaxed);
    if (now > worst_load_.load(std::memory_order_relaxed)) {
        worst_load_.store(now, std::memory_order_relaxed);
    }
    busy_s_.store(busy_s_.load(std::memory_order_relaxed) + busy_s, std::memory_order_relaxed);
    samples_.store(samples_.load(std::memory_order_relaxed) + samples, std::memory_order_relaxed);
    last_call_.store(end.time_since_epoch().count(), std::memory_order_relaxed);
}

std::vector<Underrun> OutputMeter::first_underruns() const {
    std::vector<Underrun> all;
    const std::uint64_t kept = std::min<std::uint64_t>(underruns(), times_.size());
    for (std::size_t i = 0; i < kept; ++i) {
        const double time_s = times_[i];
        all.push_back({std::abs(time_s), time_s < 0});
    }
    return all;
}

double OutputMeter::mean_load() const {
    const std::int64_t samples = samples_;
    return samples > 0 ? busy_s_ * sample_rate_hz_ / static_cast<double>(samples) : 0;
}

std::chrono::steady_clock::duration OutputMeter::silence() const {
    return Clock::duration{Clock::now().time_since_epoch().count() - last_call_.load()};
}

void OutputMeter::touch() { last_call_ = Clock::now().time_since_epoch().count(); }

}  // namespace aula
