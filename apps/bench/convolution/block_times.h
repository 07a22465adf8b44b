#pragma once

#include <time.h>

#include <cstddef>
#include <functional>
#include <limits>
#include <vector>

namespace aula::bench {

/// A clock in us. Blocks need a clock of CPU time: they are far shorter than the time slices of a
/// busy machine.
double time_us(clockid_t clock);

/// Times of the same blocks in several rounds. The mean is that of the best round. The cost of a
/// block, relative to the mean of its round, is the median over the rounds: this excludes
/// disturbances by other programs and keeps the unevenness of the convolver.
class BlockTimes {
 public:
    explicit BlockTimes(std::size_t blocks) : blocks_(blocks) {}

    /// Processes `warm_up` blocks that do not count, then all blocks, in CPU time of this thread or
    /// of all threads.
    void round(bool all_threads, std::size_t warm_up, const std::function<void()>& process);

    /// Adds the times of a round, in us.
    void add(const std::vector<double>& times_us);

    double mean_us() const { return mean_us_; }
    double worst_over_mean() const;  ///< of the most expensive block

 private:
    std::size_t blocks_;
    std::vector<std::vector<double>> over_mean_;  ///< [block][round]
    double mean_us_ = std::numeric_limits<double>::infinity();
};

/// Time to read `bytes` of an area that is summed repeatedly, in us: the memory bandwidth at that
/// size.
double read_time_us(double area_bytes, double bytes);

}  // namespace aula::bench
