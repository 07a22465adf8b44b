#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "aula/engine/room_acoustics.h"
#include "aula/engine/scene.h"
#include "aula/measurement.h"

namespace aula {

/// The nominal centre of an octave band in Hz: "63" to "8000".
std::string band_name(std::size_t band);

/// The parameter with an index in the order of AcousticParameter.
inline AcousticParameter acoustic_parameter(std::size_t index) {
    return static_cast<AcousticParameter>(index);
}

/// Decimals of a parameter in tables.
int parameter_decimals(AcousticParameter parameter);

/// Name and unit of a parameter, such as "T30 s".
std::string parameter_label(AcousticParameter parameter);

/// A text or a number, or "-", right-aligned in 8 columns.
std::string table_cell(const std::string& text);
std::string table_cell(const std::optional<double>& value, int decimals);

/// The first `count` parameters in octaves and their single numbers, for display; one line each,
/// below a line of names.
std::string octave_table(const PairParameters& parameters, std::size_t count);

/// Two standard errors of a speech transmission index, or half of its second decimal.
double speech_margin(const MeasuredValue& index);

/// Class and rating of a speech transmission index, "class E to D, fair"; two names where a limit
/// is within its margin. Requires a value.
std::string speech_names(const MeasuredValue& index);

/// A number as JSON with 6 digits, independent of the locale; null if it is absent.
std::string json_value(const std::optional<double>& value);

/// "bands":{"63":{"T20":..,..},..},"broadband":{..},"STI":.. without errors, and
/// "third_octaves":{"50":{"T20":..,..},..} unless they are omitted; null for absent values.
std::string parameters_json(const PairParameters& parameters);

/// The energy responses as CSV with the header "source,time_s,63,...,8000": source by source, a row
/// for each `bin_s` from 0 to the responses' length, energy in 1/m2.
std::string echogram_csv(const Scene& scene, const Measurement& measurement, double bin_s);

/// ISO 3382 parameters of each source, in the scene's order; empty for a source that is not
/// audible.
std::vector<RoomParameters> room_parameters(const Measurement& measurement);

/// {"sources":[{"name":.., members of parameters_json(), "standard_errors":{the same}}]} of the
/// first receiver; null for absent values, without "standard_errors" if they are unknown; with
/// "waves_below_hz" if modes are part of the responses. Requires Measurement::parameters.
std::string report_json(const Measurement& measurement);

/// The same as a table for display, without standard errors; "-" for absent values.
std::string report_table(const Measurement& measurement);

}  // namespace aula
