#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/convolution/block_transform.h"
#include "audio/convolution/partition_levels.h"

namespace aula {

/// Spectra of one partition of the filters from one input to all outputs, [chunk][output].
/// Immutable while a filter refers to it.
struct FilterPartition {
    const void* spectra = nullptr;  ///< floats or half-precision numbers; null: all zero
    float scale = 1;                ///< factor of half-precision numbers
};

/// Impulse responses from every input to every output, transformed partition by partition. Filters
/// of one FilterTransform share equal partitions. A filter must not change while a convolver uses
/// it.
class ConvolutionFilter {
 public:
    explicit ConvolutionFilter(const ConvolutionShape& shape);

    /// The partitions of an input's filters at a level, in order of time.
    const FilterPartition* partitions(std::size_t level,
                                      std::size_t input) const noexcept AULA_NONBLOCKING {
        return levels_[level].partitions.data() + input * levels_[level].count;
    }

 private:
    friend class FilterTransform;
    struct Level {
        std::size_t count;                                ///< partitions per input
        std::vector<FilterPartition> partitions;          ///< [input][partition]
        std::vector<std::shared_ptr<const void>> memory;  ///< owners of the spectra, likewise
    };
    std::vector<Level> levels_;
};

/// Fills filters. Only partitions that differ from those of the previous call are transformed. The
/// memory of a partition returns to a pool when no filter refers to it. Filters are filled and
/// destroyed on the same thread. [propagation thread]
class FilterTransform {
 public:
    explicit FilterTransform(const ConvolutionShape& shape);

    /// Sets the impulse responses of an input: one per output, each of at most shape.taps samples.
    void transform(std::span<const std::span<const float>> responses, std::size_t input,
                   ConvolutionFilter& filter);

    /// Sets an input's impulse responses to those of the call before.
    void repeat(std::size_t input, ConvolutionFilter& filter) const;

 private:
    /// Memory for the spectra of a partition. It is in use if its use count is above 1 (the pool).
    using Spectra = std::shared_ptr<void>;

    struct Level {
        PartitionLevel partitioning;
        BlockTransform transform;
        std::vector<Spectra> pool;
        std::size_t next_in_pool = 0;
        ConvolutionFilter::Level newest;
    };

    bool store_taps(std::span<const std::span<const float>> responses, std::size_t input,
                    std::size_t first, std::size_t count);
    void transform_partition(Level& level, std::size_t input, std::size_t partition);
    float transform_half(const Level& level, std::uint16_t* spectra);
    Spectra unused_spectra(Level& level);
    float* newest_taps(std::size_t input, std::size_t output, std::size_t tap) {
        return newest_taps_.data() + (input * shape_.outputs + output) * padded_taps_ + tap;
    }

    ConvolutionShape shape_;
    std::vector<Level> levels_;
    std::size_t padded_taps_;
    AlignedVector<float> newest_taps_;  ///< newest taps, [input][output][tap]
    std::vector<const float*> taps_;    ///< taps of a partition, [output]
    AlignedVector<float> work_;         ///< work space of its transforms
    AlignedVector<float> spectra_;      ///< its spectra before rounding to half precision
};

}  // namespace aula
