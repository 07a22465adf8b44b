#include "audio/spatial/head_responses.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "audio/dsp/fade.h"

namespace aula {

double HeadResponses::centre_delay_s() const {
    double sum = 0;
    for (std::size_t i = 0; i < ears.size(); ++i) {
        sum += weights[i] * 0.5 * (ears[i][0].delay_s + ears[i][1].delay_s);
    }
    return sum;
}

std::vector<double> quadrature_weights(const std::vector<std::array<float, 3>>& directions) {
    // Each point of a Fibonacci lattice, which covers the sphere evenly, counts for its nearest
    // direction. The mirrored lattice is added so that weights of symmetric directions are equal.
    constexpr std::size_t kPoints = 10000;
    std::vector<double> weights(directions.size());
    for (std::size_t p = 0; p < kPoints; ++p) {
        const double z = 1 - (2 * static_cast<double>(p) + 1) / static_cast<double>(kPoints);
        const double azimuth = std::numbers::pi * (3 - std::sqrt(5.0)) * static_cast<double>(p);
        const double radius = std::sqrt(1 - z * z);
        for (const double side : {1.0, -1.0}) {
            const std::array<float, 3> point{static_cast<float>(radius * std::cos(azimuth)),
                                             static_cast<float>(side * radius * std::sin(azimuth)),
                                             static_cast<float>(z)};
            std::size_t nearest = 0;
            float best = -2;
            for (std::size_t i = 0; i < directions.size(); ++i) {
                const auto& d = directions[i];
                const float cosine = d[0] * point[0] + d[1] * point[1] + d[2] * point[2];
                if (cosine > best) {
                    best = cosine;
                    nearest = i;
                }
            }
            weights[nearest] += 0.5 / static_cast<double>(kPoints);
        }
    }
    return weights;
}

void fade_out(std::span<float> response) {
    Fade fade(response.size() / 4);
    fade.start();
    fade.fade_out(response.last(response.size() / 4));
}

}  // namespace aula
