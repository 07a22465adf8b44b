#pragma once

#include <array>
#include <optional>

#include "aula/engine/energy_response.h"

namespace aula {

/// Energies of a band that a figure-of-eight microphone receives. Each is absent without energy.
struct LateralParameters {
    std::optional<double> jlf;    ///< J_LF: early lateral energy fraction, 0..1
    std::optional<double> jlfc;   ///< J_LFC: the same with the cosine of the angle of arrival
    std::optional<double> lj_db;  ///< L_J: late lateral level re the free field at 10 m
};

/// Lateral energies by ISO 3382-1, annex A, [band]. `axis` is the unit vector of the microphone's
/// axis, perpendicular to the direction of the source. J_LF has the lateral energy from 5 to 80 ms
/// after time zero over the energy of the first 80 ms, L_J the lateral energy from 80 ms on.
///
/// Each discrete path counts with the squared cosine of its angle to the axis (J_LFC: with the
/// cosine). A time bin counts with its second moment along the axis, a diffuse one with 1/3. Its
/// mean cosine (J_LFC) is the root of this second moment times the ratio of both for the von
/// Mises-Fisher distribution with the bin's mean direction: 1/2 in a diffuse field.
std::array<LateralParameters, kBandCount> lateral_parameters(const EnergyResponse& response,
                                                             const Vec3& axis);

}  // namespace aula
