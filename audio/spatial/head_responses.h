#pragma once

#include <array>
#include <span>
#include <vector>

#include "audio/spatial/hrtf.h"

namespace aula {

/// Measured head-related impulse responses, separated into minimum phase and delay.
struct HeadResponses {
    double sample_rate_hz = 48000;
    std::vector<std::array<float, 3>> directions;  ///< unit, x front, y left, z up
    std::vector<double> weights;                   ///< quadrature weight of each direction; sum 1
    std::vector<std::array<Hrtf::Ear, 2>> ears;    ///< [direction][left, right]

    /// The weighted mean delay of both ears: the delay at the centre of the head.
    double centre_delay_s() const;
};

/// The quadrature weight of each direction: the share of the sphere nearest to it (its Voronoi
/// cell).
std::vector<double> quadrature_weights(const std::vector<std::array<float, 3>>& directions);

/// Fades out the last quarter of a response with half a raised cosine.
void fade_out(std::span<float> response);

}  // namespace aula
