#include "audio/convolution_filter.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

namespace aula {

namespace {

bool all_zero(const float* p, std::size_t count) {
    return std::all_of(p, p + count, [](float x) { return x == 0; });
}

}  // namespace

ConvolutionFilter::ConvolutionFilter(const ConvolutionShape& shape) {
    for (const PartitionLevel& level : partition_levels(shape)) {
        counts_.push_back(level.count);
        levels_.emplace_back(shape.inputs * level.count);
    }
}

FilterTransform::FilterTransform(const ConvolutionShape& shape) : shape_(shape) {
    std::size_t largest = 0;
    for (const PartitionLevel& measure : partition_levels(shape)) {
        levels_.push_back({measure, BlockTransform(measure.size), {}, 0, {}});
        levels_.back().newest.resize(shape.inputs * measure.count);
        largest = std::max(largest, measure.size);
    }
    padded_taps_ = levels_.back().measure.end_tap();
    kept_.resize(shape.inputs * shape.outputs * padded_taps_);
    work_.resize(2 * largest);
    spectrum_.resize(2 * largest);
}

void FilterTransform::transform(std::span<const std::span<const float>> responses,
                                std::size_t input, ConvolutionFilter& filter) {
    assert(responses.size() == shape_.outputs && input < shape_.inputs);
    for (std::size_t l = 0; l < levels_.size(); ++l) {
        Level& level = levels_[l];
        const PartitionLevel& measure = level.measure;
        for (std::size_t p = 0; p < measure.count; ++p) {
            const std::size_t place = input * measure.count + p;
            const std::size_t first = measure.first_tap + p * measure.size;
            if (take_over(responses, input, first, measure.size)) {
                // Given up first, so that its memory may be taken again.
                level.newest[place].reset();
                filter.levels_[l][place].reset();
                level.newest[place] = transformed(level, input, first);
            }
            filter.levels_[l][place] = level.newest[place];
        }
    }
}

/// Keeps a partition's taps; whether they differ from what was kept.
bool FilterTransform::take_over(std::span<const std::span<const float>> responses,
                                std::size_t input, std::size_t first, std::size_t count) {
    bool changed = false;
    for (std::size_t o = 0; o < shape_.outputs; ++o) {
        assert(responses[o].size() <= shape_.taps);
        const std::size_t given =
            responses[o].size() > first ? std::min(responses[o].size() - first, count) : 0;
        const float* const taps = responses[o].data() + (given > 0 ? first : 0);
        float* const before = kept(input, o, first);
        if (given > 0 && std::memcmp(taps, before, given * sizeof(float)) != 0) {
            std::copy_n(taps, given, before);
            changed = true;
        }
        if (!all_zero(before + given, count - given)) {
            std::fill_n(before + given, count - given, 0.0F);
            changed = true;
        }
    }
    return changed;
}

/// Null if all taps are zero.
std::shared_ptr<const FilterPartition> FilterTransform::transformed(Level& level, std::size_t input,
                                                                    std::size_t first) {
    bool zero = true;
    for (std::size_t o = 0; o < shape_.outputs && zero; ++o) {
        zero = all_zero(kept(input, o, first), level.measure.size);
    }
    if (zero) return nullptr;
    std::shared_ptr<FilterPartition> partition = unused_partition(level);
    if (level.measure.half_precision) {
        transform_half(level, input, first, *partition);
        return partition;
    }
    auto* const spectra = static_cast<float*>(partition->spectra);
    for (std::size_t o = 0; o < shape_.outputs; ++o) {
        level.transform.forward_filter(kept(input, o, first), work_.data(),
                                       spectra + o * kChunk_floats, shape_.outputs * kChunk_floats);
    }
    return partition;
}

// No bin is larger than the sum of the taps' sizes. Scaled by a power of two so that this sum is at
// most 2^15, bins are far from the largest half-precision number, 65504, and those that matter far
// from 2^-14, below which precision is lost.
void FilterTransform::transform_half(const Level& level, std::size_t input, std::size_t first,
                                     FilterPartition& partition) {
    float largest = 0;
    for (std::size_t o = 0; o < shape_.outputs; ++o) {
        const float* const taps = kept(input, o, first);
        float sum = 0;
        for (std::size_t n = 0; n < level.measure.size; ++n) sum += std::abs(taps[n]);
        largest = std::max(largest, sum);
    }
    int exponent = 0;
    std::frexp(largest, &exponent);
    constexpr int kLargest = 15;
    partition.scale = std::ldexp(1.0F, exponent - kLargest);
    auto* const spectra = static_cast<std::uint16_t*>(partition.spectra);
    const SpectralKernels& kernels = best_kernels();
    for (std::size_t o = 0; o < shape_.outputs; ++o) {
        level.transform.forward_filter(kept(input, o, first), work_.data(), spectrum_.data(),
                                       kChunk_floats);
        for (std::size_t c = 0; c < level.transform.chunks(); ++c) {
            kernels.to_half(spectrum_.data() + c * kChunk_floats, kChunk_floats,
                            1 / partition.scale,
                            spectra + (c * shape_.outputs + o) * kChunk_floats);
        }
    }
}

/// A partition that no filter refers to. Memory is got for a whole filter at a time, so that
/// partitions that are read one after another lie one after another.
std::shared_ptr<FilterPartition> FilterTransform::unused_partition(Level& level) {
    std::vector<std::shared_ptr<FilterPartition>>& pool = level.pool;
    for (std::size_t tried = 0; tried < pool.size(); ++tried) {
        const std::shared_ptr<FilterPartition>& partition = pool[level.next_in_pool];
        level.next_in_pool = (level.next_in_pool + 1) % pool.size();
        if (partition.use_count() == 1) return partition;
    }
    const std::size_t numbers = 2 * level.measure.size * shape_.outputs;
    const std::size_t floats = level.measure.half_precision ? numbers / 2 : numbers;
    const std::size_t count = shape_.inputs * level.measure.count;
    const auto memory = std::make_shared<AlignedVector<float>>(count * floats);
    level.next_in_pool = pool.size();
    for (std::size_t i = 0; i < count; ++i) {
        pool.push_back(std::make_shared<FilterPartition>(
            FilterPartition{memory->data() + i * floats, 1.0F, memory}));
    }
    const std::shared_ptr<FilterPartition>& partition = pool[level.next_in_pool];
    level.next_in_pool = (level.next_in_pool + 1) % pool.size();
    return partition;
}

}  // namespace aula
