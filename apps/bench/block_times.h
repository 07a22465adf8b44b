#pragma once

#include <time.h>

#include <cstddef>
#include <functional>
#include <vector>

namespace aula::bench {

/// A clock in us; of CPU time for blocks, which are far shorter than the slices of time in which a
/// busy machine takes the processor away.
double time_us(clockid_t clock);

/// Blocks timed in several rounds. The mean is that of the best round. The worst block is the worst
/// of the least times that each block took in any round: what others did to the machine meanwhile
/// is left out, what the convolver does unevenly is not.
class BlockTimes {
 public:
    explicit BlockTimes(std::size_t blocks) : least_us_(blocks, kNever_us) {}

    /// Processes some blocks untimed, then all, by the CPU time of this thread or of all.
    void round(bool all_threads, std::size_t warm_up, const std::function<void()>& process);

    double mean_us() const { return mean_us_; }
    double worst_us() const;

 private:
    static constexpr double kNever_us = 1e9;
    std::vector<double> least_us_;
    double mean_us_ = kNever_us;
};

/// Time for reading `bytes` out of an area that is read again and again, by summing it up: the
/// machine's bandwidth at that size. In us.
double read_time_us(double area_bytes, double bytes);

}  // namespace aula::bench
