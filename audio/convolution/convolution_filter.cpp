#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <deque>
#include <utility>

#include "audio/base/aligned.h"
#include "audio/convolution/block_transform.h"
#include "audio/convolution/partition_levels.h"
#include "aula/audio/convolver.h"

namespace aula {

namespace {

bool all_zero(const float* p, std::size_t count) {
    return std::all_of(p, p + count, [](float x) { return x == 0; });
}

/// A hash of the taps of a partition. Any change of a single pair of taps changes it.
class TapsHash {
 public:
    void add(const float* taps, std::size_t count) {
        std::size_t n = 0;
        for (; n + kStep <= count; n += kStep) {
            std::array<std::uint64_t, kLanes> words;
            std::memcpy(words.data(), taps + n, sizeof(words));
            for (std::size_t i = 0; i < kLanes; ++i) add_word(i, words[i]);
        }
        for (; n < count; ++n) add_word(0, std::bit_cast<std::uint32_t>(taps[n]));
    }

    friend bool operator==(const TapsHash&, const TapsHash&) = default;

 private:
    static constexpr std::size_t kLanes = 4;
    static constexpr std::size_t kStep = 2 * kLanes;

    // Each step is a bijection of the lane for a given word, and of the word for a given lane.
    void add_word(std::size_t lane, std::uint64_t word) {
        constexpr std::uint64_t kMultiplier = 0x9E3779B97F4A7C15;
        lanes_[lane] = (std::rotl(lanes_[lane], 23) ^ word) * kMultiplier;
    }

    std::array<std::uint64_t, kLanes> lanes_{};
};

/// Memory for the spectra of partitions. It outlives the transform while filters refer to it.
class SpectraPool : public std::enable_shared_from_this<SpectraPool> {
 public:
    /// `floats`: of a partition's spectra. Memory for `batch` partitions, those that are read in
    /// sequence, is adjacent.
    SpectraPool(std::size_t floats, std::size_t batch) : floats_(floats), batch_(batch) {}

    /// The spectra of a partition. Their memory returns to the pool with the last reference.
    std::shared_ptr<void> take() {
        if (unused_.empty()) {
            float* const first = blocks_.emplace_back(batch_ * floats_).data();
            for (std::size_t i = 0; i < batch_; ++i) unused_.push_back(first + i * floats_);
        }
        float* const spectra = unused_.front();
        unused_.pop_front();
        return {spectra, [pool = shared_from_this()](float* p) { pool->unused_.push_back(p); }};
    }

    std::size_t memory_bytes() const { return blocks_.size() * batch_ * floats_ * sizeof(float); }

 private:
    std::size_t floats_;
    std::size_t batch_;
    std::deque<AlignedVector<float>> blocks_;
    std::deque<float*> unused_;
};

/// Memory for the spectra of the inputs of a level is allocated for about so much at a time, and at
/// least for one input.
constexpr std::size_t kBatch_bytes = std::size_t{24} << 20;

}  // namespace

struct ConvolutionFilter::Level {
    std::size_t count = 0;                            ///< partitions per input
    std::vector<FilterPartition> partitions;          ///< [input][partition]
    std::vector<std::shared_ptr<const void>> memory;  ///< owners of the spectra, likewise
    mutable std::atomic<bool> released = false;       ///< no convolver reads it again
    bool freed = false;                               ///< its spectra, after the release
};

ConvolutionFilter::ConvolutionFilter(const ConvolutionShape& shape) {
    const std::vector<PartitionLevel> partitioning = partition_levels(shape);
    levels_ = std::make_shared<std::vector<Level>>(partitioning.size());
    for (std::size_t l = 0; l < partitioning.size(); ++l) {
        Level& level = (*levels_)[l];
        level.count = partitioning[l].count;
        level.partitions.resize(shape.inputs * level.count);
        level.memory.resize(shape.inputs * level.count);
    }
}

const FilterPartition* ConvolutionFilter::partitions(std::size_t level,
                                                     std::size_t input) const noexcept {
    const Level& own = (*levels_)[level];
    return own.partitions.data() + input * own.count;
}

void ConvolutionFilter::release(std::size_t level) const noexcept {
    (*levels_)[level].released.store(true, std::memory_order_release);
}

struct FilterTransform::State {
    struct Level {
        PartitionLevel partitioning;
        BlockTransform transform;
        std::shared_ptr<SpectraPool> pool;
        std::vector<FilterPartition> newest;                     ///< [input][partition]
        std::vector<std::shared_ptr<const void>> newest_memory;  ///< owners of its spectra
        std::vector<TapsHash> newest_taps;                       ///< likewise, of their taps
    };

    explicit State(const ConvolutionShape& shape);
    void transform(std::span<const std::span<const float>> responses, std::size_t input,
                   ConvolutionFilter& filter, std::span<const char> levels);
    void repeat(std::size_t input, ConvolutionFilter& filter);
    void begin(ConvolutionFilter& filter);
    void free_released();
    bool read_taps(std::span<const std::span<const float>> responses, std::size_t first,
                   std::size_t count, TapsHash& newest);
    void transform_partition(Level& level, std::size_t index);
    float transform_half(const Level& level, std::uint16_t* spectra);

    ConvolutionShape shape_;
    std::vector<Level> levels_;
    std::vector<std::weak_ptr<std::vector<ConvolutionFilter::Level>>>
        filters_;                             ///< that have been filled
    std::vector<AlignedVector<float>> taps_;  ///< of a partition, padded with zeros, [output]
    std::vector<const float*> taps_pointers_;
    AlignedVector<float> work_;     ///< work space of its transforms
    AlignedVector<float> spectra_;  ///< its spectra before rounding to half precision
};

FilterTransform::State::State(const ConvolutionShape& shape) : shape_(shape) {
    const std::vector<PartitionLevel> partitioning = partition_levels(shape);
    for (const PartitionLevel& level : partitioning) {
        const std::size_t all = shape.inputs * level.count;
        const std::size_t numbers = 2 * level.size * shape.outputs;
        const std::size_t floats = level.half_precision ? numbers / 2 : numbers;
        const std::size_t inputs = std::clamp<std::size_t>(
            kBatch_bytes / (level.count * floats * sizeof(float)), 1, shape.inputs);
        levels_.push_back({level, BlockTransform(level.size),
                           std::make_shared<SpectraPool>(floats, inputs * level.count),
                           std::vector<FilterPartition>(all),
                           std::vector<std::shared_ptr<const void>>(all),
                           std::vector<TapsHash>(all)});
    }
    const PartitionLevel& last = partitioning.back();
    taps_.resize(shape.outputs, AlignedVector<float>(last.size));
    for (const AlignedVector<float>& taps : taps_) taps_pointers_.push_back(taps.data());
    work_.resize(2 * last.size * shape.outputs);
    if (last.half_precision) spectra_.resize(2 * last.size * shape.outputs);
}

void FilterTransform::State::transform(std::span<const std::span<const float>> responses,
                                       std::size_t input, ConvolutionFilter& filter,
                                       std::span<const char> levels) {
    assert(responses.size() == shape_.outputs && input < shape_.inputs);
    assert(levels.empty() || levels.size() == levels_.size());
    begin(filter);
    for (std::size_t l = 0; l < levels_.size(); ++l) {
        Level& level = levels_[l];
        ConvolutionFilter::Level& filled = (*filter.levels_)[l];
        const PartitionLevel& partitioning = level.partitioning;
        for (std::size_t p = 0; p < partitioning.count; ++p) {
            const std::size_t index = input * partitioning.count + p;
            const std::size_t first = partitioning.first_tap + p * partitioning.size;
            const bool set = levels.empty() || levels[l] != 0;
            if (set && read_taps(responses, first, partitioning.size, level.newest_taps[index])) {
                // Released first, so that its memory can be reused.
                filled.memory[index].reset();
                transform_partition(level, index);
            }
            filled.memory[index] = level.newest_memory[index];
            filled.partitions[index] = level.newest[index];
        }
    }
}

void FilterTransform::State::repeat(std::size_t input, ConvolutionFilter& filter) {
    begin(filter);
    for (std::size_t l = 0; l < levels_.size(); ++l) {
        const std::size_t count = levels_[l].partitioning.count;
        ConvolutionFilter::Level& filled = (*filter.levels_)[l];
        for (std::size_t index = input * count; index < (input + 1) * count; ++index) {
            filled.memory[index] = levels_[l].newest_memory[index];
            filled.partitions[index] = levels_[l].newest[index];
        }
    }
}

/// Prepares a filter to be filled: registers it and withdraws the release of its levels.
void FilterTransform::State::begin(ConvolutionFilter& filter) {
    free_released();
    const auto registered = std::find_if(filters_.begin(), filters_.end(), [&](const auto& levels) {
        return levels.lock() == filter.levels_;
    });
    if (registered == filters_.end()) filters_.push_back(filter.levels_);
    for (ConvolutionFilter::Level& level : *filter.levels_) {
        level.released.store(false, std::memory_order_relaxed);
        level.freed = false;
    }
}

/// Frees the spectra of released levels.
void FilterTransform::State::free_released() {
    std::erase_if(filters_, [](const auto& levels) { return levels.expired(); });
    for (const auto& filter : filters_) {
        for (ConvolutionFilter::Level& level : *filter.lock()) {
            // Acquire: the convolver has read the partitions before.
            if (level.freed || !level.released.load(std::memory_order_acquire)) continue;
            std::fill(level.partitions.begin(), level.partitions.end(), FilterPartition{});
            std::fill(level.memory.begin(), level.memory.end(), nullptr);
            level.freed = true;
        }
    }
}

/// Reads the taps of a partition. Returns whether they differ from the newest ones, and replaces
/// the hash of those.
bool FilterTransform::State::read_taps(std::span<const std::span<const float>> responses,
                                       std::size_t first, std::size_t count, TapsHash& newest) {
    TapsHash hash;
    bool zero = true;
    for (std::size_t o = 0; o < shape_.outputs; ++o) {
        assert(responses[o].size() <= shape_.taps);
        const std::size_t given =
            responses[o].size() > first ? std::min(responses[o].size() - first, count) : 0;
        float* const taps = taps_[o].data();
        if (given > 0) std::copy_n(responses[o].data() + first, given, taps);
        std::fill_n(taps + given, count - given, 0.0F);
        hash.add(taps, count);
        zero = zero && all_zero(taps, count);
    }
    // Silence has the hash of an input without responses.
    if (zero) hash = {};
    return std::exchange(newest, hash) != hash;
}

void FilterTransform::State::transform_partition(Level& level, std::size_t index) {
    level.newest_memory[index].reset();
    level.newest[index] = {};
    if (level.newest_taps[index] == TapsHash{}) return;
    const std::shared_ptr<void> memory = level.pool->take();
    float scale = 1;
    if (level.partitioning.half_precision) {
        scale = transform_half(level, static_cast<std::uint16_t*>(memory.get()));
    } else {
        level.transform.forward_filters(taps_pointers_, work_.data(),
                                        static_cast<float*>(memory.get()));
    }
    level.newest_memory[index] = memory;
    level.newest[index] = {memory.get(), scale};
}

/// Returns the scale of the stored numbers.
// No bin exceeds the sum of the taps' magnitudes. A power of two scales this sum to at most 2^15:
// bins then stay well below the largest half-precision number, 65504, and those that matter stay
// well above 2^-14, below which precision is lost.
float FilterTransform::State::transform_half(const Level& level, std::uint16_t* spectra) {
    float largest = 0;
    for (const AlignedVector<float>& taps : taps_) {
        float sum = 0;
        for (std::size_t n = 0; n < level.partitioning.size; ++n) sum += std::abs(taps[n]);
        largest = std::max(largest, sum);
    }
    int exponent = 0;
    std::frexp(largest, &exponent);
    constexpr int kLargest = 15;
    const float scale = std::ldexp(1.0F, exponent - kLargest);
    level.transform.forward_filters(taps_pointers_, work_.data(), spectra_.data());
    best_kernels().to_half(spectra_.data(), 2 * level.partitioning.size * shape_.outputs, 1 / scale,
                           spectra);
    return scale;
}

FilterTransform::FilterTransform(const ConvolutionShape& shape)
    : state_(std::make_unique<State>(shape)) {}
FilterTransform::~FilterTransform() = default;
FilterTransform::FilterTransform(FilterTransform&&) noexcept = default;
FilterTransform& FilterTransform::operator=(FilterTransform&&) noexcept = default;

void FilterTransform::transform(std::span<const std::span<const float>> responses,
                                std::size_t input, ConvolutionFilter& filter,
                                std::span<const char> levels) {
    state_->transform(responses, input, filter, levels);
}

void FilterTransform::repeat(std::size_t input, ConvolutionFilter& filter) {
    state_->repeat(input, filter);
}

std::size_t FilterTransform::memory_bytes() const {
    std::size_t bytes = 0;
    for (const State::Level& level : state_->levels_) bytes += level.pool->memory_bytes();
    return bytes;
}

}  // namespace aula
