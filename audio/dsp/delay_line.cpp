#include "audio/dsp/delay_line.h"

#include <cmath>

namespace aula {

DelayLine::DelayLine(const FractionalDelay& interpolator, std::size_t longest_samples,
                     std::size_t history_samples, std::size_t block)
    : interpolator_(interpolator),
      length_(longest_samples + history_samples + block + 2 * kInterpolationTaps),
      ring_(length_ + kInterpolationTaps) {}

void DelayLine::write(const float* input, std::size_t samples) noexcept {
    for (std::size_t n = 0; n < samples; ++n) {
        const std::size_t index = wrap(present_ + n);
        ring_[index] = input[n];
        if (index < kInterpolationTaps) ring_[length_ + index] = input[n];
    }
}

float DelayLine::read(std::ptrdiff_t offset, double delay_samples) const noexcept {
    const double whole = std::ceil(delay_samples);
    const double fraction = whole - delay_samples;
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(present_) + offset -
                                 static_cast<std::ptrdiff_t>(whole) -
                                 static_cast<std::ptrdiff_t>(FractionalDelay::kBefore);
    // At most the ring's length before its first sample.
    const std::size_t index =
        static_cast<std::size_t>(first < 0 ? first + static_cast<std::ptrdiff_t>(length_) : first);
    return interpolator_.read(ring_.data() + wrap(index), fraction);
}

}  // namespace aula
