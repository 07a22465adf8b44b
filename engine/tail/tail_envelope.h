#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "aula/engine/energy_response.h"
#include "engine/response/third_octave_model.h"

namespace aula {

/// A piece of the envelope of a reverberant tail, in which the amplitudes are linear.
struct TailSegment {
    using Values = ThirdOctaveModel::Values;

    double begin_s = 0;
    double end_s = 0;
    Values begin{};  ///< pressure per sample over a carrier of unit variance
    Values end{};
    float loudest = 0;            ///< the largest of both; 0: silence
    DirectionMoments directions;  ///< of unit energy, at the start
    DirectionMoments directions_end;

    /// False for a carrier below the error of quantisation of the loudest one, -88 dB.
    bool is_audible(std::size_t carrier) const {
        constexpr float kInaudible = 4e-5F;  // 10^(-88/20)
        return std::max(begin[carrier], end[carrier]) > kInaudible * loudest;
    }
};

/// The envelope of the reverberant tail of an energy response in third octaves: continuous, linear
/// between the edges and the centre of each bin, with the energy of each bin, spread over a period
/// of the centre of its octave.
std::vector<TailSegment> tail_envelope(const EnergyResponse& energy, const ThirdOctaveModel& model,
                                       double sample_rate_hz);

}  // namespace aula
