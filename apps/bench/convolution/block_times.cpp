#include "apps/bench/convolution/block_times.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>

#include "audio/base/aligned.h"

namespace aula::bench {

double time_us(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

void BlockTimes::round(bool all_threads, std::size_t warm_up,
                       const std::function<void()>& process) {
    const clockid_t clock = all_threads ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_THREAD_CPUTIME_ID;
    // Calls of the warm-up are timed as well, so that reading the clock is also warmed up.
    std::vector<double> times_us(warm_up + blocks_);
    double began_us = time_us(clock);
    for (double& spent_us : times_us) {
        process();
        const double ended_us = time_us(clock);
        spent_us = ended_us - began_us;
        began_us = ended_us;
    }
    times_us.erase(times_us.begin(), times_us.begin() + static_cast<std::ptrdiff_t>(warm_up));
    add(times_us);
}

void BlockTimes::add(const std::vector<double>& times_us) {
    assert(times_us.size() == blocks_);
    const double mean_us = std::accumulate(times_us.begin(), times_us.end(), 0.0) /
                           static_cast<double>(times_us.size());
    over_mean_.resize(blocks_);
    for (std::size_t i = 0; i < blocks_; ++i) over_mean_[i].push_back(times_us[i] / mean_us);
    mean_us_ = std::min(mean_us_, mean_us);
}

double BlockTimes::worst_over_mean() const {
    double worst = 0;
    for (std::vector<double> rounds : over_mean_) {
        const auto middle = rounds.begin() + static_cast<std::ptrdiff_t>(rounds.size() / 2);
        std::nth_element(rounds.begin(), middle, rounds.end());
        worst = std::max(worst, *middle);
    }
    return worst;
}

double read_time_us(double area_bytes, double bytes) {
    constexpr std::size_t kLanes = 64;
    const std::size_t count =
        (static_cast<std::size_t>(area_bytes) / sizeof(float) / kLanes + 1) * kLanes;
    const AlignedVector<float> area(count, 1.0F);
    double best_us = 1e9;
    volatile float sink = 0;
    for (int round = 0; round < 10; ++round) {
        const double began_us = time_us(CLOCK_THREAD_CPUTIME_ID);
        std::array<float, kLanes> sums{};
        for (std::size_t i = 0; i < count; i += kLanes) {
            for (std::size_t k = 0; k < kLanes; ++k) sums[k] += area[i + k];
        }
        best_us = std::min(best_us, time_us(CLOCK_THREAD_CPUTIME_ID) - began_us);
        for (const float sum : sums) sink = sink + sum;
    }
    static_cast<void>(sink);
    return best_us * bytes / static_cast<double>(count * sizeof(float));
}

}  // namespace aula::bench
