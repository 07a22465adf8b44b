#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace aula {

/// Changes the sample rate of interleaved signals with linear phase and no delay, passing up to
/// 0.91 of the lower Nyquist frequency, all else 120 dB down. Gives round(frames * to / from)
/// frames, but at least one of any signal that has one.
std::vector<float> resample(std::span<const float> interleaved, std::size_t channels,
                            double from_hz, double to_hz);

}  // namespace aula
