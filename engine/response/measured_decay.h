#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "engine/response/band_pass.h"
#include "engine/response/decay_curve.h"

namespace aula {

/// Time zero of a measured response by ISO 3382-1: its first sample that is at most 20 dB below the
/// largest one. Requires a sample that is not 0.
std::size_t first_arrival(std::span<const float> response);

/// The decay of one band of a measured response from the sample `zero` on. A response that ends in
/// stationary noise is cut where the decay meets the noise, without the power of the noise, and has
/// the tail that follows from the late slope (Lundeby et al. 1995; ISO 3382-1, 5.3.3; method E of
/// Guski and Vorlaender 2014). Empty if no decay is above the noise. The upper edge of the band is
/// below half of the sample rate.
std::optional<SampledDecay> measured_decay(std::span<const float> response, double sample_rate_hz,
                                           std::size_t zero, const FrequencyBand& band);

}  // namespace aula
