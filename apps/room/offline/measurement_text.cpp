#include "apps/room/offline/measurement_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "apps/output/csv_text.h"
#include "apps/output/formatted.h"
#include "apps/output/json_text.h"
#include "apps/output/printable.h"
#include "engine/response/speech_transmission.h"

namespace aula {

namespace {

/// [parameter] Decimals in tables.
constexpr std::array<int, kAcousticParameterCount> kDecimals{2, 2, 2, 1, 1, 2, 3, 1, 2, 2, 1, 2, 2};

/// A number for JSON and CSV, independent of the locale.
std::string number(double value, std::chars_format format, int precision) {
    std::array<char, 64> text{};
    char* const end =
        std::to_chars(text.data(), text.data() + text.size(), value, format, precision).ptr;
    return {text.data(), end};
}

std::string general(double value, int digits) {
    return number(value, std::chars_format::general, digits);
}

/// Either the value or the standard error of a measured value.
using Part = std::optional<double> MeasuredValue::*;

/// {"T20":..,..} of the value that `of` gives for each of the first `count` parameters.
template <typename Of>
std::string json_parameters(const Of& of, std::size_t count = kAcousticParameterCount) {
    std::string json = "{";
    for (std::size_t p = 0; p < count; ++p) {
        if (p) json += ',';
        json += '"' + std::string(acoustic_parameter_name(acoustic_parameter(p))) +
                "\":" + json_value(of(p));
    }
    return json + '}';
}

/// The members "bands", "broadband", "STI" and "third_octaves"; each line begins with `line`.
std::string json_members(const PairParameters& parameters, Part part, const std::string& line) {
    std::string json = "\"bands\":{";
    for (std::size_t band = 0; band < kBandCount; ++band) {
        json += (band ? "," : "") + line;
        json += '"' + band_name(band) + "\":" + json_parameters([&](std::size_t p) {
                    return parameters.octaves[p][band].*part;
                });
    }
    json += "}," + line + "\"broadband\":" + json_parameters([&](std::size_t p) {
                return parameters.broadband[p].*part;
            });
    json += ",\"STI\":" + json_value(parameters.sti.*part);
    if (parameters.third_octaves.empty()) return json;
    json += "," + line + "\"third_octaves\":{";
    for (std::size_t third = 0; third < kThirdOctaveCount; ++third) {
        json += (third ? "," : "") + line;
        json +=
            '"' + std::string(third_octave_name(third)) + "\":" +
            json_parameters([&](std::size_t p) { return parameters.third_octaves[p][third].*part; },
                            kThirdOctaveParameterCount);
    }
    return json + '}';
}

/// True if errors of the energy response are known. Those of IACC always are.
bool has_errors(const PairParameters& parameters) {
    for (std::size_t band = 0; band < kBandCount; ++band)
        if (parameters.octave(AcousticParameter::d50, band).standard_error) return true;
    return false;
}

/// The parameters in third octaves, one line each; empty if they are omitted.
std::string third_octave_table(const PairParameters& parameters) {
    if (parameters.third_octaves.empty()) return {};
    std::string table = table_cell("Hz");
    for (std::size_t p = 0; p < kThirdOctaveParameterCount; ++p)
        table += table_cell(parameter_label(acoustic_parameter(p)));
    table += '\n';
    for (std::size_t third = 0; third < kThirdOctaveCount; ++third) {
        table += table_cell(third_octave_name(third));
        for (std::size_t p = 0; p < kThirdOctaveParameterCount; ++p)
            table += table_cell(parameters.third_octaves[p][third].value, kDecimals[p]);
        table += '\n';
    }
    return table;
}

}  // namespace

std::string band_name(std::size_t band) {
    return std::to_string(std::lround(kBandCentres_hz[band]));
}

int parameter_decimals(AcousticParameter parameter) {
    return kDecimals[static_cast<std::size_t>(parameter)];
}

std::string parameter_label(AcousticParameter parameter) {
    const std::string unit(acoustic_parameter_unit(parameter));
    return std::string(acoustic_parameter_name(parameter)) + (unit.empty() ? "" : " " + unit);
}

std::string table_cell(const std::string& text) { return formatted("%8s", text.c_str()); }

std::string table_cell(const std::optional<double>& value, int decimals) {
    return table_cell(value ? fixed_text(*value, decimals) : "-");
}

double speech_margin(const MeasuredValue& index) {
    constexpr double kCoverage = 2;  // 95 %
    return std::max(kSpeechIndexRounding, kCoverage * index.standard_error.value_or(0));
}

std::string speech_names(const MeasuredValue& index) {
    const double margin = speech_margin(index);
    return "class " + speech_name(*index.value, margin, speech_class) + ", " +
           speech_name(*index.value, margin, speech_rating);
}

std::string json_value(const std::optional<double>& value) {
    return value ? general(*value, 6) : "null";
}

std::string parameters_json(const PairParameters& parameters) {
    return json_members(parameters, &MeasuredValue::value, "\n ");
}

std::string echogram_csv(const Scene& scene, const Measurement& measurement, double bin_s) {
    std::string csv = "source,time_s";
    for (std::size_t band = 0; band < kBandCount; ++band) csv += ',' + band_name(band);
    csv += '\n';
    // A length that is a whole number of bins except for rounding to single precision gets no
    // further bin.
    const auto rows = static_cast<std::size_t>(std::ceil(measurement.length_s / bin_s - 1e-3));
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        const std::string name = csv_field(scene.sources[s].name);
        const std::vector<Bands> energy = measurement.responses[s].uniform(bin_s);
        for (std::size_t row = 0; row < std::min(rows, energy.size()); ++row) {
            csv += name + ',' + general(static_cast<double>(row) * bin_s, 9);
            for (const float e : energy[row].value) csv += ',' + general(static_cast<double>(e), 9);
            csv += '\n';
        }
    }
    return csv;
}

std::vector<RoomParameters> room_parameters(const Measurement& measurement) {
    std::vector<RoomParameters> parameters;
    for (std::size_t s = 0; s < measurement.responses.size(); ++s)
        parameters.push_back(measurement.audible[s] ? room_parameters(measurement.responses[s])
                                                    : RoomParameters{});
    return parameters;
}

std::string report_json(const Measurement& measurement) {
    std::string json = "{\"sources\":[";
    for (std::size_t s = 0; s < measurement.sources.size(); ++s) {
        const PairParameters& parameters = measurement.parameters[measurement.pair(s, 0)];
        json += s ? ",\n" : "\n";
        json += "{\"name\":" + json_string(measurement.sources[s].name) + ',' +
                parameters_json(parameters);
        if (has_errors(parameters))
            json += ",\n \"standard_errors\":{" +
                    json_members(parameters, &MeasuredValue::standard_error, "\n  ") + '}';
        json += '}';
    }
    json += ']';
    if (measurement.waves_below_hz > 0)
        json += ",\n\"waves_below_hz\":" + json_value(measurement.waves_below_hz);
    return json + "}\n";
}

std::string octave_table(const PairParameters& parameters, std::size_t count) {
    std::string table = table_cell("Hz");
    for (std::size_t band = 0; band < kBandCount; ++band) table += table_cell(band_name(band));
    table += table_cell("mean") + '\n';
    for (std::size_t p = 0; p < count; ++p) {
        table += table_cell(parameter_label(acoustic_parameter(p)));
        for (const MeasuredValue& value : parameters.octaves[p])
            table += table_cell(value.value, kDecimals[p]);
        table += table_cell(parameters.broadband[p].value, kDecimals[p]) + '\n';
    }
    return table;
}

std::string report_table(const Measurement& measurement) {
    std::string table;
    for (std::size_t s = 0; s < measurement.sources.size(); ++s) {
        const PairParameters& parameters = measurement.parameters[measurement.pair(s, 0)];
        if (s) table += '\n';
        table += "source " + printable_line(measurement.sources[s].name) + '\n' +
                 octave_table(parameters, kAcousticParameterCount) + table_cell("STI") +
                 table_cell(parameters.sti.value, 2) +
                 (parameters.sti.value ? "  " + speech_names(parameters.sti) : "") + '\n' +
                 third_octave_table(parameters);
    }
    if (measurement.waves_below_hz > 0)
        table += formatted("\nmodes of the room below %.0f Hz, rays above\n",
                           measurement.waves_below_hz);
    for (const std::string& line : measurement.without_waves)
        table += '\n' + printable_line(line) + '\n';
    return table;
}

}  // namespace aula
