#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "audio/base/assume_nonblocking.h"
#include "aula/audio/realtime.h"

namespace aula {

/// The common clock of poses, frames and blocks, as an integer that can be passed between threads.
inline std::int64_t clock_ns() noexcept AULA_NONBLOCKING {
    // It reads a clock, if by a system call.
    return assume_nonblocking([] { return std::chrono::steady_clock::now(); })
        .time_since_epoch()
        .count();
}
static_assert(std::chrono::steady_clock::period::den == 1'000'000'000);

/// A histogram of durations in steps of a tenth of a millisecond; durations above a second count as
/// one second. One thread adds, wait-free; any thread reads.
class LatencyCounts {
 public:
    void add(std::int64_t ns) noexcept AULA_NONBLOCKING {
        const std::int64_t step = ns < 0 ? 0 : ns / kStep_ns;
        const std::size_t bin =
            static_cast<std::size_t>(step) < kSteps ? static_cast<std::size_t>(step) : kSteps - 1;
        counts_[bin].fetch_add(1, std::memory_order_relaxed);
    }

    /// The duration that a share of all entries did not exceed, rounded up to a step; empty if
    /// there are none.
    std::optional<double> quantile_ms(double share) const {
        std::uint64_t total = 0;
        for (const auto& count : counts_) total += count;
        const auto wanted =
            static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total)));
        std::uint64_t sum = 0;
        for (std::size_t i = 0; i < kSteps && total > 0; ++i) {
            sum += counts_[i];
            if (sum >= wanted) return static_cast<double>(i + 1) * kStep_ns * 1e-6;
        }
        return std::nullopt;
    }

 private:
    static constexpr std::int64_t kStep_ns = 100'000;
    static constexpr std::size_t kSteps = 10000;
    std::array<std::atomic<std::uint32_t>, kSteps> counts_{};
};

/// The latency from a new pose to its output, without the device's latency. A quantile is empty if
/// nothing has been measured.
struct PoseLatency {
    using Quantile_ms = std::optional<double>;

    double frame_period_ms = 0;
    Quantile_ms compute_p50_ms, compute_p99_ms;
    Quantile_ms sound_p50_ms, sound_p99_ms;  ///< to the start of the crossfade
    Quantile_ms head_p50_ms, head_p99_ms;    ///< of the head rotation alone
    Quantile_ms call_p99_ms;                 ///< between two calls for sound
};

}  // namespace aula
