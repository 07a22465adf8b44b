#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "aula/measurement.h"

namespace aula {

/// Interaural cross-correlation coefficients of a band; each is absent without energy in both ears.
struct InterauralParameters {
    std::optional<double> early;  ///< IACC of the first 80 ms, 0..1
    std::optional<double> late;   ///< IACC from 80 ms on, 0..1
};

/// Interaural cross-correlation coefficients by ISO 3382-1, annex B: the largest magnitude of the
/// normalised cross-correlation of both ears over delays up to 1 ms. The octaves of a correlation
/// are those of an octave bank. Immutable. [several threads]
class InterauralAnalysis {
 public:
    explicit InterauralAnalysis(double sample_rate_hz);

    /// The coefficients of a binaural impulse response, [band]. `zero_s` is the arrival of the
    /// direct sound. Both ears have the same length.
    std::array<InterauralParameters, kBandCount> parameters(std::span<const float> left,
                                                            std::span<const float> right,
                                                            double zero_s) const;

 private:
    using Coefficients = std::array<std::optional<double>, kBandCount>;

    Coefficients coefficients(std::span<const float> left, std::span<const float> right) const;

    double sample_rate_hz_;
    std::size_t filter_samples_;    ///< length of the octave filters
    std::size_t delay_samples_;     ///< the longest delay
    std::size_t correlation_size_;  ///< of the transforms of filtered correlations
    std::array<std::vector<float>, kBandCount> power_;  ///< [band][bin] of the octave filters
};

/// Computation time of the interaural coefficients of pairs with responses of `length_s`, in s, as
/// counted from that; see counted_s().
double interaural_work_s(std::size_t pairs, double length_s);

/// Adds the interaural coefficients of all audible pairs to the parameters of a measurement. The
/// head, MIT KEMAR, is at the receiver and faces the source in the horizontal plane. Values are
/// means over several noises of the reverberation, whose spread gives the standard errors.
/// Responses end where less than a thousandth of the late energy of each octave remains. `progress`
/// may be empty; it receives the completed share of this computation. Returns false if it requested
/// a stop. Throws InputError if the HRTF cannot be read.
bool add_interaural_parameters(Measurement& measurement,
                               const std::function<bool(double done)>& progress);

}  // namespace aula
