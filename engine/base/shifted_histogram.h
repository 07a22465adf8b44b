#pragma once

#include <vector>

#include "aula/engine/bands.h"
#include "aula/engine/direction_moments.h"
#include "aula/engine/time_bins.h"

namespace aula {

/// Energies and their directions over time bins.
struct TimeHistogram {
    const float* energy = nullptr;      ///< [bin][band]
    const float* directions = nullptr;  ///< [bin][moment], see DirectionMoments; or null
    Bands total;                        ///< over bins
};

/// A sum of histograms, each delayed. Energy is uniform in time inside a bin. A delayed bin divides
/// its energy between the bins that it overlaps, in proportion to the overlaps. Bins do not become
/// narrower with time, so these are two at most. Energy after the last bin is lost.
class ShiftedHistogram {
 public:
    /// The bins must outlive the histogram.
    explicit ShiftedHistogram(const TimeBins& bins);

    /// Adds bins [first_bin, end_bin) of a histogram of the same bins, delayed by `delay_s` >= 0
    /// and multiplied by `weight`. The directions are those of the histogram, with the mean weight
    /// over its total; or, if it has none, `directions` of unit energy.
    void add(const TimeHistogram& histogram, std::size_t first_bin, std::size_t end_bin,
             double delay_s, const Bands& weight, const DirectionMoments& directions);

    Bands energy(std::size_t bin) const;

    DirectionMoments directions(std::size_t bin) const;

 private:
    /// Consecutive bins of equal width.
    struct Region {
        std::size_t first_bin = 0;
        std::size_t end_bin = 0;
        float width_s = 0;
    };

    const TimeBins& bins_;
    std::vector<Region> regions_;

    // One bin more than the bins receives the overflow at the end.
    std::vector<float> energy_;      ///< [bin][band]
    std::vector<float> directions_;  ///< [bin][moment]
};

}  // namespace aula
