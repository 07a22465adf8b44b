#pragma once

#include <cstddef>

#include "aula/audio/realtime.h"

namespace aula {

// Inner loops of filtering and interpolation. The instruction set is chosen at run time, so that
// results are identical on one machine only. Arrays do not overlap. [audio thread, wait-free]

/// out[n] = sum over k < taps of h[k] x[n - k]; x[-(taps - 1)] to x[samples - 1] are read.
void filter(const float* x, const float* h, std::size_t taps, float* out,
            std::size_t samples) noexcept AULA_NONBLOCKING;

/// Taps of the windowed-sinc interpolator.
inline constexpr std::size_t kInterpolationTaps = 32;

/// sum over k < kInterpolationTaps of x[k] (a[k] + fraction (b[k] - a[k])).
float interpolate(const float* x, const float* a, const float* b,
                  float fraction) noexcept AULA_NONBLOCKING;

}  // namespace aula
