#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/dsp/fft.h"

namespace aula {

/// Designs short minimum-phase filters from pressure gains in octave bands, 63 Hz to 8 kHz. The
/// lowest band extends down to 0 Hz, the highest up to the Nyquist frequency. Equal gains give
/// exactly a scaled unit impulse. The frequency resolution is sample rate / taps: narrower bands
/// blend with their neighbours. [propagation thread]
class BandFilterDesigner {
 public:
    /// `taps`: length of the filters, a size that fast_fft_size() returns.
    BandFilterDesigner(double sample_rate_hz, std::size_t taps);

    std::size_t taps() const { return fft_.size(); }

    /// Writes the response, taps() samples. Gains are >= 0; those below -100 dB re the greatest are
    /// raised to it. All gains zero give silence.
    void design(const std::array<float, 8>& gains, std::span<float> response);

 private:
    RealFft fft_;
    /// [band][bin]: complex log response per natural logarithm of the band's gain
    std::array<std::vector<std::complex<float>>, 8> basis_;
    AlignedVector<std::complex<float>> spectrum_;
    AlignedVector<float> signal_;
};

}  // namespace aula
