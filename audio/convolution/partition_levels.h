#pragma once

#include <cstddef>
#include <vector>

namespace aula {

/// The measure of a convolution of several inputs into several outputs; filters, transforms and
/// convolvers that work together share it.
struct ConvolutionShape {
    std::size_t inputs = 1;
    std::size_t outputs = 1;
    std::size_t block = 256;           ///< largest number of samples of a call, at most 8192
    std::size_t taps = 1;              ///< of the longest filter
    bool half_precision_tail = false;  ///< all levels but the first: half the memory, -74 dB error
};

/// A run of equal partitions of the filters.
struct PartitionLevel {
    std::size_t size = 0;       ///< taps of a partition
    std::size_t first_tap = 0;  ///< 0, or 2 size: a frame of input, a frame of computing
    std::size_t count = 0;      ///< partitions
    bool half_precision = false;

    std::size_t end_tap() const { return first_tap + count * size; }
};

/// At most as many levels.
inline constexpr std::size_t kMostLevels = 4;

/// The cheapest way to cut the filters into at most kMostLevels levels. The first has partitions of
/// a block (rounded up to a power of two, at least 16) and no latency; sizes grow from level to
/// level, up to 8192.
std::vector<PartitionLevel> partition_levels(const ConvolutionShape& shape);

/// About what the parts of the work cost on one core, relative to each other: a transform of a
/// window, and the products of a chunk of bins with filters to all outputs, which have been heard
/// or are being exchanged.
double transform_cost(std::size_t size);
double product_cost(const ConvolutionShape& shape, const PartitionLevel& level, bool exchanging);

}  // namespace aula
