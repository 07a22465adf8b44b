#pragma once

#include <cstddef>
#include <vector>

#include "aula/audio/convolver.h"

namespace aula {

/// A sequence of filter partitions of equal size.
struct PartitionLevel {
    std::size_t size = 0;       ///< taps per partition
    std::size_t first_tap = 0;  ///< 0, or 2 size: one segment to receive, one to compute
    std::size_t count = 0;      ///< number of partitions
    bool half_precision = false;

    std::size_t end_tap() const { return first_tap + count * size; }

    /// Whether the level begins segments within the fade of an exchange, with both filters.
    bool blends() const;
};

/// The largest partitions of which a level blends filters. Longer segments, of more than half the
/// usual time between exchanges, go from one filter to another one: with two filters at each end
/// they would have twice the products, 1.6 times the cost of the whole convolution
/// (`aula-bench convolve --ir-length 2 --block 128`), and the lines beside tones would be 1 dB
/// lower (`test_room "A walk in a live room*" -s`).
inline constexpr std::size_t kQuickPartition = 1024;

inline bool PartitionLevel::blends() const { return size <= kQuickPartition; }

/// Largest number of levels.
inline constexpr std::size_t kMaxLevels = 4;

/// The partitioning of least cost into at most kMaxLevels levels (Garcia 2002). The first level
/// has partitions of a block (rounded up to a power of two, at least 16) and no latency. Sizes
/// increase from level to level, up to 8192. Deterministic.
std::vector<PartitionLevel> partition_levels(const ConvolutionShape& shape);

/// Most terms of a partition in a sum of products: those of two filters within an exchange.
inline constexpr std::size_t kTermsPerPartition = 2;

/// Samples by which the segments of level `index` > 0 start before multiples of its size.
std::size_t lead_samples(const ConvolutionShape& shape, std::size_t index);

/// Estimated costs on one core, ns: transform_cost() of the transform of a window, product_cost()
/// of the products of a chunk of bins with the filters to all outputs. `exchanging`: the filter is
/// new.
double transform_cost(std::size_t size);
double product_cost(const ConvolutionShape& shape, const PartitionLevel& level, bool exchanging);

}  // namespace aula
