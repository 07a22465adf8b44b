#include "audio/dsp/delay_line.h"

#include <bit>
#include <cmath>

namespace aula {

DelayLine::DelayLine(const FractionalDelay& interpolator, std::size_t longest_samples,
                     std::size_t history_samples, std::size_t block)
    : interpolator_(interpolator),
      length_(std::bit_ceil(longest_samples + history_samples + block + 2 * kInterpolationTaps)),
      ring_(length_ + kInterpolationTaps),
      time_(length_) {}

void DelayLine::write(const float* input, std::size_t samples) noexcept {
    for (std::size_t n = 0; n < samples; ++n) {
        const std::size_t index = (time_ + n) & (length_ - 1);
        ring_[index] = input[n];
        if (index < kInterpolationTaps) ring_[length_ + index] = input[n];
    }
}

float DelayLine::read(std::ptrdiff_t offset, double delay_samples) const noexcept {
    const double whole = std::ceil(delay_samples);
    const double fraction = whole - delay_samples;
    const std::size_t first = time_ + static_cast<std::size_t>(offset) -
                              static_cast<std::size_t>(whole) - FractionalDelay::kBefore;
    return interpolator_.read(ring_.data() + (first & (length_ - 1)), fraction);
}

}  // namespace aula
