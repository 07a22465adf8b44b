#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/realtime.h"
#include "audio/convolution/convolution_filter.h"
#include "audio/convolution/convolver_levels.h"

namespace aula {

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

    /// Exchanges the current filter for `filter`, which must live while uses(filter). Must not be
    /// called while fading(). Before the first sample a filter takes effect immediately; the first
    /// filter after that fades in from silence. A level that is still fading takes the newest
    /// filter afterwards.
    void exchange(const ConvolutionFilter* filter) noexcept AULA_NONBLOCKING;

    /// Whether the first level is fading.
    bool fading() const noexcept AULA_NONBLOCKING { return head_.fading(); }

    /// Largest number of filters in use: a current one and a next one per level.
    std::size_t most_filters() const noexcept { return 2 * (1 + tails_.size()); }

    /// Whether any level still uses a filter.
    bool uses(const ConvolutionFilter* filter) const noexcept AULA_NONBLOCKING;

    /// Convolves `samples` samples (at most a block) of inputs[input][sample] and overwrites
    /// outputs[output][sample].
    void process(std::span<const float* const> inputs, std::span<float* const> outputs,
                 std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    ConvolutionShape shape_;
    HeadLevel head_;
    std::vector<TailLevel> tails_;
    bool started_ = false;
};

}  // namespace aula
