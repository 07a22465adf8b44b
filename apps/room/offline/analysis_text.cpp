#include "apps/room/offline/analysis_text.h"

#include <array>

#include "apps/output/formatted.h"
#include "apps/output/json_text.h"
#include "apps/output/printable.h"
#include "apps/room/offline/measurement_text.h"
#include "aula/engine/third_octaves.h"

namespace aula {

namespace {

using Member = std::optional<double> BandParameters::*;

/// [parameter] as AcousticParameter.
constexpr std::array<Member, kAnalysedParameterCount> kMembers{
    &BandParameters::t20_s,  &BandParameters::t30_s,  &BandParameters::edt_s,
    &BandParameters::c50_db, &BandParameters::c80_db, &BandParameters::d50,
    &BandParameters::ts_s};

std::string quoted_or_null(const std::optional<double>& sti,
                           std::string_view (*text)(double index)) {
    return sti ? json_string(std::string(text(*sti))) : "null";
}

std::string third_octave_table(const ResponseAnalysis& analysis) {
    std::string table = table_cell("Hz");
    for (std::size_t p = 0; p < kAnalysedParameterCount; ++p)
        table += table_cell(parameter_label(acoustic_parameter(p)));
    table += table_cell("range dB") + '\n';
    for (std::size_t t = 0; t < analysis.third_octaves.size(); ++t) {
        const AnalysedBand& band = analysis.third_octaves[t];
        table += table_cell(third_octave_name(t));
        for (std::size_t p = 0; p < kAnalysedParameterCount; ++p)
            table += table_cell(analysed_value(band, p), parameter_decimals(acoustic_parameter(p)));
        table += table_cell(band.range_db, 0) + '\n';
    }
    return table;
}

std::string third_octaves_json(const ResponseAnalysis& analysis) {
    std::string json;
    for (std::size_t t = 0; t < analysis.third_octaves.size(); ++t) {
        const AnalysedBand& band = analysis.third_octaves[t];
        json += t ? ",\n  " : "\n  ";
        json += json_string(third_octave_name(t)) + ":{";
        for (std::size_t p = 0; p < kAnalysedParameterCount; ++p)
            json += json_string(std::string(acoustic_parameter_name(acoustic_parameter(p)))) + ':' +
                    json_value(analysed_value(band, p)) + ',';
        json += "\"range_db\":" + json_value(band.range_db) + '}';
    }
    return "{" + json + "}";
}

}  // namespace

std::optional<double> analysed_value(const AnalysedBand& band, std::size_t parameter) {
    return band.parameters.*kMembers[parameter];
}

std::string analysis_table(const ResponseAnalysis& analysis) {
    std::string table = printable_line(analysis.name) +
                        formatted(": %.0f Hz, %.2f s, time zero %.4f s\n", analysis.sample_rate_hz,
                                  analysis.length_s, analysis.zero_s);
    table += octave_table(analysis.parameters, kAnalysedParameterCount) + table_cell("range dB");
    for (const auto& range_db : analysis.range_db) table += table_cell(range_db, 0);
    const std::optional<double>& sti = analysis.parameters.sti.value;
    table += '\n' + table_cell("STI") + table_cell(sti, 2);
    if (sti) {
        table += "  " + speech_names(analysis.parameters.sti);
    }
    table += '\n';
    if (!analysis.third_octaves.empty()) table += '\n' + third_octave_table(analysis);
    return table;
}

std::string analysis_json(std::span<const ResponseAnalysis> analyses) {
    std::string json;
    for (const ResponseAnalysis& analysis : analyses) {
        json += json.empty() ? "\n" : ",\n";
        json += "{\"name\":" + json_string(analysis.name) +
                ",\"sample_rate_hz\":" + json_value(analysis.sample_rate_hz) +
                ",\"length_s\":" + json_value(analysis.length_s) +
                ",\"time_zero_s\":" + json_value(analysis.zero_s) + ",\n " +
                parameters_json(analysis.parameters);
        const std::optional<double>& sti = analysis.parameters.sti.value;
        json += ",\"STI_class\":" + quoted_or_null(sti, speech_class) +
                ",\"STI_rating\":" + quoted_or_null(sti, speech_rating) + ",\n \"range_db\":{";
        for (std::size_t band = 0; band < kBandCount; ++band) {
            if (band) json += ',';
            json += json_string(band_name(band)) + ':' + json_value(analysis.range_db[band]);
        }
        json += '}';
        if (!analysis.third_octaves.empty())
            json += ",\n \"third_octaves\":" + third_octaves_json(analysis);
        json += ",\n \"warnings\":[";
        for (std::size_t i = 0; i < analysis.warnings.size(); ++i) {
            if (i) json += ',';
            json += json_string(analysis.warnings[i]);
        }
        json += "]}";
    }
    return "{\"responses\":[" + json + "]}\n";
}

}  // namespace aula
