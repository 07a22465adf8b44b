#include "apps/session/offline/measurement_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "apps/session/base/csv_text.h"
#include "apps/session/base/formatted.h"
#include "apps/session/base/json_text.h"
#include "apps/session/base/printable.h"

namespace aula {

namespace {

/// [parameter] Decimals in tables.
constexpr std::array<int, kAcousticParameterCount> kDecimals{2, 2, 2, 1, 1, 2, 3, 1, 2, 2, 1, 2, 2};

AcousticParameter parameter(std::size_t index) { return static_cast<AcousticParameter>(index); }

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

std::string padded(std::string text, std::size_t width) {
    if (text.size() < width) text.insert(0, width - text.size(), ' ');
    return text;
}

/// Either the value or the standard error of a measured value.
using Part = std::optional<double> MeasuredValue::*;

std::string json_number(const std::optional<double>& value) {
    return value ? general(*value, 6) : "null";
}

/// {"T20":..,..} of the value that `of` gives for each parameter.
template <typename Of>
std::string json_parameters(const Of& of) {
    std::string json = "{";
    for (std::size_t p = 0; p < kAcousticParameterCount; ++p) {
        if (p) json += ',';
        json +=
            '"' + std::string(acoustic_parameter_name(parameter(p))) + "\":" + json_number(of(p));
    }
    return json + '}';
}

/// The members "bands", "broadband" and "STI"; each line begins with `line`.
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
    return json + ",\"STI\":" + json_number(parameters.sti.*part);
}

/// True if errors of the energy response are known. Those of IACC always are.
bool has_errors(const PairParameters& parameters) {
    for (std::size_t band = 0; band < kBandCount; ++band)
        if (parameters.octave(AcousticParameter::d50, band).standard_error) return true;
    return false;
}

}  // namespace

std::string band_name(std::size_t band) {
    return std::to_string(std::lround(kBandCentres_hz[band]));
}

int parameter_decimals(AcousticParameter parameter) {
    return kDecimals[static_cast<std::size_t>(parameter)];
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
                json_members(parameters, &MeasuredValue::value, "\n ");
        if (has_errors(parameters))
            json += ",\n \"standard_errors\":{" +
                    json_members(parameters, &MeasuredValue::standard_error, "\n  ") + '}';
        json += '}';
    }
    return json + "]}\n";
}

std::string report_table(const Measurement& measurement) {
    constexpr std::size_t kLabelWidth = 8;
    constexpr std::size_t kWidth = 8;
    const auto cell = [](const MeasuredValue& value, int decimals) {
        return padded(value.value ? fixed_text(*value.value, decimals) : "-", kWidth);
    };
    std::string table;
    for (std::size_t s = 0; s < measurement.sources.size(); ++s) {
        const PairParameters& parameters = measurement.parameters[measurement.pair(s, 0)];
        if (s) table += '\n';
        table += "source " + printable_line(measurement.sources[s].name) + '\n' +
                 padded("Hz", kLabelWidth);
        for (std::size_t band = 0; band < kBandCount; ++band)
            table += padded(band_name(band), kWidth);
        table += padded("mean", kWidth) + '\n';
        for (std::size_t p = 0; p < kAcousticParameterCount; ++p) {
            std::string label(acoustic_parameter_name(parameter(p)));
            const std::string_view unit = acoustic_parameter_unit(parameter(p));
            if (!unit.empty()) label += ' ' + std::string(unit);
            table += padded(label, kLabelWidth);
            for (const MeasuredValue& value : parameters.octaves[p])
                table += cell(value, kDecimals[p]);
            table += cell(parameters.broadband[p], kDecimals[p]) + '\n';
        }
        table += padded("STI", kLabelWidth) + cell(parameters.sti, 2) + '\n';
    }
    return table;
}

}  // namespace aula
