#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/convolution/block_transform.h"
#include "audio/convolution/partition_levels.h"
#include "audio/dsp/fade.h"
#include "aula/audio/convolver.h"
#include "aula/audio/realtime.h"

namespace aula {

/// Frequency-domain delay line: spectra of the newest windows of every input at one level.
class FrequencyDomainDelayLine {
 public:
    FrequencyDomainDelayLine(std::size_t inputs, const PartitionLevel& level);

    /// Increments the age of all windows. Those of age 0 replace the oldest and are to be written.
    void advance() noexcept AULA_NONBLOCKING { newest_ = newest_ == 0 ? ages_ - 1 : newest_ - 1; }

    float* spectrum(std::size_t input, std::size_t age) noexcept AULA_NONBLOCKING {
        return spectra_.data() + (input * ages_ + (newest_ + age) % ages_) * 2 * size_;
    }

 private:
    std::size_t ages_;
    std::size_t size_;
    std::size_t newest_ = 0;
    AlignedVector<float> spectra_;
};

/// A filter, or two within an exchange. A null filter is silence.
struct FilterBlend {
    const ConvolutionFilter* from = nullptr;
    const ConvolutionFilter* to = nullptr;
    float weight = 0;  ///< of `to`; that of `from` is the rest to 1

    bool uses(const ConvolutionFilter* filter) const noexcept AULA_NONBLOCKING {
        return filter == from || filter == to;
    }

    /// The filter of more weight alone.
    FilterBlend nearer() const noexcept AULA_NONBLOCKING { return {weight < 0.5F ? from : to}; }
};

/// Sums of products of spectra at one level for what fades out, `current`, and what fades in,
/// `next`. Partitions that both share are multiplied once.
class LevelSums {
 public:
    LevelSums(const ConvolutionShape& shape, const PartitionLevel& level, std::size_t index);

    /// Lists the products of the partitions [first, last).
    void collect(FrequencyDomainDelayLine& history, const FilterBlend& current,
                 const FilterBlend& next, std::size_t first,
                 std::size_t last) noexcept AULA_NONBLOCKING;

    std::size_t product_count() const noexcept AULA_NONBLOCKING {
        return shared_.count + current_only_.count + next_only_.count;
    }

    /// Whether the sums of current and next differ.
    bool differs() const noexcept AULA_NONBLOCKING {
        return current_only_.count > 0 || next_only_.count > 0;
    }

    /// Sets, or adds to, the sums [chunk][output] of the first `chunks`; those of next only if
    /// `with_next`.
    void set(std::size_t chunks, bool with_next, float* current,
             float* next) const noexcept AULA_NONBLOCKING;
    void add(std::size_t chunks, bool with_next, float* current,
             float* next) const noexcept AULA_NONBLOCKING;

    /// set() in slices of a few products, which run in ascending order for each range of chunks;
    /// sums of next only if differs().
    std::size_t slices() const noexcept AULA_NONBLOCKING;
    std::size_t products_in_slice(std::size_t slice) const noexcept AULA_NONBLOCKING;
    void set_slice(std::size_t slice, std::size_t first_chunk, std::size_t last_chunk,
                   float* current, float* next) const noexcept AULA_NONBLOCKING;

 private:
    /// Terms of a sum, with capacity for all partitions of the level.
    struct Terms {
        std::vector<SpectralTerm> terms;
        std::size_t count = 0;
    };
    SpectralTerms slice(std::size_t index) const noexcept AULA_NONBLOCKING;
    void multiply_add(const Terms& terms, std::size_t chunks,
                      float* sums) const noexcept AULA_NONBLOCKING;

    std::size_t inputs_;
    std::size_t outputs_;
    std::size_t index_;
    SpectralKernels::MultiplyAdd multiply_add_;
    Terms shared_;
    Terms current_only_;
    Terms next_only_;
};

/// The first level: partitions of a block, without latency. An exchange can begin at any sample.
class HeadLevel {
 public:
    HeadLevel(const ConvolutionShape& shape, const PartitionLevel& level, std::size_t fade_samples);

    /// Samples until the end of the present partition.
    std::size_t room() const noexcept AULA_NONBLOCKING { return level_.size - filled_; }

    void start_with(const ConvolutionFilter* filter) noexcept AULA_NONBLOCKING {
        current_ = filter;
        past_ready_ = false;
    }
    void exchange(const ConvolutionFilter* filter) noexcept AULA_NONBLOCKING;
    bool fading() const noexcept AULA_NONBLOCKING { return next_ != nullptr; }

    /// What is in use at the next sample.
    FilterBlend blend() const noexcept AULA_NONBLOCKING {
        if (!fading()) return {current_};
        return {current_, next_, fade_.weight(0)};
    }
    bool uses(const ConvolutionFilter* filter) const noexcept AULA_NONBLOCKING {
        return filter == current_ || filter == next_;
    }

    /// Overwrites samples [offset, offset + samples) of the outputs; `samples` is at most room().
    void process(std::span<const float* const> inputs, std::span<float* const> outputs,
                 std::size_t offset, std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    void finish_partition() noexcept AULA_NONBLOCKING;

    std::size_t inputs_;
    std::size_t outputs_;
    PartitionLevel level_;
    BlockTransform transform_;
    FrequencyDomainDelayLine history_;
    LevelSums past_;     ///< products of the previous windows
    LevelSums present_;  ///< products of the present window
    const ConvolutionFilter* current_ = nullptr;
    const ConvolutionFilter* next_ = nullptr;
    Fade fade_;  ///< to the next filter's output

    std::size_t filled_ = 0;        ///< samples received of the present partition
    bool past_ready_ = false;       ///< past_sums_ are valid for the present partition
    AlignedVector<float> windows_;  ///< [input][previous partition, present partition]
    AlignedVector<float> past_sums_, next_past_sums_;  ///< sums of the previous windows
    AlignedVector<float> sums_, next_sums_;
    AlignedVector<float> work_, output_, next_output_;
};

/// A level whose latency is two segments of one partition's length each: a segment of input is
/// received, then convolved while the next one is received, and its output is played in the segment
/// after that. The work is divided into small tasks at an even pace. The output computed in a
/// segment crossfades to the blend that the first level uses at the start of that segment, or to
/// the nearer filter of it (PartitionLevel::blends()): it follows the exchanges of the first level,
/// two segments later and in straight lines. No two levels start segments in the same block.
class TailLevel {
 public:
    TailLevel(const ConvolutionShape& shape, const PartitionLevel& level, std::size_t index);

    void start_with(const ConvolutionFilter* filter) noexcept AULA_NONBLOCKING {
        current_ = next_ = {filter};
    }
    bool uses(const ConvolutionFilter* filter) const noexcept AULA_NONBLOCKING {
        return current_.uses(filter) || next_.uses(filter);
    }

    /// The most filters in use at a time.
    std::size_t max_filters() const noexcept { return level_.blends() ? 4 : 2; }

    /// Adds to samples [offset, offset + samples) of the outputs, not beyond the end of a segment.
    /// The next segment uses `newest`.
    void process(std::span<const float* const> inputs, std::span<float* const> outputs,
                 std::size_t offset, std::size_t samples,
                 const FilterBlend& newest) noexcept AULA_NONBLOCKING;

 private:
    void start_segment(const FilterBlend& newest) noexcept AULA_NONBLOCKING;
    void finish_segment() noexcept AULA_NONBLOCKING;
    void work_until(double due) noexcept AULA_NONBLOCKING;
    void transform_input(std::size_t task) noexcept AULA_NONBLOCKING;
    void sum_products(std::size_t task) noexcept AULA_NONBLOCKING;
    void transform_output(std::size_t task) noexcept AULA_NONBLOCKING;

    /// The input segment received `age` segments ago; age 0 is the one being received.
    float* window(std::size_t age, std::size_t input) noexcept AULA_NONBLOCKING {
        constexpr std::size_t kSegments = 3;
        return windows_.data() +
               ((incoming_ + kSegments - age) % kSegments * inputs_ + input) * level_.size;
    }

    std::size_t inputs_;
    std::size_t outputs_;
    PartitionLevel level_;
    BlockTransform transform_;
    FrequencyDomainDelayLine history_;
    LevelSums sums_;
    FilterBlend current_;
    FilterBlend next_;
    std::vector<float> fade_;  ///< over a segment
    double product_cost_;      ///< cost of a chunk's product with an unchanged filter
    double exchanging_cost_;   ///< cost of a chunk's product during an exchange
    double step_cost_;         ///< cost of a step of a transform

    std::size_t position_;          ///< samples received of the present segment
    std::size_t incoming_ = 0;      ///< index of the segment being received
    AlignedVector<float> windows_;  ///< [segment][input][sample], three segments

    // The work of a segment: a sequence of tasks (input transforms, sums, output transforms).
    std::size_t sum_groups_;     ///< groups of chunks
    std::size_t sum_tasks_ = 0;  ///< [group][slice]
    std::size_t output_tasks_ = 0;
    std::size_t tasks_done_;
    double cost_done_ = 0;
    double segment_cost_ = 0;
    double group_product_cost_ = 0;  ///< cost of a product of a group's chunks
    AlignedVector<float> current_sums_, next_sums_;
    AlignedVector<float> work_;

    AlignedVector<float> next_output_;  ///< of the next filter, one output's segment
    AlignedVector<float> playing_;      ///< a segment of the outputs, [output][sample]
    AlignedVector<float> computed_;     ///< played in the next segment
};

}  // namespace aula
