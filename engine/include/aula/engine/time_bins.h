#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace aula {

/// The time axis of energy responses and caches: bins from 0 to at least `length_s`. Bins are 1 ms
/// wide at the start and wider later, where the field varies slowly: 2 ms from 64 ms on, 4 from
/// 128, 8 from 256, 16 from 1024, 32 from 2048, 64 from 4096. `coarseness` multiplies every width.
class TimeBins {
 public:
    TimeBins() = default;

    /// `length_s` > 0, `coarseness` >= 1.
    explicit TimeBins(double length_s, int coarseness = 1);

    std::size_t count() const { return edges_s_.empty() ? 0 : edges_s_.size() - 1; }
    double begin_s(std::size_t bin) const { return edges_s_[bin]; }
    double end_s(std::size_t bin) const { return edges_s_[bin + 1]; }
    double length_s() const { return edges_s_.empty() ? 0 : edges_s_.back(); }

    /// The bin that contains a time >= 0; count() at length_s() and beyond.
    std::size_t index(double time_s) const {
        if (!(time_s < length_s())) return count();
        // Every edge is a multiple of 1 ms, so each millisecond belongs to one bin. The product can
        // round across an edge; the comparison with the edges corrects it.
        std::size_t bin = bin_of_ms_[static_cast<std::size_t>(time_s * 1000)];
        if (time_s < edges_s_[bin]) {
            --bin;
        } else if (time_s >= edges_s_[bin + 1]) {
            ++bin;
        }
        return bin;
    }

    friend bool operator==(const TimeBins&, const TimeBins&) = default;

 private:
    std::vector<double> edges_s_;
    std::vector<std::uint32_t> bin_of_ms_;  ///< [millisecond], including that at length_s()
};

}  // namespace aula
