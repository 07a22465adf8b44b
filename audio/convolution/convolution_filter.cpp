#include "audio/convolution/convolution_filter.h"

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
        const std::size_t all = shape.inputs * level.count;
        levels_.push_back({level.count, std::vector<FilterPartition>(all),
                           std::vector<std::shared_ptr<const void>>(all)});
    }
}

FilterTransform::FilterTransform(const ConvolutionShape& shape) : shape_(shape) {
    const ConvolutionFilter empty(shape);
    const std::vector<PartitionLevel> measures = partition_levels(shape);
    for (std::size_t l = 0; l < measures.size(); ++l) {
        levels_.push_back({measures[l], BlockTransform(measures[l].size), {}, 0, empty.levels_[l]});
    }
    const PartitionLevel& last = measures.back();
    padded_taps_ = last.end_tap();
    kept_.resize(shape.inputs * shape.outputs * padded_taps_);
    taps_.resize(shape.outputs);
    work_.resize(2 * last.size * shape.outputs);
    if (last.half_precision) spectra_.resize(2 * last.size * shape.outputs);
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
                filter.levels_[l].memory[place].reset();
                transform_partition(level, input, p);
            }
            filter.levels_[l].memory[place] = level.newest.memory[place];
            filter.levels_[l].partitions[place] = level.newest.partitions[place];
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

void FilterTransform::transform_partition(Level& level, std::size_t input, std::size_t index) {
    const std::size_t place = input * level.measure.count + index;
    const std::size_t first = level.measure.first_tap + index * level.measure.size;
    level.newest.memory[place].reset();
    level.newest.partitions[place] = {};
    bool zero = true;
    for (std::size_t o = 0; o < shape_.outputs && zero; ++o) {
        zero = all_zero(kept(input, o, first), level.measure.size);
    }
    if (zero) return;
    for (std::size_t o = 0; o < shape_.outputs; ++o) taps_[o] = kept(input, o, first);
    const Spectra memory = unused_spectra(level);
    float scale = 1;
    if (level.measure.half_precision) {
        scale = transform_half(level, static_cast<std::uint16_t*>(memory.get()));
    } else {
        level.transform.forward_filters(taps_, work_.data(), static_cast<float*>(memory.get()));
    }
    level.newest.memory[place] = memory;
    level.newest.partitions[place] = {memory.get(), scale};
}

/// What the numbers are to be multiplied by.
// No bin is larger than the sum of the taps' sizes. Scaled by a power of two so that this sum is at
// most 2^15, bins are far from the largest half-precision number, 65504, and those that matter far
// from 2^-14, below which precision is lost.
float FilterTransform::transform_half(const Level& level, std::uint16_t* spectra) {
    float largest = 0;
    for (const float* const taps : taps_) {
        float sum = 0;
        for (std::size_t n = 0; n < level.measure.size; ++n) sum += std::abs(taps[n]);
        largest = std::max(largest, sum);
    }
    int exponent = 0;
    std::frexp(largest, &exponent);
    constexpr int kLargest = 15;
    const float scale = std::ldexp(1.0F, exponent - kLargest);
    level.transform.forward_filters(taps_, work_.data(), spectra_.data());
    best_kernels().to_half(spectra_.data(), 2 * level.measure.size * shape_.outputs, 1 / scale,
                           spectra);
    return scale;
}

/// Memory that no filter refers to. It is got for a whole filter at a time, so that partitions that
/// are read one after another lie one after another.
FilterTransform::Spectra FilterTransform::unused_spectra(Level& level) {
    std::vector<Spectra>& pool = level.pool;
    const auto next = [&]() -> const Spectra& {
        const Spectra& spectra = pool[level.next_in_pool];
        level.next_in_pool = (level.next_in_pool + 1) % pool.size();
        return spectra;
    };
    for (std::size_t tried = 0; tried < pool.size(); ++tried) {
        const Spectra& spectra = next();
        if (spectra.use_count() == 1) return spectra;
    }
    const std::size_t numbers = 2 * level.measure.size * shape_.outputs;
    const std::size_t floats = level.measure.half_precision ? numbers / 2 : numbers;
    const std::size_t count = shape_.inputs * level.measure.count;
    const auto memory = std::make_shared<AlignedVector<float>>(count * floats);
    level.next_in_pool = pool.size();
    for (std::size_t i = 0; i < count; ++i) {
        // Counted one by one, each keeps the whole alive.
        pool.emplace_back(memory->data() + i * floats, [memory](void*) {});
    }
    return next();
}

}  // namespace aula
