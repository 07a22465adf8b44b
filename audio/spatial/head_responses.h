#pragma once

#include <array>
#include <span>
#include <vector>

#include "audio/spatial/hrtf.h"

namespace aula {

/// Measured head-related impulse responses, minimum phase and delay apart.
struct HeadResponses {
    double sample_rate_hz = 48000;
    std::vector<std::array<float, 3>> directions;  ///< unit, x front, y left, z up
    std::vector<double> weights;  ///< share of the sphere nearest to each direction; sum 1
    std::vector<std::array<Hrtf::Ear, 2>> ears;

    /// The share-weighted mean delay of both ears: that of the middle of the head.
    double centre_delay_s() const;
};

/// Shares of the sphere that lie nearest to each of the directions.
std::vector<double> sphere_shares(const std::vector<std::array<float, 3>>& directions);

/// Lets the last quarter of a response end in half a cosine instead of a step.
void fade_out(std::span<float> response);

}  // namespace aula
