#include "audio/dsp/fade.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aula {

// w[n] = (1 - cos(pi (n + 1/2) / N)) / 2: symmetric, so that w[n] + w[N - 1 - n] = 1.
std::vector<float> raised_cosine(std::size_t samples) {
    std::vector<float> weights(samples);
    for (std::size_t n = 0; n < samples; ++n) {
        weights[n] = static_cast<float>(
            0.5 - 0.5 * std::cos(std::numbers::pi * (static_cast<double>(n) + 0.5) /
                                 static_cast<double>(samples)));
    }
    return weights;
}

// The slope rises and falls linearly at the ends. Longer corners make a staircase of the line of
// several fades, shorter ones are heard far from a tone.
std::vector<float> rounded_line(std::size_t samples) {
    constexpr double kCorner = 0.02;  // of the length
    const auto length = static_cast<double>(samples);
    const double corner = kCorner * length;
    // Up to the middle: a parabola, then a line.
    const auto rise = [&](double t) {
        return t < corner ? 0.5 * t * t / corner : t - 0.5 * corner;
    };
    std::vector<float> weights(samples);
    for (std::size_t n = 0; n < samples; ++n) {
        const double t = static_cast<double>(n) + 0.5;
        const double part = rise(std::min(t, length - t)) / (length - corner);
        weights[n] = static_cast<float>(2 * t < length ? part : 1 - part);
    }
    return weights;
}

}  // namespace aula
