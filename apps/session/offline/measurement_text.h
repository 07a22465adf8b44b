#pragma once

#include <string>
#include <vector>

#include "aula/engine/room_acoustics.h"
#include "aula/engine/scene.h"
#include "aula/measurement.h"

namespace aula {

/// The energy responses as CSV with the header "source,time_s,63,...,8000": source by source, a row
/// for each `bin_s` from 0 to the responses' length, energy in 1/m2.
std::string echogram_csv(const Scene& scene, const Measurement& measurement, double bin_s);

/// ISO 3382 parameters of each source, in the scene's order; empty for a source that is not
/// audible.
std::vector<RoomParameters> room_parameters(const Measurement& measurement);

/// {"sources":[{"name":..,"bands":{"63":{"T20":..,..},..}}]}; null for absent values.
std::string report_json(const Scene& scene, const std::vector<RoomParameters>& parameters);

/// The same as a table for display; "-" for absent values.
std::string report_table(const Scene& scene, const std::vector<RoomParameters>& parameters);

}  // namespace aula
