#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/dsp/fft.h"
#include "audio/dsp/octave_levels.h"

namespace aula {

/// The energy attenuation coefficient of air in 1/m at a frequency in Hz; empty: no attenuation.
using AirAttenuation = std::function<double(double frequency_hz)>;

/// Designs short minimum-phase filters from pressure gains in octave bands, 63 Hz to 8 kHz. The
/// lowest band extends down to 0 Hz, the highest up to the Nyquist frequency. The mean of the
/// squared magnitude over an octave is the squared gain of its band; air attenuates each frequency
/// by its own coefficient. Equal gains without air give exactly a scaled unit impulse.
/// [propagation thread]
class BandFilterDesigner {
 public:
    /// `taps`: length of the filters, a size that fast_fft_size() returns.
    BandFilterDesigner(double sample_rate_hz, std::size_t taps, const AirAttenuation& air = {});

    std::size_t taps() const { return fft_.size(); }

    /// Writes the response, taps() samples, of a path of `length_m` in air. Gains are >= 0 and
    /// contain the attenuation by air at the centres of the bands; those below -100 dB re the
    /// greatest are raised to it. All gains zero give silence. Returns the largest error of the
    /// level of an octave, dB.
    float design(const std::array<float, 8>& gains, double length_m, std::span<float> response);

 private:
    RealFft fft_;
    /// [band][bin]: complex log response per natural logarithm of the band's gain
    std::array<std::vector<std::complex<float>>, 8> basis_;
    /// [bin]: of a metre of air, re the bands' attenuation
    std::vector<std::complex<float>> air_;
    /// [band] Mean of the coefficient over the octave, less that of its centre, 1/m.
    std::array<double, 8> air_of_octave_{};
    double longest_air_m_ = 0;  ///< the attenuation of the bands reaches the lowest gain
    OctaveLevels levels_;
    AlignedVector<std::complex<float>> spectrum_;
    AlignedVector<float> signal_;
};

}  // namespace aula
