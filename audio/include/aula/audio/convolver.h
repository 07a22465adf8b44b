#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

/// Dimensions of a convolution of several inputs into several outputs. A convolver, its filters and
/// their transform have the same shape.
struct ConvolutionShape {
    std::size_t inputs = 1;            ///< number of input signals
    std::size_t outputs = 1;           ///< number of output signals
    std::size_t block = 256;           ///< largest number of samples per call, 1 to 8192
    std::size_t taps = 1;              ///< length of the longest filter, samples, at least 1
    bool half_precision_tail = false;  ///< all levels but the first: half the memory, -74 dB error
    /// Partitions that begin before this tap have at most 1024 taps, unless a block is longer: they
    /// follow exchanges without a pause 47 times a second at 48 kHz.
    std::size_t quick_taps = 0;
};

/// Spectra of one partition of the filters from one input to all outputs. Only a Convolver reads
/// them. Immutable while a filter refers to it.
struct FilterPartition {
    /// [chunk of bins][output] Floats or half-precision numbers; null: all zero.
    const void* spectra = nullptr;
    float scale = 1;  ///< factor of half-precision numbers
};

/// Impulse responses from every input to every output, transformed partition by partition. A
/// FilterTransform fills it. Filters of one FilterTransform share equal partitions. A filter must
/// not change while a convolver uses it (Convolver::uses()).
class ConvolutionFilter {
 public:
    /// A filter of zeros.
    explicit ConvolutionFilter(const ConvolutionShape& shape);
    ConvolutionFilter(const ConvolutionFilter&) = delete;
    ConvolutionFilter& operator=(const ConvolutionFilter&) = delete;
    /// The filter that was moved from can only be assigned to or destroyed.
    ConvolutionFilter(ConvolutionFilter&&) noexcept = default;
    /// The filter that was moved from can only be assigned to or destroyed.
    ConvolutionFilter& operator=(ConvolutionFilter&&) noexcept = default;

    /// The partitions of an input's filters at a level, in order of time. For a Convolver.
    /// [any thread, wait-free]
    const FilterPartition* partitions(std::size_t level,
                                      std::size_t input) const noexcept AULA_NONBLOCKING;

    /// Tells the FilterTransform that no convolver reads a level again until the filter is filled
    /// anew: the level is silent from then on. For a Convolver. [audio thread, wait-free]
    void release(std::size_t level) const noexcept AULA_NONBLOCKING;

 private:
    friend class FilterTransform;
    struct Level;
    std::shared_ptr<std::vector<Level>> levels_;
};

/// The levels that can take a filter, [level] 1 or 0, if a convolver that fades over `fade_samples`
/// exchanges it at sample `first` and the next one at sample `next`, counted from its first sample.
/// If exchanges can be delayed by a fade, or if `first` is 0, all levels can.
std::vector<char> levels_in_use(const ConvolutionShape& shape, std::size_t fade_samples,
                                std::int64_t first, std::int64_t next);

/// Transforms impulse responses into the filters of a Convolver. Only partitions that differ from
/// those of the previous call are transformed. The memory of a partition returns to a pool when no
/// filter refers to it, or when the convolver has released its level in all filters that do. It may
/// allocate: use it on a thread other than the audio thread, and destroy its filters on the same
/// thread.
class FilterTransform {
 public:
    /// A transform for filters of that shape. It keeps the newest partitions.
    explicit FilterTransform(const ConvolutionShape& shape);
    ~FilterTransform();
    /// The object that was moved from can only be assigned to or destroyed.
    FilterTransform(FilterTransform&&) noexcept;
    /// The object that was moved from can only be assigned to or destroyed.
    FilterTransform& operator=(FilterTransform&&) noexcept;

    /// Sets the impulse responses of an input in `filter`: one per output, each of at most
    /// ConvolutionShape::taps samples. Shorter ones are followed by zeros. Levels that are 0 in
    /// `levels` keep the newest partitions; see levels_in_use(). Without it all are set.
    void transform(std::span<const std::span<const float>> responses, std::size_t input,
                   ConvolutionFilter& filter, std::span<const char> levels = {});

    /// Sets the impulse responses of an input in `filter` to those of the last transform() of that
    /// input; without one, to zeros.
    void repeat(std::size_t input, ConvolutionFilter& filter);

    /// Memory of the spectra of all filters.
    std::size_t memory_bytes() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Non-uniformly partitioned overlap-save convolution without latency (Gardner 1995; Garcia 2002):
/// output sample n includes input sample n. Filters are divided into levels, each of partitions of
/// equal size; later levels have larger partitions. The first level, with partitions of a block, is
/// computed within the call. The work of the others is spread evenly over the calls. A call takes
/// any number of samples up to a block; whole blocks are the cheapest.
///
/// A filter is exchanged by crossfades between the outputs of the old and the new filter, each
/// computed from the whole history of the inputs. The first level fades from the next sample on.
/// The others follow it two of their partitions later, in a straight line over each partition,
/// those with partitions of more than 1024 taps from one filter to another one. The weights are
/// straight lines with rounded corners: where filters are exchanged without a pause, and each
/// differs a little from the one before, the response changes at a steady rate. Until the first
/// exchange the output is silent.
///
/// All functions but the constructor are for the audio thread: they are wait-free.
class Convolver {
 public:
    /// The first level fades over `fade_samples` samples. Allocates all memory.
    Convolver(const ConvolutionShape& shape, std::size_t fade_samples);
    ~Convolver();
    /// The convolver that was moved from can only be assigned to or destroyed.
    Convolver(Convolver&&) noexcept;
    /// The convolver that was moved from can only be assigned to or destroyed.
    Convolver& operator=(Convolver&&) noexcept;

    /// Exchanges the current filter for `filter`, which is not null, has the same shape and must
    /// live while uses() is true for it. Must not be called while fading() is true. Before the
    /// first sample a filter takes effect immediately. If the first filter comes later, it fades in
    /// from silence.
    void exchange(const ConvolutionFilter* filter) noexcept AULA_NONBLOCKING;

    /// True while the first level is fading.
    bool fading() const noexcept AULA_NONBLOCKING;

    /// Largest number of filters in use at the same time: a current and a next one, and those of
    /// the beginning and the end of a partition for each other level.
    std::size_t max_filters() const noexcept;

    /// True while any level uses a filter. Afterwards the filter may be changed or destroyed.
    bool uses(const ConvolutionFilter* filter) const noexcept AULA_NONBLOCKING;

    /// Releases the levels of a filter that it does not use, and does not use later unless the
    /// filter is exchanged again; see ConvolutionFilter::release(). It must have been exchanged.
    void release_unused(const ConvolutionFilter* filter) const noexcept AULA_NONBLOCKING;

    /// Convolves inputs[input][sample] and overwrites outputs[output][sample]. `samples` is at most
    /// ConvolutionShape::block.
    void process(std::span<const float* const> inputs, std::span<float* const> outputs,
                 std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
