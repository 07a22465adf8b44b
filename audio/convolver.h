#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "audio/aligned.h"
#include "audio/fft.h"
#include "audio/realtime.h"

namespace aula {

/// The measure of a convolution of several inputs into several outputs; filters, transforms and
/// convolvers that work together share it.
struct ConvolutionShape {
    std::size_t inputs = 1;
    std::size_t outputs = 1;
    std::size_t block = 256;  ///< largest number of samples of a call
    std::size_t taps = 1;     ///< of the longest filter

    std::size_t partition() const;        ///< samples of a partition: at least a block
    std::size_t partition_count() const;  ///< of the longest filter
    std::size_t padded_bins() const;      ///< of a split spectrum
};

/// Impulse responses from every input to every output, transformed partition by partition. All
/// memory is there from construction on. Not changed while a convolver uses it.
class ConvolutionFilter {
 public:
    explicit ConvolutionFilter(const ConvolutionShape& shape);

    /// Partitions of an input's filters that are not all zero.
    std::size_t partition_count(std::size_t input) const { return counts_[input]; }

    /// Split spectrum, scaled for an inverse transform without a factor.
    const float* spectrum(std::size_t input, std::size_t partition, std::size_t output) const {
        return spectra_.data() + offset(input, partition, output);
    }

 private:
    friend class FilterTransform;
    std::size_t offset(std::size_t input, std::size_t partition, std::size_t output) const {
        return ((input * partitions_ + partition) * outputs_ + output) * stride_;
    }

    std::size_t partitions_;
    std::size_t outputs_;
    std::size_t stride_;
    std::vector<std::size_t> counts_;
    AlignedVector<float> spectra_;  ///< [input][partition][output][split spectrum]
};

/// Fills filters. [propagation thread]
class FilterTransform {
 public:
    explicit FilterTransform(const ConvolutionShape& shape);

    /// Sets an input's impulse responses, one for each output, each at most shape.taps long.
    void transform(std::span<const std::span<const float>> responses, std::size_t input,
                   ConvolutionFilter& filter);

 private:
    ConvolutionShape shape_;
    RealFft fft_;
    AlignedVector<float> signal_;
    AlignedVector<std::complex<float>> spectrum_;
};

/// Convolution with partitions of one size (overlap-save), without latency: output sample n hears
/// input sample n. Calls of any size up to a block; whole partitions are the cheapest. A filter is
/// exchanged by a raised-cosine crossfade of its output with that of the filter before, both heard
/// through the whole history of the inputs. [audio thread, but for the constructor]
class Convolver {
 public:
    Convolver(const ConvolutionShape& shape, std::size_t fade_samples);

    /// Plays on through `filter`, which must live until it is spent; not to be called while
    /// fading(). The first filter is taken without a fade; before it the output is zero.
    void exchange(const ConvolutionFilter* filter) noexcept AULA_NONBLOCKING;

    /// Whether an exchange is under way; when it is not, the filter before is no longer used.
    bool fading() const noexcept AULA_NONBLOCKING { return next_.filter != nullptr; }

    /// Overwrites the outputs.
    void process(std::span<const float* const> inputs, std::span<float* const> outputs,
                 std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    /// A filter being heard, with what the partitions after the first add to the output of the
    /// input partition in hand.
    struct Voice {
        const ConvolutionFilter* filter = nullptr;
        bool tail_ready = false;
        AlignedVector<float> tail;  ///< [output][split spectrum]
    };

    void process_part(std::span<const float* const> inputs, std::span<float* const> outputs,
                      std::size_t offset, std::size_t samples) noexcept AULA_NONBLOCKING;
    void prepare_tail(Voice& voice) noexcept AULA_NONBLOCKING;
    const float* voice_output(const Voice& voice, std::size_t output) noexcept AULA_NONBLOCKING;
    float* input_spectrum(std::size_t input, std::size_t age) noexcept AULA_NONBLOCKING;

    ConvolutionShape shape_;
    std::size_t partition_;
    std::size_t partitions_;
    std::size_t stride_;  ///< floats of a split spectrum
    RealFft fft_;

    std::size_t filled_ = 0;        ///< samples of the partition in hand that are there
    AlignedVector<float> windows_;  ///< [input][partition before, partition in hand]
    AlignedVector<float> spectra_;  ///< [input][ring of partitions][split spectrum]
    std::size_t newest_ = 0;        ///< place in the ring of the partition in hand
    Voice current_;
    Voice next_;
    std::vector<float> fade_;  ///< weight of the next filter's output
    std::size_t fade_position_ = 0;

    AlignedVector<float> sum_;  ///< split spectrum
    AlignedVector<std::complex<float>> interleaved_;
    AlignedVector<float> signal_;
};

/// Rising half of a raised cosine: the weight that fades in over `samples`, sample by sample.
std::vector<float> raised_cosine(std::size_t samples);

}  // namespace aula
