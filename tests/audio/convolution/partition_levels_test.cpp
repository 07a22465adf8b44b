#include "audio/convolution/partition_levels.h"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "audio/convolution/spectral_kernels.h"

using namespace aula;

namespace {

/// The levels of the given ascending sizes; empty if a level has no taps.
std::vector<PartitionLevel> levels_of(const ConvolutionShape& shape,
                                      const std::vector<std::size_t>& sizes) {
    std::vector<PartitionLevel> levels;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        const std::size_t first = i == 0 ? 0 : 2 * sizes[i];
        const std::size_t end =
            std::min(shape.taps, i + 1 < sizes.size() ? 2 * sizes[i + 1] : shape.taps);
        if (end <= first) return {};
        levels.push_back({sizes[i], first, (end - first + sizes[i] - 1) / sizes[i],
                          i > 0 && shape.half_precision_tail});
    }
    return levels;
}

/// Cost per sample by the published estimates: a transform of each input and output, and products
/// of every partition.
double cost(const ConvolutionShape& shape, const std::vector<PartitionLevel>& levels) {
    double sum = 0;
    for (const PartitionLevel& level : levels) {
        const auto size = static_cast<double>(level.size);
        sum +=
            static_cast<double>(shape.inputs + shape.outputs) * transform_cost(level.size) / size;
        sum += static_cast<double>(shape.inputs * level.count) / kChunk_bins *
               product_cost(shape, level, false);
    }
    return sum;
}

/// The least cost of all partitionings, by enumeration of the sets of sizes.
double min_cost(const ConvolutionShape& shape) {
    const std::size_t head = std::max<std::size_t>(16, std::bit_ceil(shape.block));
    std::vector<std::size_t> larger;
    for (std::size_t size = 2 * head; size <= 8192; size *= 2) larger.push_back(size);
    double min = std::numeric_limits<double>::infinity();
    for (unsigned set = 0; set < 1U << larger.size(); ++set) {
        if (std::popcount(set) >= static_cast<int>(kMaxLevels)) continue;
        std::vector<std::size_t> sizes{head};
        for (std::size_t i = 0; i < larger.size(); ++i)
            if ((set >> i & 1U) != 0) sizes.push_back(larger[i]);
        const std::vector<PartitionLevel> levels = levels_of(shape, sizes);
        if (!levels.empty()) min = std::min(min, cost(shape, levels));
    }
    return min;
}

}  // namespace

TEST_CASE("The partitioning has the least cost of all with at most four levels") {
    for (const std::size_t block : {1U, 64U, 200U, 1024U, 8192U}) {
        for (const std::size_t taps : {10U, 3000U, 48000U, 480000U}) {
            for (const std::size_t inputs : {1U, 8U}) {
                for (const std::size_t outputs : {1U, 16U}) {
                    const ConvolutionShape shape{inputs, outputs, block, taps, taps > 40000};
                    const std::vector<PartitionLevel> levels = partition_levels(shape);
                    CAPTURE(block, taps, inputs, outputs, levels.size());
                    // Rounding: the terms are summed in another order.
                    CHECK(cost(shape, levels) == Approx(min_cost(shape)).epsilon(1e-12));
                }
            }
        }
    }
    // Companion: partitions of one size cost several times as much.
    const ConvolutionShape room{1, 4, 128, 96000};
    CHECK(cost(room, levels_of(room, {128})) > 4 * cost(room, partition_levels(room)));
}

TEST_CASE("Quick partitions have at most 1024 taps") {
    for (const std::size_t block : {64U, 256U, 1024U, 2048U}) {
        for (const std::size_t inputs : {1U, 8U, 32U}) {
            ConvolutionShape shape{inputs, 4, block, 96000};
            const auto largest_before = [&](std::size_t tap) {
                std::size_t largest = 0;
                for (const PartitionLevel& level : partition_levels(shape))
                    if (level.first_tap < tap) largest = std::max(largest, level.size);
                return largest;
            };
            shape.quick_taps = 8192;
            CAPTURE(block, inputs);
            CHECK(largest_before(8192) <= std::max<std::size_t>(1024, block));
            // Companion: without it one of these has larger ones.
            shape.quick_taps = 0;
            if (block == 256 && inputs == 8) CHECK(largest_before(8192) > 1024);
        }
    }
}

TEST_CASE("The first partitions have the size of a block, rounded up to a power of two") {
    for (const auto& [block, size] : {std::pair{1U, 16U},
                                      {16U, 16U},
                                      {17U, 32U},
                                      {480U, 512U},
                                      {512U, 512U},
                                      {8191U, 8192U},
                                      {8192U, 8192U}}) {
        CAPTURE(block);
        CHECK(partition_levels({1, 2, block, 20000}).front().size == size);
    }
}

TEST_CASE("A response no longer than a block has one partition") {
    for (const std::size_t taps : {1U, 100U, 256U}) {
        const std::vector<PartitionLevel> levels = partition_levels({1, 1, 256, taps});
        REQUIRE(levels.size() == 1);
        CHECK(levels[0].count == 1);
        CHECK(levels[0].end_tap() == 256);
    }
    CHECK(partition_levels({1, 1, 256, 257})[0].end_tap() == 512);
}

TEST_CASE("All levels but the first have half precision if the tail has") {
    for (const bool half : {false, true}) {
        const std::vector<PartitionLevel> levels = partition_levels({1, 4, 64, 96000, half});
        REQUIRE(levels.size() > 2);
        CHECK_FALSE(levels[0].half_precision);
        for (std::size_t l = 1; l < levels.size(); ++l) CHECK(levels[l].half_precision == half);
    }
}

TEST_CASE("Products cost less in half precision and more during an exchange") {
    const ConvolutionShape shape{1, 16, 128, 96000, true};
    for (const std::size_t count : {1U, 100U}) {
        const PartitionLevel single{1024, 2048, count, false};
        const PartitionLevel half{1024, 2048, count, true};
        CAPTURE(count);
        for (const bool exchanging : {false, true}) {
            const double ratio =
                product_cost(shape, single, exchanging) / product_cost(shape, half, exchanging);
            // 16 filters and an input: 17 x 4 bytes a number, or 16 x 2 + 4.
            CHECK(ratio == Approx(68.0 / 36));
        }
        CHECK(product_cost(shape, half, true) > product_cost(shape, half, false));
    }
    // n log n.
    CHECK(transform_cost(2048) / transform_cost(1024) == Approx(2 * 11 / 10.0));
}
