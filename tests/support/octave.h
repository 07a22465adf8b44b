#pragma once

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace aula::test {

/// Filters a signal to the octave around a centre frequency: two cascaded band-pass biquads, each
/// -3 dB at the octave's edges.
inline std::vector<double> octave(const std::vector<float>& samples, double centre_hz,
                                  double sample_rate_hz) {
    const double w = 2 * std::numbers::pi * centre_hz / sample_rate_hz;
    const double alpha = std::sin(w) / (2 * std::numbers::sqrt2);
    std::vector<double> out(samples.begin(), samples.end());
    for (int stage = 0; stage < 2; ++stage) {
        double x1 = 0;
        double x2 = 0;
        double y1 = 0;
        double y2 = 0;
        for (double& x : out) {
            const double y =
                (alpha * (x - x2) + 2 * std::cos(w) * y1 - (1 - alpha) * y2) / (1 + alpha);
            x2 = std::exchange(x1, x);
            y2 = std::exchange(y1, y);
            x = y;
        }
    }
    return out;
}

}  // namespace aula::test
