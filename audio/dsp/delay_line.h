#pragma once

#include <cstddef>

#include "audio/base/aligned.h"
#include "audio/base/realtime.h"
#include "audio/dsp/fractional_delay.h"

namespace aula {

/// The past of a signal, to be read between its samples. [audio thread, but for the constructor]
class DelayLine {
 public:
    /// The shortest delay that can be read: the reader needs samples from both sides.
    static constexpr double kShortest_samples = FractionalDelay::kAfter;

    /// `interpolator` outlives this. Delays up to `longest_samples` can be read back to
    /// `history_samples` before the block in hand, of at most `block` samples.
    DelayLine(const FractionalDelay& interpolator, std::size_t longest_samples,
              std::size_t history_samples, std::size_t block);

    /// Takes in the block in hand; after all readers are done with it, advance().
    void write(const float* input, std::size_t samples) noexcept AULA_NONBLOCKING;
    void advance(std::size_t samples) noexcept AULA_NONBLOCKING { time_ += samples; }

    /// What was written `delay_samples` before sample `offset` of the block in hand; an offset may
    /// be negative.
    float read(std::ptrdiff_t offset, double delay_samples) const noexcept AULA_NONBLOCKING;

 private:
    const FractionalDelay& interpolator_;
    std::size_t length_;         ///< of the ring, a power of two
    AlignedVector<float> ring_;  ///< its first samples once more at the end, to be read in one run
    std::size_t time_;           ///< of the first sample of the block in hand
};

}  // namespace aula
