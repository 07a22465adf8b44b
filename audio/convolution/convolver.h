#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/realtime.h"
#include "audio/convolution/convolution_filter.h"
#include "audio/convolution/convolver_levels.h"

namespace aula {

/// Convolution without latency: output sample n hears input sample n. Filters are cut into levels
/// of partitions (partition_levels.h): the first, of a block, is done at once; the work of the
/// others is spread evenly over the calls. Calls of any size up to a block; whole blocks are the
/// cheapest. A filter is exchanged by raised-cosine crossfades of the outputs, level by level, all
/// heard through the whole history of the inputs: the first level fades from the next sample on,
/// the others when that is done, one after another, so that no block bears it all. [audio thread,
/// but for the constructor]
class Convolver {
 public:
    /// `fade_samples` is for the first level, the others fade over a partition of their own.
    Convolver(const ConvolutionShape& shape, std::size_t fade_samples);

    /// Plays on through `filter`, which must live as long as it is used; not to be called while
    /// fading(). Before the first sample a filter is taken as it is, the first one after that fades
    /// in from silence. A level that is still busy with a filter takes the newest when it is ready.
    void exchange(const ConvolutionFilter* filter) noexcept AULA_NONBLOCKING;

    /// Whether the first level is fading.
    bool fading() const noexcept AULA_NONBLOCKING { return head_.fading(); }

    /// Filters in use at most: each level has one that is heard and one that fades in.
    std::size_t most_filters() const noexcept { return 2 * (1 + tails_.size()); }

    /// Whether any level needs a filter still.
    bool uses(const ConvolutionFilter* filter) const noexcept AULA_NONBLOCKING;

    /// Overwrites the outputs.
    void process(std::span<const float* const> inputs, std::span<float* const> outputs,
                 std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    ConvolutionShape shape_;
    HeadLevel head_;
    std::vector<TailLevel> tails_;
    bool started_ = false;
};

}  // namespace aula
