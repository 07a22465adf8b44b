#include "audio/spatial/response_splitter.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "audio/spatial/head_responses.h"

namespace aula {

namespace {

constexpr float kLowestEnergy = 1e-8F;  // re the greatest: -80 dB

// Delays are estimated below this frequency; above it contralateral responses are too irregular.
constexpr double kDelayBand_hz = 8000;

// The delay is sought this near to the onset. Correlation with a minimum-phase response puts it
// within 1 ms of the onset; reflections of rooms and loudspeakers arrive later.
constexpr double kOnsetReach_s = 0.002;
// The onset is the first sample above this, re the peak: noise before a response of a shaded ear
// may reach -20 dB.
constexpr float kOnset = 0.5F;

// Below this frequency the head is smaller than the wavelength, and the correlation of the ears has
// one distinct peak.
constexpr double kLowBand_hz = 1500;
// The onsets of the ears differ by the interaural delay, with an error below 0.5 ms.
constexpr double kLowReach_s = 0.001;
// The delays of the ears are corrected if the interaural delay differs by more than this from that
// of the measured pair at low frequencies, because the phase of the responses is not exactly
// minimum phase and delay: about the smallest difference that is heard (Blauert 1997, 2.4.1).
// Twelve sets of eight laboratories are then within 40 us of their measurements; with 30 us, one by
// 50 us.
constexpr double kTolerance_s = 20e-6;

/// The index of the first sample that reaches kOnset of the peak.
std::size_t onset(std::span<const float> response) {
    float peak = 0;
    for (const float x : response) peak = std::max(peak, std::abs(x));
    const auto first = std::find_if(response.begin(), response.end(),
                                    [&](float x) { return std::abs(x) >= kOnset * peak; });
    return static_cast<std::size_t>(first - response.begin());
}

}  // namespace

ResponseSplitter::ResponseSplitter(std::size_t measured_samples, std::size_t taps,
                                   double sample_rate_hz)
    : sample_rate_hz_(sample_rate_hz),
      taps_(taps),
      size_(std::bit_ceil(4 * std::max(measured_samples, taps))),
      fft_(size_),
      phase_(size_),
      signal_(size_),
      measured_{Spectrum(fft_.bins()), Spectrum(fft_.bins())},
      minimum_{Spectrum(fft_.bins()), Spectrum(fft_.bins())},
      cross_(fft_.bins()),
      log_response_(fft_.bins()) {}

std::vector<std::array<SplitResponse, 2>> ResponseSplitter::split(
    const std::vector<EarPair>& measured) {
    struct Direction {
        std::array<Fit, 2> fits;
        double measured_lag_samples = 0;  ///< of the left ear re the right one, low frequencies
        double minimum_lag_samples = 0;   ///< the same of the minimum-phase versions
    };
    std::vector<std::array<SplitResponse, 2>> responses(measured.size());
    std::vector<Direction> directions(measured.size());
    double positive = 0;
    double negative = 0;
    for (std::size_t i = 0; i < measured.size(); ++i) {
        Direction& direction = directions[i];
        for (std::size_t e = 0; e < 2; ++e) {
            direction.fits[e] = fit(measured[i][e], e, responses[i][e].log_magnitude);
            positive += direction.fits[e].peaks[0].height;
            negative += direction.fits[e].peaks[1].height;
        }
        direction.measured_lag_samples = low_frequency_lag(
            measured_, direction.fits[0].onset_samples - direction.fits[1].onset_samples);
        direction.minimum_lag_samples = low_frequency_lag(minimum_, 0);
    }
    const std::size_t polarity = negative > positive ? 1 : 0;
    for (std::size_t i = 0; i < measured.size(); ++i) {
        const Direction& direction = directions[i];
        std::array<double, 2> delays;
        for (std::size_t e = 0; e < 2; ++e)
            delays[e] = direction.fits[e].peaks[polarity].lag_samples;
        const double missing_samples = direction.measured_lag_samples -
                                       direction.minimum_lag_samples - (delays[0] - delays[1]);
        if (std::abs(missing_samples) > kTolerance_s * sample_rate_hz_) {
            // The ear whose response resembles its minimum-phase version less is at fault.
            const bool is_left =
                direction.fits[0].peaks[polarity].height < direction.fits[1].peaks[polarity].height;
            if (is_left)
                delays[0] += missing_samples;
            else
                delays[1] -= missing_samples;
        }
        for (std::size_t e = 0; e < 2; ++e) responses[i][e].delay_s = delays[e] / sample_rate_hz_;
    }
    return responses;
}

std::vector<float> ResponseSplitter::minimum_phase(std::span<const float> log_magnitude) {
    phase_.complete(log_magnitude, log_response_);
    for (std::size_t k = 0; k < cross_.size(); ++k) cross_[k] = exponential(log_response_[k]);
    fft_.inverse(cross_.data(), signal_.data());
    std::vector<float> response(signal_.begin(),
                                signal_.begin() + static_cast<std::ptrdiff_t>(taps_));
    for (float& x : response) x /= static_cast<float>(size_);
    fade_out(response);
    return response;
}

/// The spectra of a response and of its minimum-phase version are kept for its ear.
ResponseSplitter::Fit ResponseSplitter::fit(std::span<const float> measured, std::size_t ear,
                                            std::vector<float>& log_magnitude) {
    std::fill(std::copy(measured.begin(), measured.end(), signal_.begin()), signal_.end(), 0.0F);
    fft_.forward(signal_.data(), measured_[ear].data());
    float greatest = 0;
    for (const std::complex<float>& bin : measured_[ear])
        greatest = std::max(greatest, std::norm(bin));
    for (const std::complex<float>& bin : measured_[ear]) {
        const double energy = std::max(std::norm(bin), greatest * kLowestEnergy);
        log_magnitude.push_back(static_cast<float>(0.5 * std::log(energy)));
    }
    phase_.complete(log_magnitude, log_response_);
    for (std::size_t k = 0; k < cross_.size(); ++k)
        minimum_[ear][k] = exponential(log_response_[k]);

    Fit fit;
    fit.onset_samples = static_cast<double>(onset(measured));
    correlate(minimum_[ear], minimum_[ear], kDelayBand_hz);
    const auto energy = double{signal_[0]};
    correlate(measured_[ear], minimum_[ear], kDelayBand_hz);
    for (std::size_t sign = 0; sign < 2; ++sign) {
        fit.peaks[sign] = peak_near(fit.onset_samples, kOnsetReach_s, sign == 0 ? 1 : -1);
        if (energy > 0) fit.peaks[sign].height /= energy;
    }
    return fit;
}

/// The delay of the left ear re the right one at low frequencies, near the expected one.
double ResponseSplitter::low_frequency_lag(const std::array<Spectrum, 2>& ears,
                                           double expected_samples) {
    correlate(ears[0], ears[1], kLowBand_hz);
    return peak_near(expected_samples, kLowReach_s, 1).lag_samples;
}

/// signal_ becomes the correlation of two signals below a frequency.
void ResponseSplitter::correlate(const Spectrum& first, const Spectrum& second, double band_hz) {
    const double band = band_hz / bin_hz();
    std::fill(cross_.begin(), cross_.end(), 0.0F);
    // The Nyquist frequency has no phase.
    cross_bins_ = std::min(cross_.size() - 1, static_cast<std::size_t>(std::ceil(band)));
    for (std::size_t k = 0; k < cross_bins_; ++k) {
        const double weight =
            0.5 + 0.5 * std::cos(std::numbers::pi * static_cast<double>(k) / band);
        cross_[k] = static_cast<float>(weight) * first[k] * std::conj(second[k]);
    }
    fft_.inverse(cross_.data(), signal_.data());
}

/// The greatest value of the correlation times `sign` within `reach_s` of a lag.
ResponseSplitter::Peak ResponseSplitter::peak_near(double lag_samples, double reach_s,
                                                   float sign) const {
    const auto size = static_cast<std::ptrdiff_t>(size_);
    const auto at = [&](std::ptrdiff_t lag) {
        return double{sign * signal_[static_cast<std::size_t>((lag % size + size) % size)]};
    };
    const auto middle = static_cast<std::ptrdiff_t>(std::lround(lag_samples));
    const auto reach = static_cast<std::ptrdiff_t>(std::ceil(reach_s * sample_rate_hz_));
    std::ptrdiff_t peak = middle - reach;
    for (std::ptrdiff_t lag = peak + 1; lag <= middle + reach; ++lag)
        if (at(lag) > at(peak)) peak = lag;
    const auto sample = static_cast<double>(peak);
    const double before = at(peak - 1);
    const double after = at(peak + 1);
    const double curvature = before - 2 * at(peak) + after;
    // At the ends of the reach there may be none.
    const bool is_maximum = at(peak) >= std::max(before, after) && curvature < 0;
    if (!is_maximum) return {at(peak), sample};
    // The vertex of the parabola through the three samples is near the maximum: within 0.06 samples
    // for the default head.
    const double vertex = 0.5 * (before - after) / curvature;
    return {at(peak), std::clamp(refined(sample + vertex), sample - 1, sample + 1)};
}

/// The extremum of the correlation, the sum over the bins of cross_ exp(i w lag), by Newton's
/// method. In a narrow band neighbouring samples are nearly equal, and rounding changes their
/// differences: these are not used.
double ResponseSplitter::refined(double lag_samples) const {
    constexpr int kNewtonSteps = 2;  // each doubles the digits: from 0.1 samples to 1e-4
    const double bin_rad = 2 * std::numbers::pi / static_cast<double>(size_);
    for (int step = 0; step < kNewtonSteps; ++step) {
        const std::complex<double> turn = std::polar(1.0, bin_rad * lag_samples);
        std::complex<double> phase = turn;
        double slope = 0;
        double curvature = 0;
        for (std::size_t k = 1; k < cross_bins_; ++k, phase *= turn) {
            const double w = bin_rad * static_cast<double>(k);
            const std::complex<double> term = std::complex<double>(cross_[k]) * phase;
            slope -= w * term.imag();
            curvature -= w * w * term.real();
        }
        if (curvature == 0) break;
        lag_samples -= slope / curvature;
    }
    return lag_samples;
}

}  // namespace aula
