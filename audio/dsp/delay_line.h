#pragma once

#include <cstddef>

#include "audio/base/aligned.h"
#include "audio/dsp/fractional_delay.h"
#include "aula/audio/realtime.h"

namespace aula {

/// Delay line with fractional delays. [audio thread, except the constructor]
class DelayLine {
 public:
    /// The shortest delay: the interpolator needs this many later samples.
    static constexpr double kShortest_samples = FractionalDelay::kAfter;

    /// `interpolator` must outlive this object. Delays are up to `longest_samples`, offsets down to
    /// -`history_samples`, blocks up to `block` samples.
    DelayLine(const FractionalDelay& interpolator, std::size_t longest_samples,
              std::size_t history_samples, std::size_t block);

    /// Stores the present block.
    void write(const float* input, std::size_t samples) noexcept AULA_NONBLOCKING;

    /// Ends the present block, after all reads from it.
    void advance(std::size_t samples) noexcept AULA_NONBLOCKING {
        present_ = wrap(present_ + samples);
    }

    /// The signal `delay_samples` before sample `offset` of the present block; offsets can be
    /// negative.
    float read(std::ptrdiff_t offset, double delay_samples) const noexcept AULA_NONBLOCKING;

 private:
    /// An index below twice the length, as an index of the ring.
    std::size_t wrap(std::size_t index) const noexcept AULA_NONBLOCKING {
        return index < length_ ? index : index - length_;
    }

    const FractionalDelay& interpolator_;
    std::size_t length_;         ///< length of the ring
    AlignedVector<float> ring_;  ///< the first samples are repeated at the end
    std::size_t present_ = 0;    ///< index of the first sample of the present block
};

}  // namespace aula
