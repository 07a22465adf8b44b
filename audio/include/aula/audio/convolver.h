#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

/// Dimensions of a convolution of several inputs into several outputs, common to a convolver, its
/// filters and their transform.
struct ConvolutionShape {
    std::size_t inputs = 1;
    std::size_t outputs = 1;
    std::size_t block = 256;           ///< largest number of samples per call, at most 8192
    std::size_t taps = 1;              ///< length of the longest filter, samples
    bool half_precision_tail = false;  ///< all levels but the first: half the memory, -74 dB error
};

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
    ~FilterTransform();
    FilterTransform(FilterTransform&&) noexcept;
    FilterTransform& operator=(FilterTransform&&) noexcept;

    /// Sets the impulse responses of an input: one per output, each of at most shape.taps samples.
    void transform(std::span<const std::span<const float>> responses, std::size_t input,
                   ConvolutionFilter& filter);

    /// Sets an input's impulse responses to those of the call before.
    void repeat(std::size_t input, ConvolutionFilter& filter) const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Non-uniformly partitioned overlap-save convolution without latency (Gardner 1995; Garcia 2002):
/// output sample n includes input sample n. Filters are cut into levels of equal partitions
/// (partition_levels.h). The first level, with partitions of a block, is computed within the call;
/// the work of the others is spread evenly over the calls. A call takes any number of samples up to
/// a block; whole blocks are the cheapest.
///
/// A filter is exchanged by raised-cosine crossfades between outputs, each computed from the whole
/// history of the inputs. The first level fades from the next sample on, the others after it, one
/// after another, so that the cost is spread over blocks. [audio thread, except the constructor]
class Convolver {
 public:
    /// The first level fades over `fade_samples`, every other level over one of its partitions.
    Convolver(const ConvolutionShape& shape, std::size_t fade_samples);
    ~Convolver();
    Convolver(Convolver&&) noexcept;
    Convolver& operator=(Convolver&&) noexcept;

    /// Exchanges the current filter for `filter`, which must live while uses(filter). Must not be
    /// called while fading(). Before the first sample a filter takes effect immediately; the first
    /// filter after that fades in from silence. A level that is still fading takes the newest
    /// filter afterwards.
    void exchange(const ConvolutionFilter* filter) noexcept AULA_NONBLOCKING;

    /// Whether the first level is fading.
    bool fading() const noexcept AULA_NONBLOCKING;

    /// Largest number of filters in use: a current one and a next one per level.
    std::size_t most_filters() const noexcept;

    /// Whether any level still uses a filter.
    bool uses(const ConvolutionFilter* filter) const noexcept AULA_NONBLOCKING;

    /// Convolves `samples` samples (at most a block) of inputs[input][sample] and overwrites
    /// outputs[output][sample].
    void process(std::span<const float* const> inputs, std::span<float* const> outputs,
                 std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
