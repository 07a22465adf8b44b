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

/// Spectra of one partition of an input's filters to all outputs, interleaved chunk by chunk:
/// [chunk][output]. Not changed while a filter refers to it.
struct FilterPartition {
    const void* spectra = nullptr;  ///< floats or half-precision numbers; null: all zero
    float scale = 1;                ///< that half-precision numbers are to be multiplied by
};

/// Impulse responses from every input to every output, transformed partition by partition. Filters
/// of one FilterTransform share the partitions that they have in common. Not to be changed while a
/// convolver uses it.
class ConvolutionFilter {
 public:
    explicit ConvolutionFilter(const ConvolutionShape& shape);

    /// The partitions of an input's filters at a level, one after another.
    const FilterPartition* partitions(std::size_t level,
                                      std::size_t input) const noexcept AULA_NONBLOCKING {
        return levels_[level].partitions.data() + input * levels_[level].count;
    }

 private:
    friend class FilterTransform;
    struct Level {
        std::size_t count;                                ///< partitions of an input
        std::vector<FilterPartition> partitions;          ///< [input][partition]
        std::vector<std::shared_ptr<const void>> memory;  ///< that each of them needs
    };
    std::vector<Level> levels_;
};

/// Fills filters. Only partitions that differ from those of the call before are transformed; memory
/// is taken from a pool, to which it comes back when no filter refers to it. Filters are filled and
/// destroyed on the same thread. [propagation thread]
class FilterTransform {
 public:
    explicit FilterTransform(const ConvolutionShape& shape);

    /// Sets an input's impulse responses, one for each output, each at most shape.taps long.
    void transform(std::span<const std::span<const float>> responses, std::size_t input,
                   ConvolutionFilter& filter);

 private:
    /// Memory for the spectra of a partition; in use if anything but the pool refers to it.
    using Spectra = std::shared_ptr<void>;

    struct Level {
        PartitionLevel measure;
        BlockTransform transform;
        std::vector<Spectra> pool;
        std::size_t next_in_pool = 0;
        ConvolutionFilter::Level newest;
    };

    bool take_over(std::span<const std::span<const float>> responses, std::size_t input,
                   std::size_t first, std::size_t count);
    void transform_partition(Level& level, std::size_t input, std::size_t index);
    float transform_half(const Level& level, std::uint16_t* spectra);
    Spectra unused_spectra(Level& level);
    float* kept(std::size_t input, std::size_t output, std::size_t tap) {
        return kept_.data() + (input * shape_.outputs + output) * padded_taps_ + tap;
    }

    ConvolutionShape shape_;
    std::vector<Level> levels_;
    std::size_t padded_taps_;
    AlignedVector<float> kept_;       ///< [input][output][tap], of the call before
    std::vector<const float*> taps_;  ///< of a partition, [output]
    AlignedVector<float> work_;       ///< of its transforms
    AlignedVector<float> spectra_;    ///< of a partition, before they are halved
};

}  // namespace aula
