#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

#include "audio/dsp/fft.h"
#include "audio/dsp/fractional_delay.h"
#include "audio/spatial/sofa_file.h"
#include "tests/audio/spatial/directions.h"

namespace aula::test {

inline constexpr double kSphereRate_hz = 48000;

/// The ears at +y and -y of a sphere of radius 8.75 cm after Brown and Duda 1998: Woodworth's
/// delay, and a filter of one pole and one zero for the shadow.
inline HeadMeasurements spherical_head(const std::vector<Direction>& directions) {
    constexpr double kRadius_s = 0.0875 / 343;
    constexpr double kOnset_samples = 60;
    HeadMeasurements head;
    head.file = "sphere.sofa";
    head.sample_rate_hz = static_cast<float>(kSphereRate_hz);
    head.samples = 256;
    const FractionalDelay interpolator;
    for (const Direction& d : directions) {
        head.positions.push_back(d);
        for (const double side : {1.0, -1.0}) {
            const double angle = std::acos(std::min(1.0, std::max(-1.0, side * double{d[1]})));
            const double delay =
                angle < std::numbers::pi / 2 ? -std::cos(angle) : angle - std::numbers::pi / 2;
            // The shadow is deepest at 150 degrees.
            const double alpha = 1.05 + 0.95 * std::cos(angle * 180 / 150);
            // (1 + alpha s / 2 w) / (1 + s / 2 w) with w = c / radius, by the bilinear transform.
            const double ratio = kRadius_s * kSphereRate_hz;
            const double b0 = 1 + alpha * ratio;
            const double b1 = 1 - alpha * ratio;
            const double a0 = 1 + ratio;
            const double a1 = 1 - ratio;
            const double position = kOnset_samples + delay * kRadius_s * kSphereRate_hz;
            const double whole = std::floor(position);
            const auto impulse = interpolator.impulse(position - whole);
            std::vector<float> response(head.samples);
            double in = 0;
            double out = 0;
            for (std::size_t n = 0; n < head.samples; ++n) {
                const std::size_t first =
                    static_cast<std::size_t>(whole) - FractionalDelay::kBefore;
                const double x =
                    n >= first && n < first + impulse.size() ? double{impulse[n - first]} : 0;
                out = (b0 * x + b1 * in - a1 * out) / a0;
                in = x;
                response[n] = static_cast<float>(out);
            }
            head.responses.insert(head.responses.end(), response.begin(), response.end());
        }
    }
    head.delays_samples.resize(2 * directions.size());
    return head;
}

/// The interaural time difference at low frequencies: the delay of the right ear re the left one
/// that maximises their correlation below 1.5 kHz. `delay_s` is a further delay of the right ear.
inline double low_frequency_itd_s(const std::vector<float>& left, const std::vector<float>& right,
                                  double delay_s, double sample_rate_hz) {
    constexpr std::size_t kSize = 4096;
    RealFft fft(kSize);
    std::array<std::vector<std::complex<float>>, 2> spectra;
    for (std::size_t e = 0; e < 2; ++e) {
        std::vector<float> signal = e == 0 ? left : right;
        signal.resize(kSize);
        spectra[e].resize(fft.bins());
        fft.forward(signal.data(), spectra[e].data());
    }
    const double bin_hz = sample_rate_hz / kSize;
    double best = -1e30;
    double best_s = 0;
    for (double lag_s = -1.5e-3; lag_s < 1.5e-3; lag_s += 2e-6) {
        double sum = 0;
        for (std::size_t k = 0; static_cast<double>(k) * bin_hz < 1500; ++k) {
            const double frequency_hz = static_cast<double>(k) * bin_hz;
            const double weight = 0.5 + 0.5 * std::cos(std::numbers::pi * frequency_hz / 1500);
            const std::complex<double> cross = std::complex<double>(spectra[0][k]) *
                                               std::conj(std::complex<double>(spectra[1][k]));
            // cross has the phase 2 pi f ITD.
            sum +=
                weight *
                (cross * std::polar(1.0, -2 * std::numbers::pi * frequency_hz * (lag_s - delay_s)))
                    .real();
        }
        if (sum > best) {
            best = sum;
            best_s = lag_s;
        }
    }
    return best_s;
}

/// A unit vector; degrees.
inline Direction direction_at(double azimuth_deg, double elevation_deg) {
    const double a = azimuth_deg * std::numbers::pi / 180;
    const double e = elevation_deg * std::numbers::pi / 180;
    return {static_cast<float>(std::cos(a) * std::cos(e)),
            static_cast<float>(std::sin(a) * std::cos(e)), static_cast<float>(std::sin(e))};
}

/// Rings of equal elevation from the lowest to the highest, a single direction at a pole.
inline std::vector<Direction> ring_directions(int lowest_deg, int highest_deg, int step_deg,
                                              int azimuths) {
    std::vector<Direction> directions;
    for (int e = lowest_deg; e <= highest_deg; e += step_deg) {
        const int count = e == -90 || e == 90 ? 1 : azimuths;
        for (int i = 0; i < count; ++i) directions.push_back(direction_at(360.0 * i / count, e));
    }
    return directions;
}

}  // namespace aula::test
