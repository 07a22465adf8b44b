#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/dsp/fft.h"

namespace aula {

/// Designs short minimum-phase filters from pressure gains in octave bands, 63 Hz to 8 kHz; the
/// lowest band reaches down to 0 Hz, the highest up to the Nyquist frequency. Equal gains give
/// exactly a scaled unit impulse. A band narrower than a bin of the filter's length (sample rate /
/// taps) melts into its neighbours. [propagation thread]
class BandFilterDesigner {
 public:
    /// `taps`: length of the filters, a fast size of the transform.
    BandFilterDesigner(double sample_rate_hz, std::size_t taps);

    std::size_t taps() const { return fft_.size(); }

    /// Writes taps() samples. Gains are >= 0; one below -100 dB of the greatest is raised to that.
    void design(const std::array<float, 8>& gains, std::span<float> response);

 private:
    RealFft fft_;
    /// [band][bin]: complex logarithm of the minimum-phase response per natural logarithm of the
    /// band's gain
    std::array<std::vector<std::complex<float>>, 8> basis_;
    AlignedVector<std::complex<float>> spectrum_;
    AlignedVector<float> signal_;
};

}  // namespace aula
