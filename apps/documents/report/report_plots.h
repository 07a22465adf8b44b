#pragma once

#include <optional>
#include <string>

#include "apps/documents/position_average.h"
#include "aula/engine/energy_response.h"

namespace aula {

/// The decay curves of all octaves (Schroeder's backward integral) as an SVG element.
std::string decay_svg(const EnergyResponse& response);

/// The first 200 ms of an echogram in the octave of 1 kHz as an SVG element: discrete arrivals, and
/// all sound in steps of 1 ms, in dB re the energy of the free field at 10 m.
std::string echogram_svg(const EnergyResponse& response);

/// T30 of the octaves as an SVG element: the mean over positions, with bars of one standard
/// deviation. Octaves below the Schroeder frequency, if that is known, are grey.
std::string decay_time_svg(const PositionAverage& average,
                           const std::optional<double>& schroeder_hz);

}  // namespace aula
