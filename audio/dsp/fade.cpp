#include "audio/dsp/fade.h"

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

}  // namespace aula
