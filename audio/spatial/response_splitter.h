#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/dsp/fft.h"
#include "audio/dsp/minimum_phase.h"

namespace aula {

/// Magnitude and delay of the response of an ear.
struct SplitResponse {
    std::vector<float> log_magnitude;  ///< natural logarithm, at the bins of the splitter
    double delay_s = 0;                ///< re the minimum-phase response of this magnitude
};

/// Responses of the left and of the right ear to one direction.
using EarPair = std::array<std::vector<float>, 2>;

/// Separates measured responses of the ears into magnitude and delay, and makes minimum-phase
/// responses of magnitudes. [one thread]
class ResponseSplitter {
 public:
    /// `measured_samples` is the length of the measured responses, `taps` that of minimum-phase
    /// responses.
    ResponseSplitter(std::size_t measured_samples, std::size_t taps, double sample_rate_hz);

    double bin_hz() const { return sample_rate_hz_ / static_cast<double>(size_); }

    /// Splits the responses of a set, [direction]. The set has one polarity, which is lost: a set
    /// with all signs inverted has the same magnitudes and delays, bit by bit.
    std::vector<std::array<SplitResponse, 2>> split(const std::vector<EarPair>& measured);

    /// The response of `taps` samples with this magnitude.
    std::vector<float> minimum_phase(std::span<const float> log_magnitude);

 private:
    /// A maximum of a correlation.
    struct Peak {
        double height = 0;
        double lag_samples = 0;
    };

    /// The correlation of a response with its minimum-phase version, over its energy.
    struct Fit {
        std::array<Peak, 2> peaks;  ///< of the positive and of the negative correlation
        double onset_samples = 0;
    };

    using Spectrum = AlignedVector<std::complex<float>>;

    Fit fit(std::span<const float> measured, std::size_t ear, std::vector<float>& log_magnitude);
    double low_frequency_lag(const std::array<Spectrum, 2>& ears, double expected_samples);
    void correlate(const Spectrum& first, const Spectrum& second, double band_hz);
    Peak peak_near(double lag_samples, double reach_s, float sign) const;
    double refined(double lag_samples) const;

    double sample_rate_hz_;
    std::size_t taps_;
    std::size_t size_;
    RealFft fft_;
    MinimumPhase phase_;
    AlignedVector<float> signal_;
    std::array<Spectrum, 2> measured_;  ///< of both ears
    std::array<Spectrum, 2> minimum_;   ///< of their minimum-phase versions
    Spectrum cross_;                    ///< of the correlation
    std::size_t cross_bins_ = 0;        ///< of its band
    std::vector<std::complex<float>> log_response_;
};

}  // namespace aula
