#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "audio/base/aligned.h"
#include "audio/convolution/block_transform.h"
#include "audio/convolution/partition_levels.h"
#include "aula/audio/convolver.h"

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

struct FilterTransform::State {
    /// Memory for the spectra of a partition. It is in use if its use count is above 1 (the pool).
    using Spectra = std::shared_ptr<void>;

    struct Level {
        PartitionLevel partitioning;
        BlockTransform transform;
        std::vector<Spectra> pool;
        std::size_t next_in_pool = 0;
        ConvolutionFilter::Level newest;
    };

    explicit State(const ConvolutionShape& shape);
    void transform(std::span<const std::span<const float>> responses, std::size_t input,
                   ConvolutionFilter& filter);
    void repeat(std::size_t input, ConvolutionFilter& filter) const;
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

FilterTransform::State::State(const ConvolutionShape& shape) : shape_(shape) {
    const ConvolutionFilter empty(shape);
    const std::vector<PartitionLevel> partitioning = partition_levels(shape);
    for (std::size_t l = 0; l < partitioning.size(); ++l) {
        levels_.push_back(
            {partitioning[l], BlockTransform(partitioning[l].size), {}, 0, empty.levels_[l]});
    }
    const PartitionLevel& last = partitioning.back();
    padded_taps_ = last.end_tap();
    newest_taps_.resize(shape.inputs * shape.outputs * padded_taps_);
    taps_.resize(shape.outputs);
    work_.resize(2 * last.size * shape.outputs);
    if (last.half_precision) spectra_.resize(2 * last.size * shape.outputs);
}

void FilterTransform::State::transform(std::span<const std::span<const float>> responses,
                                       std::size_t input, ConvolutionFilter& filter) {
    assert(responses.size() == shape_.outputs && input < shape_.inputs);
    for (std::size_t l = 0; l < levels_.size(); ++l) {
        Level& level = levels_[l];
        const PartitionLevel& partitioning = level.partitioning;
        for (std::size_t p = 0; p < partitioning.count; ++p) {
            const std::size_t index = input * partitioning.count + p;
            const std::size_t first = partitioning.first_tap + p * partitioning.size;
            if (store_taps(responses, input, first, partitioning.size)) {
                // Released first, so that its memory can be reused.
                filter.levels_[l].memory[index].reset();
                transform_partition(level, input, p);
            }
            filter.levels_[l].memory[index] = level.newest.memory[index];
            filter.levels_[l].partitions[index] = level.newest.partitions[index];
        }
    }
}

void FilterTransform::State::repeat(std::size_t input, ConvolutionFilter& filter) const {
    for (std::size_t l = 0; l < levels_.size(); ++l) {
        const std::size_t count = levels_[l].partitioning.count;
        for (std::size_t index = input * count; index < (input + 1) * count; ++index) {
            filter.levels_[l].memory[index] = levels_[l].newest.memory[index];
            filter.levels_[l].partitions[index] = levels_[l].newest.partitions[index];
        }
    }
}

/// Stores the taps of a partition. Returns whether they differ from those stored before.
bool FilterTransform::State::store_taps(std::span<const std::span<const float>> responses,
                                        std::size_t input, std::size_t first, std::size_t count) {
    bool changed = false;
    for (std::size_t o = 0; o < shape_.outputs; ++o) {
        assert(responses[o].size() <= shape_.taps);
        const std::size_t given =
            responses[o].size() > first ? std::min(responses[o].size() - first, count) : 0;
        const float* const taps = responses[o].data() + (given > 0 ? first : 0);
        float* const before = newest_taps(input, o, first);
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

void FilterTransform::State::transform_partition(Level& level, std::size_t input,
                                                 std::size_t partition) {
    const std::size_t index = input * level.partitioning.count + partition;
    const std::size_t first = level.partitioning.first_tap + partition * level.partitioning.size;
    level.newest.memory[index].reset();
    level.newest.partitions[index] = {};
    bool zero = true;
    for (std::size_t o = 0; o < shape_.outputs && zero; ++o) {
        zero = all_zero(newest_taps(input, o, first), level.partitioning.size);
    }
    if (zero) return;
    for (std::size_t o = 0; o < shape_.outputs; ++o) taps_[o] = newest_taps(input, o, first);
    const Spectra memory = unused_spectra(level);
    float scale = 1;
    if (level.partitioning.half_precision) {
        scale = transform_half(level, static_cast<std::uint16_t*>(memory.get()));
    } else {
        level.transform.forward_filters(taps_, work_.data(), static_cast<float*>(memory.get()));
    }
    level.newest.memory[index] = memory;
    level.newest.partitions[index] = {memory.get(), scale};
}

/// Returns the scale of the stored numbers.
// No bin exceeds the sum of the taps' magnitudes. A power of two scales this sum to at most 2^15:
// bins then stay well below the largest half-precision number, 65504, and those that matter stay
// well above 2^-14, below which precision is lost.
float FilterTransform::State::transform_half(const Level& level, std::uint16_t* spectra) {
    float largest = 0;
    for (const float* const taps : taps_) {
        float sum = 0;
        for (std::size_t n = 0; n < level.partitioning.size; ++n) sum += std::abs(taps[n]);
        largest = std::max(largest, sum);
    }
    int exponent = 0;
    std::frexp(largest, &exponent);
    constexpr int kLargest = 15;
    const float scale = std::ldexp(1.0F, exponent - kLargest);
    level.transform.forward_filters(taps_, work_.data(), spectra_.data());
    best_kernels().to_half(spectra_.data(), 2 * level.partitioning.size * shape_.outputs, 1 / scale,
                           spectra);
    return scale;
}

/// Memory that no filter refers to. It is allocated for a whole filter at a time, so that
/// partitions that are read in sequence are adjacent.
FilterTransform::State::Spectra FilterTransform::State::unused_spectra(Level& level) {
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
    const std::size_t numbers = 2 * level.partitioning.size * shape_.outputs;
    const std::size_t floats = level.partitioning.half_precision ? numbers / 2 : numbers;
    const std::size_t count = shape_.inputs * level.partitioning.count;
    const auto memory = std::make_shared<AlignedVector<float>>(count * floats);
    level.next_in_pool = pool.size();
    for (std::size_t i = 0; i < count; ++i) {
        // Each partition has its own use count and keeps the whole allocation alive.
        pool.emplace_back(memory->data() + i * floats, [memory](void*) {});
    }
    return next();
}

FilterTransform::FilterTransform(const ConvolutionShape& shape)
    : state_(std::make_unique<State>(shape)) {}
FilterTransform::~FilterTransform() = default;
FilterTransform::FilterTransform(FilterTransform&&) noexcept = default;
FilterTransform& FilterTransform::operator=(FilterTransform&&) noexcept = default;

void FilterTransform::transform(std::span<const std::span<const float>> responses,
                                std::size_t input, ConvolutionFilter& filter) {
    state_->transform(responses, input, filter);
}

void FilterTransform::repeat(std::size_t input, ConvolutionFilter& filter) const {
    state_->repeat(input, filter);
}

}  // namespace aula
