#pragma once

#include <time.h>

#include <cstddef>
#include <functional>
#include <limits>
#include <vector>

namespace aula::bench {

/// A clock in us; of CPU time for blocks, which are far shorter than the slices of time in which a
/// busy machine takes the processor away.
double time_us(clockid_t clock);

/// Blocks timed in several rounds, the same blocks in each. The mean is that of the best round. A
/// block costs, against the mean of its round, the median of all rounds: what others did to the
/// machine meanwhile, at one time or for whole rounds, is left out, what the convolver does
/// unevenly is not.
class BlockTimes {
 public:
    explicit BlockTimes(std::size_t blocks) : blocks_(blocks) {}

    /// Processes some blocks that do not count, then all, by the CPU time of this thread or of all.
    void round(bool all_threads, std::size_t warm_up, const std::function<void()>& process);

    /// A round's times in us.
    void add(const std::vector<double>& times_us);

    double mean_us() const { return mean_us_; }
    double worst_over_mean() const;  ///< of the block that costs most

 private:
    std::size_t blocks_;
    std::vector<std::vector<double>> over_mean_;  ///< [block][round]
    double mean_us_ = std::numeric_limits<double>::infinity();
};

/// Time for reading `bytes` out of an area that is read again and again, by summing it up: the
/// machine's bandwidth at that size. In us.
double read_time_us(double area_bytes, double bytes);

}  // namespace aula::bench
