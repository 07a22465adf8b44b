#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace aula {

/// The time axis of energy responses and caches: adjacent bins from time 0 on. Bins are 1 ms wide
/// at the start and wider later, where the field varies slowly: 2 ms from 64 ms on, 4 ms from 128
/// ms, 8 ms from 256 ms, 16 ms from 1024 ms, 32 ms from 2048 ms, 64 ms from 4096 ms.
class TimeBins {
 public:
    /// No bins.
    TimeBins() = default;

    /// Bins up to at least `length_s` > 0. `coarseness` >= 1 multiplies every width.
    explicit TimeBins(double length_s, int coarseness = 1);

    /// Number of bins.
    std::size_t count() const { return edges_s_.empty() ? 0 : edges_s_.size() - 1; }
    /// Start of a bin; it belongs to the bin. `bin` < count() is not checked.
    double begin_s(std::size_t bin) const { return edges_s_[bin]; }
    /// End of a bin, the start of the next. `bin` < count() is not checked.
    double end_s(std::size_t bin) const { return edges_s_[bin + 1]; }
    /// End of the last bin; 0 without bins.
    double length_s() const { return edges_s_.empty() ? 0 : edges_s_.back(); }

    /// The bin that contains a time >= 0; count() from length_s() on.
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

    /// True if all bins are the same.
    friend bool operator==(const TimeBins&, const TimeBins&) = default;

 private:
    std::vector<double> edges_s_;
    std::vector<std::uint32_t> bin_of_ms_;  ///< [millisecond], including that at length_s()
};

}  // namespace aula
