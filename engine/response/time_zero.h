#pragma once

#include "aula/engine/energy_response.h"

namespace aula {

/// Time zero of room acoustic parameters, s after the emission: the first arrival of direct sound,
/// otherwise the first arrival. That is the arrival of a path, or the start of the first bin with
/// energy if no path arrives before its end (scattered sound never arrives before the specular
/// reflection).
double time_zero_s(const EnergyResponse& response);

}  // namespace aula
