#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/base/realtime.h"
#include "audio/convolution/block_transform.h"
#include "audio/convolution/convolution_filter.h"
#include "audio/convolution/partition_levels.h"
#include "audio/dsp/fade.h"

namespace aula {

/// Spectra of the newest windows of every input at one level.
class SpectralHistory {
 public:
    SpectralHistory(std::size_t inputs, const PartitionLevel& level);

    /// Makes room for new windows, of age 0, in place of the oldest.
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

/// The products of one level that are to be summed up for the filter that is heard, `current`, and
/// for the one that fades in, `next`; a null filter is silence. Partitions that both have are
/// multiplied once.
class LevelSums {
 public:
    LevelSums(const ConvolutionShape& shape, const PartitionLevel& level, std::size_t index);

    /// Lists the products of the partitions first to last - 1; without a next filter it is null,
    /// like current.
    void collect(SpectralHistory& history, const ConvolutionFilter* current,
                 const ConvolutionFilter* next, std::size_t first,
                 std::size_t last) noexcept AULA_NONBLOCKING;

    std::size_t product_count() const noexcept AULA_NONBLOCKING {
        return shared_.count + current_only_.count + next_only_.count;
    }

    /// Whether current and next have different sums.
    bool differs() const noexcept AULA_NONBLOCKING {
        return current_only_.count > 0 || next_only_.count > 0;
    }

    /// Sets, or adds to, the sums [chunk][output] of a range of chunks; those of next only where
    /// `with_next`.
    void set(std::size_t first_chunk, std::size_t last_chunk, bool with_next, float* current,
             float* next) const noexcept AULA_NONBLOCKING;
    void add(std::size_t first_chunk, std::size_t last_chunk, bool with_next, float* current,
             float* next) const noexcept AULA_NONBLOCKING;

    /// set() in slices of a few products, to be done in order for each range of chunks; sums of
    /// next only where differs().
    std::size_t slices() const noexcept AULA_NONBLOCKING;
    std::size_t products_of(std::size_t slice) const noexcept AULA_NONBLOCKING;
    void set_slice(std::size_t slice, std::size_t first_chunk, std::size_t last_chunk,
                   float* current, float* next) const noexcept AULA_NONBLOCKING;

 private:
    /// Room for all products there can be.
    struct Terms {
        std::vector<SpectralTerm> terms;
        std::size_t count = 0;
    };
    SpectralTerms slice(std::size_t index) const noexcept AULA_NONBLOCKING;
    void multiply_add(const Terms& terms, std::size_t first_chunk, std::size_t last_chunk,
                      float* sums) const noexcept AULA_NONBLOCKING;

    std::size_t inputs_;
    std::size_t outputs_;
    std::size_t index_;
    SpectralKernels::MultiplyAdd multiply_add_;
    Terms shared_;
    Terms current_only_;
    Terms next_only_;
};

/// The first level: partitions of a block, heard at once. An exchange fades from any sample on.
class HeadLevel {
 public:
    HeadLevel(const ConvolutionShape& shape, const PartitionLevel& level, std::size_t fade_samples);

    /// Samples left of the partition in hand.
    std::size_t room() const noexcept AULA_NONBLOCKING { return level_.size - filled_; }

    void start_with(const ConvolutionFilter* filter) noexcept AULA_NONBLOCKING {
        current_ = filter;
        tail_ready_ = false;
    }
    void exchange(const ConvolutionFilter* filter) noexcept AULA_NONBLOCKING;
    bool fading() const noexcept AULA_NONBLOCKING { return next_ != nullptr; }

    /// The filter that is heard, or fading out.
    const ConvolutionFilter* heard() const noexcept AULA_NONBLOCKING { return current_; }
    bool uses(const ConvolutionFilter* filter) const noexcept AULA_NONBLOCKING {
        return filter == current_ || filter == next_;
    }

    /// Overwrites samples of the outputs from `offset` on, at most room().
    void process(std::span<const float* const> inputs, std::span<float* const> outputs,
                 std::size_t offset, std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    void finish_partition() noexcept AULA_NONBLOCKING;

    std::size_t inputs_;
    std::size_t outputs_;
    PartitionLevel level_;
    BlockTransform transform_;
    SpectralHistory history_;
    LevelSums before_;  ///< products of the windows before
    LevelSums now_;     ///< products of the window in hand
    const ConvolutionFilter* current_ = nullptr;
    const ConvolutionFilter* next_ = nullptr;
    Fade fade_;  ///< to the next filter's output

    std::size_t filled_ = 0;        ///< samples of the partition in hand that are there
    bool tail_ready_ = false;       ///< the sums of the windows before are those of this partition
    AlignedVector<float> windows_;  ///< [input][partition before, partition in hand]
    AlignedVector<float> tail_, next_tail_;  ///< sums of the windows before
    AlignedVector<float> sums_, next_sums_;
    AlignedVector<float> work_, heard_, faded_in_;
};

/// A level whose frames are computed while the next frame of input comes in, and heard in the frame
/// after that: its work is cut into small pieces, done at an even pace. A filter is exchanged at
/// the start of a frame: the frame that is then computed goes over to it by a crossfade while it is
/// heard; of those that came in the meantime, the newest is taken. No two levels start frames in
/// the same block.
class TailLevel {
 public:
    TailLevel(const ConvolutionShape& shape, const PartitionLevel& level, std::size_t index);

    void start_with(const ConvolutionFilter* filter) noexcept AULA_NONBLOCKING {
        current_ = next_ = filter;
    }
    bool uses(const ConvolutionFilter* filter) const noexcept AULA_NONBLOCKING {
        return filter == current_ || filter == next_;
    }

    /// Adds to samples of the outputs from `offset` on, not beyond the end of a frame. `newest` is
    /// the filter to exchange to.
    void process(std::span<const float* const> inputs, std::span<float* const> outputs,
                 std::size_t offset, std::size_t samples,
                 const ConvolutionFilter* newest) noexcept AULA_NONBLOCKING;

 private:
    void start_frame(const ConvolutionFilter* newest) noexcept AULA_NONBLOCKING;
    void finish_frame() noexcept AULA_NONBLOCKING;
    void work_until(double due) noexcept AULA_NONBLOCKING;
    void transform_input(std::size_t piece) noexcept AULA_NONBLOCKING;
    void sum_products(std::size_t piece) noexcept AULA_NONBLOCKING;
    void transform_output(std::size_t piece) noexcept AULA_NONBLOCKING;

    /// A frame of an input, `age` frames ago; 0 is the one that comes in.
    float* window(std::size_t age, std::size_t input) noexcept AULA_NONBLOCKING {
        constexpr std::size_t kFrames = 3;
        return windows_.data() +
               ((incoming_ + kFrames - age) % kFrames * inputs_ + input) * level_.size;
    }

    std::size_t inputs_;
    std::size_t outputs_;
    PartitionLevel level_;
    BlockTransform transform_;
    SpectralHistory history_;
    LevelSums sums_;
    const ConvolutionFilter* current_ = nullptr;
    const ConvolutionFilter* next_ = nullptr;
    std::vector<float> fade_;  ///< raised cosine over a frame
    double product_cost_;      ///< of a chunk, with filters that have been heard
    double exchanging_cost_;   ///< of a chunk, with filters that are being exchanged
    double step_cost_;         ///< of a step of a transform

    std::size_t position_;          ///< samples of the frame that have come in
    std::size_t incoming_ = 0;      ///< place of the frame that comes in
    AlignedVector<float> windows_;  ///< [place][input][sample], three frames

    // The work of a frame: pieces in order, and what those done and all have cost.
    std::size_t sum_groups_;      ///< of chunks
    std::size_t sum_pieces_ = 0;  ///< [group][slice]
    std::size_t output_pieces_ = 0;
    std::size_t pieces_done_;
    double cost_done_ = 0;
    double cost_of_frame_ = 0;
    double cost_of_product_ = 0;  ///< of the chunks of a group
    AlignedVector<float> current_sums_, next_sums_;
    AlignedVector<float> work_;

    /// A frame of the outputs, [output][sample].
    struct Frame {
        AlignedVector<float> samples;
        AlignedVector<float> faded_in;  ///< what is faded to, if anything is
        bool fades = false;
    };
    Frame heard_;
    Frame computed_;  ///< heard in the next frame
};

}  // namespace aula
