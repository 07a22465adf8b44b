#include "audio/dsp/band_filter.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "audio/dsp/minimum_phase.h"

namespace aula {

namespace {

constexpr std::size_t kBands = 8;
constexpr float kLowestGain = 1e-5F;  // -100 dB

// Width of the crossover between bands: narrow enough that each octave has its band's level, wide
// enough that the response stays short.
constexpr double kTransition_octaves = 0.2;

// The cepstrum of a band's weight decays slowly. A transform larger by this factor limits its
// aliasing.
constexpr std::size_t kRefinement = 16;

/// Weight of the bands above the edge between `band` and the next one.
double weight_above(double frequency_hz, std::size_t band) {
    if (frequency_hz <= 0) return 0;
    const double edge_hz = 62.5 * std::numbers::sqrt2 * std::exp2(static_cast<double>(band));
    const double position = std::log2(frequency_hz / edge_hz) / kTransition_octaves + 0.5;
    return 0.5 - 0.5 * std::cos(std::numbers::pi * std::clamp(position, 0.0, 1.0));
}

/// The weights of all bands sum to 1 at every frequency.
double band_weight(double frequency_hz, std::size_t band) {
    const double low = band == 0 ? 1 : weight_above(frequency_hz, band - 1);
    const double high = band + 1 == kBands ? 0 : weight_above(frequency_hz, band);
    return low - high;
}

}  // namespace

BandFilterDesigner::BandFilterDesigner(double sample_rate_hz, std::size_t taps)
    : fft_(taps), spectrum_(fft_.bins()), signal_(taps) {
    MinimumPhase fine(taps * kRefinement);
    std::vector<float> weights(fine.bins());
    std::vector<std::complex<float>> log_response(fine.bins());
    for (std::size_t b = 0; b < kBands; ++b) {
        for (std::size_t k = 0; k < fine.bins(); ++k) {
            const double frequency_hz =
                sample_rate_hz * static_cast<double>(k) / static_cast<double>(taps * kRefinement);
            weights[k] = static_cast<float>(band_weight(frequency_hz, b));
        }
        fine.complete(weights, log_response);
        basis_[b].resize(fft_.bins());
        for (std::size_t k = 0; k < fft_.bins(); ++k) {
            basis_[b][k] = log_response[k * kRefinement];
        }
    }
}

// The minimum-phase log response is linear in the log magnitude: log H = sum over b of
// ln(gain_b) basis_b.
void BandFilterDesigner::design(const std::array<float, 8>& gains, std::span<float> response) {
    assert(response.size() == taps());
    const float greatest = *std::max_element(gains.begin(), gains.end());
    if (greatest <= 0) {
        std::fill(response.begin(), response.end(), 0.0F);
        return;
    }
    std::fill(spectrum_.begin(), spectrum_.end(), 0.0F);
    bool flat = true;
    for (std::size_t b = 0; b < kBands; ++b) {
        const float log_gain = std::log(std::max(gains[b] / greatest, kLowestGain));
        if (log_gain == 0) continue;
        flat = false;
        for (std::size_t k = 0; k < spectrum_.size(); ++k) spectrum_[k] += log_gain * basis_[b][k];
    }
    if (flat) {
        std::fill(response.begin(), response.end(), 0.0F);
        response[0] = greatest;
        return;
    }
    for (std::complex<float>& bin : spectrum_) {
        bin = std::polar(std::exp(bin.real()), bin.imag());
    }
    fft_.inverse(spectrum_.data(), signal_.data());
    const float scale = greatest / static_cast<float>(taps());
    for (std::size_t n = 0; n < taps(); ++n) response[n] = scale * signal_[n];
}

}  // namespace aula
