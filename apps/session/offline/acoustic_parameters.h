#pragma once

#include <array>
#include <optional>

#include "apps/session/offline/measurement_error.h"
#include "aula/engine/room_acoustics.h"
#include "aula/measurement.h"

namespace aula {

/// The acoustic parameters of a response: [parameter * kBandCount + band].
MeasuredValues acoustic_parameters(const EnergyResponse& response);

/// The parameters of the mean of windows, with their standard errors if there are several windows.
PairParameters acoustic_parameters(const WindowedMean& mean);

}  // namespace aula
