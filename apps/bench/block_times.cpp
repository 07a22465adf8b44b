#include "apps/bench/block_times.h"

#include <algorithm>
#include <array>

#include "audio/aligned.h"

namespace aula::bench {

double time_us(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

void BlockTimes::round(bool all_threads, std::size_t warm_up,
                       const std::function<void()>& process) {
    const clockid_t clock = all_threads ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_THREAD_CPUTIME_ID;
    for (std::size_t i = 0; i < warm_up; ++i) process();
    const double round_began_us = time_us(clock);
    double began_us = round_began_us;
    for (double& least_us : least_us_) {
        process();
        const double ended_us = time_us(clock);
        least_us = std::min(least_us, ended_us - began_us);
        began_us = ended_us;
    }
    mean_us_ =
        std::min(mean_us_, (began_us - round_began_us) / static_cast<double>(least_us_.size()));
}

double BlockTimes::worst_us() const {
    return *std::max_element(least_us_.begin(), least_us_.end());
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
