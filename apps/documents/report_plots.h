#pragma once

#include <string>

#include "aula/engine/energy_response.h"

namespace aula {

/// The decay curves of all octaves (Schroeder's backward integral) as an SVG element.
std::string decay_svg(const EnergyResponse& response);

/// The first 200 ms of an echogram in the octave of 1 kHz as an SVG element: discrete arrivals, and
/// all sound in steps of 1 ms, in dB re the energy of the free field at 10 m.
std::string echogram_svg(const EnergyResponse& response);

}  // namespace aula
