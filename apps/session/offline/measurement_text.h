#pragma once

#include <string>
#include <vector>

#include "aula/engine/room_acoustics.h"
#include "aula/engine/scene.h"
#include "aula/measurement.h"

namespace aula {

/// The nominal centre of an octave band in Hz: "63" to "8000".
std::string band_name(std::size_t band);

/// Decimals of a parameter in tables.
int parameter_decimals(AcousticParameter parameter);

/// The energy responses as CSV with the header "source,time_s,63,...,8000": source by source, a row
/// for each `bin_s` from 0 to the responses' length, energy in 1/m2.
std::string echogram_csv(const Scene& scene, const Measurement& measurement, double bin_s);

/// ISO 3382 parameters of each source, in the scene's order; empty for a source that is not
/// audible.
std::vector<RoomParameters> room_parameters(const Measurement& measurement);

/// {"sources":[{"name":..,"bands":{"63":{"T20":..,..},..},"broadband":{..},"STI":..,
/// "standard_errors":{"bands":{..},"broadband":{..},"STI":..}}]} of the first receiver; null for
/// absent values, without "standard_errors" if they are unknown. Requires Measurement::parameters.
std::string report_json(const Measurement& measurement);

/// The same as a table for display, without standard errors; "-" for absent values.
std::string report_table(const Measurement& measurement);

}  // namespace aula
