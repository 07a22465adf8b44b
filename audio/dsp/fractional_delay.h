#pragma once

#include <array>
#include <cstddef>

#include "audio/dsp/kernels.h"
#include "aula/audio/realtime.h"

namespace aula {

/// Interpolates between samples with a tabulated Kaiser-windowed sinc (Laakso et al. 1996). The
/// error is below -90 dB up to 0.6 of the Nyquist frequency, below -83 dB up to 0.8, and zero at
/// the samples. Immutable.
class FractionalDelay {
 public:
    /// Samples needed before the one at or below the position, and after it.
    static constexpr std::size_t kBefore = kInterpolationTaps / 2 - 1;
    static constexpr std::size_t kAfter = kInterpolationTaps / 2;

    /// All share one table, which the first one computes.
    FractionalDelay();

    /// The signal at x[kBefore + fraction], 0 <= fraction < 1; reads kInterpolationTaps samples.
    /// [audio thread, wait-free]
    float read(const float* x, double fraction) const noexcept AULA_NONBLOCKING {
        const double phase = fraction * static_cast<double>(kPhases);
        const auto row = static_cast<std::size_t>(phase);
        const float* const taps = table_ + row * kInterpolationTaps;
        return interpolate(x, taps, taps + kInterpolationTaps,
                           static_cast<float>(phase - static_cast<double>(row)));
    }

    /// An impulse delayed by kBefore + fraction samples.
    std::array<float, kInterpolationTaps> impulse(double fraction) const;

 private:
    static constexpr std::size_t kPhases = 256;
    const float* table_;  ///< [phase 0 to kPhases][tap]
};

}  // namespace aula
