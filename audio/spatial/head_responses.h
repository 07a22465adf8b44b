#pragma once

#include <array>
#include <span>
#include <vector>

#include "audio/spatial/direction_set.h"
#include "audio/spatial/hrtf.h"

namespace aula {

/// Measured head-related impulse responses, separated into minimum phase and delay. The directions
/// that close the gaps of the measurement follow the measured ones.
struct HeadResponses {
    double sample_rate_hz = 48000;
    Directions directions;
    std::vector<double> weights;                 ///< quadrature weight of each direction; sum 1
    std::vector<std::array<Hrtf::Ear, 2>> ears;  ///< [direction][left, right]

    /// The weighted mean delay of both ears: the delay at the centre of the head.
    double centre_delay_s() const;
};

/// Fades out the last quarter of a response with half a raised cosine.
void fade_out(std::span<float> response);

}  // namespace aula
