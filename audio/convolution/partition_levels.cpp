#include "audio/convolution/partition_levels.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>

#include "audio/convolution/spectral_kernels.h"

namespace aula {

namespace {

constexpr std::size_t kSmallest = 16;
constexpr std::size_t kLargest = 8192;

/// Levels of the given sizes. Each starts at its earliest tap and ends where the next one starts.
std::vector<PartitionLevel> levels_of(const ConvolutionShape& shape,
                                      const std::vector<std::size_t>& sizes) {
    std::vector<PartitionLevel> levels;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        PartitionLevel level;
        level.size = sizes[i];
        level.first_tap = i == 0 ? 0 : 2 * sizes[i];
        const std::size_t end =
            i + 1 < sizes.size() ? std::min(2 * sizes[i + 1], shape.taps) : shape.taps;
        if (i > 0 && end <= level.first_tap) break;
        level.count =
            std::max<std::size_t>(1, (end - level.first_tap + level.size - 1) / level.size);
        level.half_precision = i > 0 && shape.half_precision_tail;
        levels.push_back(level);
    }
    return levels;
}

/// Cost per sample, ns.
double cost(const ConvolutionShape& shape, const std::vector<PartitionLevel>& levels) {
    double sum = 0;
    for (const PartitionLevel& level : levels) {
        const auto size = static_cast<double>(level.size);
        const auto windows = static_cast<double>(shape.inputs + shape.outputs);
        const auto products = static_cast<double>(shape.inputs * level.count) * size / kChunk_bins;
        sum +=
            (windows * transform_cost(level.size) + products * product_cost(shape, level, false)) /
            size;
    }
    return sum;
}

}  // namespace

// Measured with AVX-512 at 3.3 GHz: 0.1 ns per sample and doubling of the size.
double transform_cost(std::size_t size) {
    return 0.1 * static_cast<double>(size) * std::log2(static_cast<double>(size));
}

// Products are limited by the bandwidth, in GB/s, at which filters and inputs are read from the
// caches or from memory. During an exchange the new filter comes from another core's cache. The
// rates are chosen such that all tasks of a segment take similar times (AVX-512, 1 to 8 inputs, 2
// to 16 outputs).
double product_cost(const ConvolutionShape& shape, const PartitionLevel& level, bool exchanging) {
    constexpr double kCached_bytes = 4e6;
    const double filter_bytes = kChunk_floats * (level.half_precision ? 2.0 : 4.0);
    const double input_bytes = kChunk_floats * 4.0;
    const double bytes = static_cast<double>(shape.outputs) * filter_bytes + input_bytes;
    const double level_bytes =
        bytes * static_cast<double>(shape.inputs * level.count * level.size / kChunk_bins);
    if (level_bytes < kCached_bytes) return bytes / (exchanging ? 40 : 70);
    return bytes / (exchanging ? 23 : 30);
}

std::vector<PartitionLevel> partition_levels(const ConvolutionShape& shape) {
    assert(shape.block >= 1 && shape.block <= kLargest && shape.taps >= 1);
    const std::size_t head = std::max(kSmallest, std::bit_ceil(shape.block));
    std::vector<PartitionLevel> best;
    double best_cost = std::numeric_limits<double>::infinity();
    const auto consider = [&](const std::vector<std::size_t>& sizes) {
        std::vector<PartitionLevel> levels = levels_of(shape, sizes);
        const double c = cost(shape, levels);
        if (c < best_cost) {
            best_cost = c;
            best = std::move(levels);
        }
    };
    // Depth-first search over all ascending sequences of sizes.
    const std::function<void(std::vector<std::size_t>&)> extend =
        [&](std::vector<std::size_t>& sizes) {
            consider(sizes);
            if (sizes.size() == kMaxLevels) return;
            for (std::size_t next = 2 * sizes.back(); next <= kLargest; next *= 2) {
                if (next > kQuickPartition && 2 * next < shape.quick_taps) continue;
                sizes.push_back(next);
                extend(sizes);
                sizes.pop_back();
            }
        };
    std::vector<std::size_t> sizes{head};
    extend(sizes);
    return best;
}

// The partition size at least doubles from level to level: that of level l > 0 is a multiple of 2^l
// head partitions. The segments of level l start 2^(l - 1) head partitions before multiples of its
// size, so that no two levels start a segment at the same sample.
std::size_t lead_samples(const ConvolutionShape& shape, std::size_t index) {
    return partition_levels(shape)[0].size << (index - 1);
}

}  // namespace aula
