#pragma once

#include <cmath>
#include <numbers>
#include <vector>

namespace aula::test {

inline constexpr double kRate_hz = 48000;
inline constexpr double kTone_hz = 1000;

/// One second of a tone with a sin^2 envelope, which keeps its spectrum narrow.
inline std::vector<float> tone() {
    std::vector<float> samples(48000);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double t = static_cast<double>(i) / kRate_hz;
        const double envelope = std::sin(std::numbers::pi * t);
        samples[i] = static_cast<float>(0.1 * envelope * envelope *
                                        std::sin(2 * std::numbers::pi * kTone_hz * t));
    }
    return samples;
}

/// Energy within `distance_hz` of the tone by DFT, for a signal that begins and ends in silence.
inline double energy_near_tone(const std::vector<float>& samples, double distance_hz = 200) {
    const auto n = static_cast<double>(samples.size());
    double energy = 0;
    const auto first = static_cast<int>(std::ceil((kTone_hz - distance_hz) / kRate_hz * n));
    const auto last = static_cast<int>(std::floor((kTone_hz + distance_hz) / kRate_hz * n));
    for (int bin = first; bin <= last; ++bin) {
        // Goertzel algorithm.
        const double w = 2 * std::numbers::pi * bin / n;
        const double twice_cos = 2 * std::cos(w);
        double s1 = 0;
        double s2 = 0;
        for (const float x : samples) {
            const double s = static_cast<double>(x) + twice_cos * s1 - s2;
            s2 = s1;
            s1 = s;
        }
        energy += 2 / n * (s1 * s1 + s2 * s2 - twice_cos * s1 * s2);
    }
    return energy;
}

/// Share of the energy that lies beyond `distance_hz` of the tone, 0..1.
inline double share_off_tone(const std::vector<float>& samples, double distance_hz = 200) {
    double total = 0;
    for (const float x : samples) total += static_cast<double>(x) * static_cast<double>(x);
    return (total - energy_near_tone(samples, distance_hz)) / total;
}

}  // namespace aula::test
