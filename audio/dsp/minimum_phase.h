#pragma once

#include <complex>
#include <cstddef>
#include <span>

#include "audio/base/aligned.h"
#include "audio/dsp/fft.h"

namespace aula {

/// A value of a spectrum from its logarithm. C libraries round functions of single precision
/// differently.
inline std::complex<float> exponential(const std::complex<float>& log_value) {
    return std::complex<float>(std::exp(std::complex<double>(log_value)));
}

/// Computes the minimum phase that belongs to a magnitude response. [one thread]
class MinimumPhase {
 public:
    /// `size` of the transform: several times the length of the response, to limit the aliasing of
    /// the cepstrum.
    explicit MinimumPhase(std::size_t size);

    std::size_t bins() const { return fft_.bins(); }

    /// log H = ln |H| + i arg H from ln |H|, both at bins() frequencies from 0 to the Nyquist
    /// frequency.
    void complete(std::span<const float> log_magnitude,
                  std::span<std::complex<float>> log_response);

 private:
    RealFft fft_;
    AlignedVector<std::complex<float>> spectrum_;
    AlignedVector<float> cepstrum_;
};

}  // namespace aula
