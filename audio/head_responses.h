#pragma once

#include <array>
#include <span>
#include <vector>

#include "audio/hrtf.h"

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

/// Filters [ear][W Y Z X] of `taps` samples that give both ears of a first-order ambisonic field
/// what the responses give them. Least squares at low frequencies; above, where first order cannot
/// follow the delays between the ears, least squares of magnitudes (Schoerkhuber, Zaunschirm and
/// Hoeldrich, "Binaural Rendering of Ambisonic Signals via Magnitude Least Squares", DAGA 2018).
/// Each ear's level in a diffuse field is that of the responses at every frequency. The field's
/// delay is centre_delay_s(), so that it lines up with sound rendered by the responses.
std::array<std::array<std::vector<float>, 4>, 2> design_decoder(const HeadResponses& head,
                                                                std::size_t taps);

/// Lets the last quarter of a response end in half a cosine instead of a step.
void fade_out(std::span<float> response);

}  // namespace aula
