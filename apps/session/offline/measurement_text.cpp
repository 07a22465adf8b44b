#include "apps/session/offline/measurement_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "apps/session/base/formatted.h"
#include "apps/session/base/json_text.h"

namespace aula {

namespace {

/// A parameter's column in reports.
struct Column {
    std::string_view name;
    std::string_view unit;
    int decimals;
    std::optional<double> BandParameters::*value;
};

constexpr std::array<Column, 8> kColumns{{
    {"T20", "s", 2, &BandParameters::t20_s},
    {"T30", "s", 2, &BandParameters::t30_s},
    {"EDT", "s", 2, &BandParameters::edt_s},
    {"C50", "dB", 1, &BandParameters::c50_db},
    {"C80", "dB", 1, &BandParameters::c80_db},
    {"D50", "", 2, &BandParameters::d50},
    {"Ts", "s", 3, &BandParameters::ts_s},
    {"G", "dB", 1, &BandParameters::g_db},
}};

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

std::string band_name(std::size_t band) {
    return std::to_string(std::lround(kBandCentres_hz[band]));
}

/// RFC 4180: quoted if the text contains a separator.
std::string csv_field(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"') quoted += '"';
        quoted += c;
    }
    return quoted + '"';
}

std::string padded(std::string text, std::size_t width) {
    if (text.size() < width) text.insert(0, width - text.size(), ' ');
    return text;
}

}  // namespace

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

std::string report_json(const Scene& scene, const std::vector<RoomParameters>& parameters) {
    std::string json = "{\"sources\":[";
    for (std::size_t s = 0; s < parameters.size(); ++s) {
        json += s ? ",\n" : "\n";
        json += "{\"name\":" + json_string(scene.sources[s].name) + ",\"bands\":{";
        for (std::size_t band = 0; band < kBandCount; ++band) {
            json += band ? ",\n " : "\n ";
            json += '"' + band_name(band) + "\":{";
            for (const Column& column : kColumns) {
                const std::optional<double> value = parameters[s][band].*column.value;
                if (&column != &kColumns.front()) json += ',';
                json += '"' + std::string(column.name) + "\":";
                json += value ? general(*value, 6) : "null";
            }
            json += '}';
        }
        json += "}}";
    }
    return json + "]}\n";
}

std::string report_table(const Scene& scene, const std::vector<RoomParameters>& parameters) {
    constexpr std::size_t kLabelWidth = 8;
    constexpr std::size_t kWidth = 8;
    std::string table;
    for (std::size_t s = 0; s < parameters.size(); ++s) {
        if (s) table += '\n';
        table += "source " + scene.sources[s].name + '\n' + padded("Hz", kLabelWidth);
        for (std::size_t band = 0; band < kBandCount; ++band)
            table += padded(band_name(band), kWidth);
        table += '\n';
        for (const Column& column : kColumns) {
            std::string label(column.name);
            if (!column.unit.empty()) label += ' ' + std::string(column.unit);
            table += padded(label, kLabelWidth);
            for (const BandParameters& band : parameters[s]) {
                const std::optional<double> value = band.*column.value;
                table += padded(value ? fixed_text(*value, column.decimals) : "-", kWidth);
            }
            table += '\n';
        }
    }
    return table;
}

}  // namespace aula
