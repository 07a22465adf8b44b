#pragma once

#include <cstddef>
#include <vector>

namespace aula {

/// The time axis of energy responses and caches: bins from 0 to at least `length_s`, 1 ms wide at
/// the start and wider later (2 ms from 64 ms, 4 from 128, 8 from 256, 16 from 1024, 32 from 2048,
/// 64 from 4096), as a late field varies slowly. `coarseness` multiplies every width.
class TimeBins {
   public:
    TimeBins() = default;
    explicit TimeBins(double length_s, int coarseness = 1);

    std::size_t count() const { return edges_s_.empty() ? 0 : edges_s_.size() - 1; }
    double begin_s(std::size_t bin) const { return edges_s_[bin]; }
    double end_s(std::size_t bin) const { return edges_s_[bin + 1]; }
    double length_s() const { return edges_s_.back(); }

    /// The bin that holds a time >= 0; count() at length_s() and beyond.
    std::size_t index(double time_s) const;

    friend bool operator==(const TimeBins&, const TimeBins&) = default;

   private:
    std::vector<double> edges_s_;
    std::vector<std::size_t> first_of_ms_;  ///< bin that holds the start of each millisecond
};

}  // namespace aula
