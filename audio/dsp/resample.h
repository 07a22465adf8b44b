#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace aula {

/// Converts the sample rate of interleaved signals, [sample][channel], with linear phase and no
/// delay. The passband ends at 0.91 of the lower Nyquist frequency; the stopband is at -120 dB. n
/// samples per channel become round(n to_hz / from_hz), but at least one if n > 0. Throws
/// Failure if the resampler fails.
std::vector<float> resample(std::span<const float> interleaved, std::size_t channels,
                            double from_hz, double to_hz);

}  // namespace aula
