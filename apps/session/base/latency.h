#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "audio/base/realtime.h"

namespace aula {

/// The clock of poses, frames and blocks as one number, to be handed from thread to thread.
inline std::int64_t clock_ns() noexcept AULA_NONBLOCKING {
    return std::chrono::steady_clock::now().time_since_epoch().count();
}
static_assert(std::chrono::steady_clock::period::den == 1'000'000'000);

/// How long things took, counted in steps of a tenth of a millisecond; what is longer than a
/// second counts as a second. One thread adds, wait-free; any thread reads.
class LatencyCounts {
 public:
    void add(std::int64_t ns) noexcept AULA_NONBLOCKING {
        const std::int64_t step = ns < 0 ? 0 : ns / kStep_ns;
        const std::size_t place =
            static_cast<std::size_t>(step) < kSteps ? static_cast<std::size_t>(step) : kSteps - 1;
        counts_[place].fetch_add(1, std::memory_order_relaxed);
    }

    /// The time that a share of all did not exceed, to the next step; 0 if there were none.
    double quantile_ms(double share) const {
        std::uint64_t total = 0;
        for (const auto& count : counts_) total += count;
        const auto wanted =
            static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total)));
        std::uint64_t sum = 0;
        for (std::size_t i = 0; i < kSteps && total > 0; ++i) {
            sum += counts_[i];
            if (sum >= wanted) return static_cast<double>(i + 1) * kStep_ns * 1e-6;
        }
        return 0;
    }

 private:
    static constexpr std::int64_t kStep_ns = 100'000;
    static constexpr std::size_t kSteps = 10000;
    std::array<std::atomic<std::uint32_t>, kSteps> counts_{};
};

/// How long after it was given a pose is heard, device latency left out.
struct PoseLatency {
    double frame_period_ms = 0;
    double compute_p50_ms = 0, compute_p99_ms = 0;
    double sound_p50_ms = 0, sound_p99_ms = 0;  ///< to the start of the crossfade
    double head_p50_ms = 0, head_p99_ms = 0;    ///< of the head's turning alone
    double call_p99_ms = 0;                     ///< from one call for sound to the next
};

}  // namespace aula
