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

/// The exact centre of an octave, Hz (IEC 61260-1).
double octave_centre_hz(std::size_t band) {
    return 1000 * std::pow(10.0, 0.3 * (static_cast<double>(band) - 4));
}

/// Mean over a half of a crossover of the energy re that of the band, where the neighbouring band
/// has `excess` times the natural logarithm of a gain.
double crossover_energy(double excess) {
    // The weight of the neighbour falls from 1/2 at the edge to 0. By the midpoint rule: within
    // 1 % up to 20 dB.
    constexpr int kPoints = 8;
    double sum = 0;
    for (int i = 0; i < kPoints; ++i) {
        const double position = (i + 0.5) / kPoints;
        const double weight = 0.5 - 0.5 * std::sin(std::numbers::pi / 2 * position);
        sum += std::exp(2 * excess * weight);
    }
    return sum / kPoints;
}

/// Adds to the logarithms of the gains what the crossovers take from the octaves, or add to them.
void level_octaves(std::array<double, kBands>& log_gains) {
    // Shares of an octave, in Hz, that its lower and its upper crossover take.
    const double low_share = std::exp2(kTransition_octaves / 2) - 1;
    const double high_share = 2 * (1 - std::exp2(-kTransition_octaves / 2));
    const std::array<double, kBands> wanted = log_gains;
    // The second iteration leaves 0.1 dB where neighbours differ by 20 dB.
    for (int iteration = 0; iteration < 2; ++iteration) {
        const std::array<double, kBands> gains = log_gains;
        for (std::size_t b = 0; b < kBands; ++b) {
            double energy = 1;
            if (b > 0) energy += low_share * (crossover_energy(gains[b - 1] - gains[b]) - 1);
            if (b + 1 < kBands)
                energy += high_share * (crossover_energy(gains[b + 1] - gains[b]) - 1);
            log_gains[b] += std::clamp(wanted[b] - gains[b] - 0.5 * std::log(energy), -1.0, 1.0);
        }
    }
}

}  // namespace

BandFilterDesigner::BandFilterDesigner(double sample_rate_hz, std::size_t taps,
                                       const AirAttenuation& air)
    : fft_(taps), levels_(sample_rate_hz, taps), spectrum_(fft_.bins()), signal_(taps) {
    MinimumPhase fine(taps * kRefinement);
    std::vector<float> magnitude(fine.bins());
    std::vector<std::complex<float>> log_response(fine.bins());
    const auto complete = [&](auto log_magnitude, std::vector<std::complex<float>>& basis) {
        for (std::size_t k = 0; k < fine.bins(); ++k) {
            const double frequency_hz =
                sample_rate_hz * static_cast<double>(k) / static_cast<double>(taps * kRefinement);
            magnitude[k] = static_cast<float>(log_magnitude(frequency_hz));
        }
        fine.complete(magnitude, log_response);
        basis.resize(fft_.bins());
        for (std::size_t k = 0; k < fft_.bins(); ++k) basis[k] = log_response[k * kRefinement];
    };
    for (std::size_t b = 0; b < kBands; ++b)
        complete([&](double frequency_hz) { return band_weight(frequency_hz, b); }, basis_[b]);
    if (!air) return;

    std::array<double, kBands> centre{};
    for (std::size_t b = 0; b < kBands; ++b) centre[b] = air(octave_centre_hz(b));
    const auto excess = [&](double frequency_hz) {
        double of_bands = 0;
        for (std::size_t b = 0; b < kBands; ++b)
            of_bands += band_weight(frequency_hz, b) * centre[b];
        return air(frequency_hz) - of_bands;
    };
    // Energy decays as exp(-m length), pressure as exp(-m length / 2).
    complete([&](double frequency_hz) { return -0.5 * excess(frequency_hz); }, air_);
    for (std::size_t b = 0; b < kBands; ++b) {
        constexpr int kPoints = 32;
        for (int i = 0; i < kPoints; ++i)
            air_of_octave_[b] += (air(octave_centre_hz(b) * std::numbers::sqrt2 *
                                      (0.5 + 0.5 * (i + 0.5) / kPoints)) -
                                  centre[b]) /
                                 kPoints;
    }
    const double strongest = *std::max_element(centre.begin(), centre.end());
    if (strongest > 0) longest_air_m_ = -2 * std::log(double{kLowestGain}) / strongest;
}

// The minimum-phase log response is linear in the log magnitude: log H = sum over b of
// ln(gain_b) basis_b + length air.
float BandFilterDesigner::design(const std::array<float, 8>& gains, double length_m,
                                 std::span<float> response) {
    assert(response.size() == taps());
    const float greatest = *std::max_element(gains.begin(), gains.end());
    if (greatest <= 0) {
        std::fill(response.begin(), response.end(), 0.0F);
        return 0;
    }
    std::array<double, kBands> log_gains{};
    bool flat = true;
    for (std::size_t b = 0; b < kBands; ++b) {
        log_gains[b] = std::log(double{std::max(gains[b] / greatest, kLowestGain)});
        flat = flat && log_gains[b] == 0;
    }
    const double air_m = std::min(length_m, longest_air_m_);
    if (flat && air_m == 0) {
        std::fill(response.begin(), response.end(), 0.0F);
        response[0] = greatest;
        return 0;
    }
    level_octaves(log_gains);
    std::fill(spectrum_.begin(), spectrum_.end(), 0.0F);
    for (std::size_t b = 0; b < kBands; ++b) {
        const auto log_gain = static_cast<float>(log_gains[b]);
        if (log_gain == 0) continue;
        for (std::size_t k = 0; k < spectrum_.size(); ++k) spectrum_[k] += log_gain * basis_[b][k];
    }
    if (air_m > 0) {
        const auto metres = static_cast<float>(air_m);
        for (std::size_t k = 0; k < spectrum_.size(); ++k) spectrum_[k] += metres * air_[k];
    }
    for (std::complex<float>& bin : spectrum_) bin = exponential(bin);
    fft_.inverse(spectrum_.data(), signal_.data());
    const float scale = greatest / static_cast<float>(taps());
    for (std::size_t n = 0; n < taps(); ++n) response[n] = scale * signal_[n];
    std::array<float, kBands> octave_gains = gains;
    for (std::size_t b = 0; b < kBands; ++b)
        octave_gains[b] *= static_cast<float>(std::exp(-0.5 * air_m * air_of_octave_[b]));
    return levels_.correct(octave_gains, response);
}

}  // namespace aula
