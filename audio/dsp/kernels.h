#pragma once

#include <cstddef>

#include "audio/base/realtime.h"

namespace aula {

// The inner loops of convolution and interpolation. The instruction set is chosen at run time: the
// same bytes come out on the same machine. Arrays do not overlap. [audio thread, wait-free]

/// out[n] = sum over k < taps of h[k] x[n - k]; `x` has taps - 1 samples before its first.
void filter(const float* x, const float* h, std::size_t taps, float* out,
            std::size_t samples) noexcept AULA_NONBLOCKING;

/// Taps of the interpolator that reads between samples: a windowed sinc.
inline constexpr std::size_t kInterpolationTaps = 32;

/// sum over k of x[k] (a[k] + fraction (b[k] - a[k])), kInterpolationTaps of each.
float interpolate(const float* x, const float* a, const float* b,
                  float fraction) noexcept AULA_NONBLOCKING;

}  // namespace aula
