#include "apps/documents/report/room_report.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "apps/documents/document_measurement.h"
#include "apps/documents/parameter_text.h"
#include "apps/documents/position_average.h"
#include "apps/documents/report/report_cells.h"
#include "apps/documents/report/report_plots.h"
#include "apps/documents/report/report_sections.h"
#include "apps/output/formatted.h"
#include "apps/output/json_text.h"
#include "apps/room/offline/measurement_text.h"

namespace aula {

namespace {

constexpr const char* kStyle = R"(<style>
@page { size: A4; margin: 15mm; }
body { font: 13px/1.4 "DejaVu Sans", Helvetica, Arial, sans-serif; color: #222; max-width: 980px;
  margin: 24px auto; padding: 0 16px; }
h1 { font-size: 24px; margin: 0 0 4px; } h2 { font-size: 18px; margin: 28px 0 8px; }
h3 { font-size: 15px; margin: 24px 0 8px; }
table { border-collapse: collapse; margin: 8px 0; }
th, td { border-bottom: 1px solid #ccc; padding: 3px 8px; text-align: right; vertical-align: top; }
th:first-child, td:first-child, .text td, .text th { text-align: left; }
th { border-bottom: 2px solid #888; white-space: nowrap; } td { white-space: nowrap; }
td:first-child, .text td { overflow-wrap: anywhere; white-space: normal; }
.text td:first-child { min-width: 9em; }
.pairs td:nth-child(2), .pairs th:nth-child(2) { text-align: left; }
.wide th, .wide td { padding: 3px 5px; font-size: 12px; }
small { display: block; color: #666; font-size: 11px; white-space: nowrap; }
.hash { font-family: monospace; overflow-wrap: anywhere; }
.plots { display: flex; flex-wrap: wrap; gap: 8px; }
svg text { fill: #222; font-family: "DejaVu Sans", Helvetica, Arial, sans-serif; }
figure { margin: 0; } figcaption { color: #444; }
.sign { display: flex; gap: 40px; margin-top: 48px; }
.sign div { flex: 1; border-top: 1px solid #222; padding-top: 4px; }
section, figure, tr { break-inside: avoid; }
h2, h3, thead { break-after: avoid; }
@media print { body { margin: 0; max-width: none; padding: 0; font-size: 11px; }
  th, td { padding: 2px 5px; } .wide th, .wide td { padding: 2px 3px; font-size: 9px; }
  small { font-size: 8px; } .plots svg { width: 330px; height: auto; } }
</style>
)";

/// The Schroeder frequency by the mean T30 of 500 and 1000 Hz; empty if that or the volume is not
/// known.
std::optional<double> schroeder_hz(const RoomReport& report, const PositionAverage& average) {
    const std::optional<double>& t30_s =
        average.mean.broadband[static_cast<std::size_t>(AcousticParameter::t30)].value;
    if (!t30_s || !report.room.volume_m3) return std::nullopt;
    return schroeder_frequency_hz(*t30_s, *report.room.volume_m3);
}

std::string symbol_with_unit(const ParameterText& text) {
    return text.unit.empty() ? text.symbol : text.symbol + " in " + text.unit;
}

/// The octaves of a single number, for a head line.
const char* octaves_of(std::size_t parameter) {
    using enum AcousticParameter;
    if (parameter == kSpeechTransmission) return "male";
    switch (static_cast<AcousticParameter>(parameter)) {
        case jlf:
        case jlfc:
        case lj:
            return "125-1k";
        case iacc_early:
        case iacc_late:
            return "500-2k";
        default:
            return "500, 1k";
    }
}

/// Client, author and date.
std::string head(const ReportHead& head) {
    std::string rows;
    const auto add = [&](const char* name, const std::string& text) {
        if (!text.empty()) rows += text_row(name, text);
    };
    add("client", head.client);
    add("author", head.author);
    add("date", head.date);
    return rows.empty() ? "" : "<table class=\"text\">\n" + rows + "</table>\n";
}

/// A row of single numbers after the cells `names`.
std::string single_numbers(const std::string& names, const PairParameters& parameters) {
    std::string cells = names;
    for (std::size_t p = 0; p < kDescribedParameterCount; ++p)
        cells += value_cell(single_number(parameters, p), parameter_text(p).decimals);
    return html_row(cells);
}

/// The average over the receivers of one source.
PositionAverage average_of_source(const RoomReport& report, std::size_t source) {
    const Measurement& m = report.measurement;
    std::vector<char> of_source(m.parameters.size(), 0);
    for (std::size_t r = 0; r < m.receivers.size(); ++r)
        of_source[m.pair(source, r)] = report.in_room[m.pair(source, r)];
    return average_over_positions(audible_parameters(m, of_source));
}

/// The averages with each of kScatteringFactors, over the same positions.
std::vector<PositionAverage> averages_with_scattering(const RoomReport& report) {
    std::vector<PositionAverage> averages;
    for (const Measurement& measurement : report.scattering)
        averages.push_back(average_over_positions(audible_parameters(measurement, report.in_room)));
    return averages;
}

/// The mean T30 with other scattering.
std::string scattering_sentence(const RoomReport& report, const PositionAverage& average) {
    const auto t30_s = [](const PositionAverage& of) {
        return of.mean.broadband[static_cast<std::size_t>(AcousticParameter::t30)].value;
    };
    std::string other;
    const std::vector<PositionAverage> averages = averages_with_scattering(report);
    for (std::size_t i = 0; i < averages.size(); ++i)
        if (const std::optional<double> other_s = t30_s(averages[i]))
            other += (other.empty() ? "" : ", ") +
                     formatted(
                         "%.2f s if all surfaces scatter %s", *other_s,
                         kScatteringFactors[i] < 1 ? "half as much" : "twice as much, at most all");
    const std::optional<double> mean_s = t30_s(average);
    if (!mean_s || other.empty()) return {};
    return formatted("<p>The mean T30 is %.2f s; it is ", *mean_s) + other +
           ". Scattering coefficients are estimates unless the sources of the materials say "
           "otherwise; furnished walls scatter 0.3 and more.</p>\n";
}

/// Single numbers of all pairs, their means and deviation.
std::string summary(const RoomReport& report, const PositionAverage& average) {
    const Measurement& m = report.measurement;
    std::string html = "<h2>Single numbers</h2>\n<table class=\"wide pairs\">\n";
    std::string header = html_header("source") + html_header("receiver");
    for (std::size_t p = 0; p < kDescribedParameterCount; ++p) {
        const ParameterText text = parameter_text(p);
        header += "<th>" + text.symbol + "<small>" + (text.unit.empty() ? "&nbsp;" : text.unit) +
                  "</small><small>" + octaves_of(p) + "</small></th>";
    }
    html += head_row(header);
    for (std::size_t s = 0; s < m.sources.size(); ++s)
        for (std::size_t r = 0; r < m.receivers.size(); ++r) {
            html += single_numbers(html_cell(m.sources[s].name) + html_cell(report.receivers[r]),
                                   m.parameters[m.pair(s, r)]);
        }
    const auto mean_row = [](const std::string& names, const PositionAverage& of) {
        std::string cells = names;
        for (std::size_t p = 0; p < kDescribedParameterCount; ++p)
            cells += mean_cell(single_number(of.mean, p), single_number(of.counts, p), of.positions,
                               parameter_text(p).decimals);
        return html_row(cells);
    };
    for (std::size_t s = 0; s < m.sources.size() && m.sources.size() > 1; ++s)
        if (const PositionAverage of = average_of_source(report, s); of.positions > 1)
            html += mean_row(html_cell(m.sources[s].name) + html_cell("mean"), of);
    if (average.positions > 1)
        html += mean_row("<td>mean over positions</td><td></td>", average) +
                single_numbers("<td>standard deviation</td><td></td>", average.deviation);
    html += "</table>\n" + scattering_sentence(report, average);
    std::string directed;
    for (const Source& source : m.sources)
        if (!source.directivity.is_omnidirectional())
            directed += (directed.empty() ? "" : ", ") + html_text(source.name);
    if (!directed.empty())
        html += "<p>ISO 3382-1 presupposes omnidirectional sources. Directed: " + directed +
                "; their G is re an omnidirectional source of the same power.</p>\n";
    return html +
           "<p>Each row is of one source alone. The single numbers are means of the octaves below "
           "their names, in energy "
           "for L_J (ISO 3382-1, annex A; for T20, T30 and C50, which it does not list, as for EDT "
           "and C80). STI: IEC 60268-16:2011, male speech. \"-\": the decay is not sufficient, or "
           "the source is not audible. A mean of fewer pairs has their number below it.</p>\n";
}

/// Sabine's and Eyring's reverberation times in octaves, and their means of 500 and 1000 Hz.
std::string statistical_times(const RoomReport& report) {
    if (!report.room.volume_m3) return {};
    const auto row = [](const char* name, const Bands& times_s) {
        const double middle_s = double{times_s[3] + times_s[4]} / 2;
        return html_row(html_cell(name) + html_cell("estimate") + band_cells(times_s, 2) +
                        number_cell(middle_s, 2));
    };
    const Medium& medium = report.scene.medium;
    return row("Sabine in s", sabine_time_s(report.room.field, medium)) +
           row("Eyring in s", reverberation_time_s(report.room.field, medium));
}

/// T30 with other scattering, mean over the same positions.
std::string times_with_scattering(const RoomReport& report) {
    std::string rows;
    const std::vector<PositionAverage> averages = averages_with_scattering(report);
    for (std::size_t i = 0; i < averages.size(); ++i) {
        const PositionAverage& average = averages[i];
        const auto p = static_cast<std::size_t>(AcousticParameter::t30);
        std::string cells = html_cell("T30 in s") +
                            html_cell(formatted("scattering x %g", double{kScatteringFactors[i]}));
        const auto add = [&](const MeasuredValue& mean, const MeasuredValue& count) {
            cells += mean_cell(mean, count, average.positions, parameter_text(p).decimals);
        };
        for (std::size_t b = 0; b < kBandCount; ++b)
            add(average.mean.octaves[p][b], average.counts.octaves[p][b]);
        add(average.mean.broadband[p], average.counts.broadband[p]);
        rows += html_row(cells);
    }
    return rows;
}

/// A sentence on pairs nearer than the least distance of ISO 3382-2.
std::string near_pairs(const RoomReport& report, double t30_s) {
    const Measurement& m = report.measurement;
    const double least_m =
        2 * std::sqrt(*report.room.volume_m3 /
                      (double{report.scene.medium.speed_of_sound_m_s()} * t30_s));
    std::string pairs;
    for (std::size_t s = 0; s < m.sources.size(); ++s)
        for (std::size_t r = 0; r < m.receivers.size(); ++r)
            if (double{glm::distance(m.sources[s].position_at(0), m.receivers[r].position)} <
                least_m)
                pairs += (pairs.empty() ? "" : ", ") +
                         html_text(m.sources[s].name + " at " + report.receivers[r]);
    if (pairs.empty()) return {};
    return formatted(
               " Nearer than 2 &radic;(V/(c T30)) = %.1f m, the least distance of ISO 3382-2: ",
               least_m) +
           pairs + ".";
}

/// A sentence on a T30 that is far from Eyring's time.
std::string diffuseness(const RoomReport& report, const PositionAverage& average) {
    constexpr double kFar = 1.5;
    const std::optional<double>& t30_s =
        average.mean.broadband[static_cast<std::size_t>(AcousticParameter::t30)].value;
    const Bands eyring_s = reverberation_time_s(report.room.field, report.scene.medium);
    const double times = t30_s.value_or(0) / (double{eyring_s[3] + eyring_s[4]} / 2);
    if (!(std::isfinite(times) && times > kFar)) return {};
    return formatted(
        " The mean T30 of 500 and 1000 Hz is %.1f times Eyring's: the field of this room is not "
        "diffuse, as with absorption on few surfaces.",
        times);
}

/// How octaves below the Schroeder frequency are computed.
std::string bass(double waves_below_hz) {
    const std::string rays =
        "octaves marked * are those of geometrical acoustics, which is not "
        "valid there.";
    return waves_below_hz > 0
               ? formatted(" The values contain the modes of the room below %.0f Hz; ",
                           waves_below_hz) +
                     rays
               : " O" + rays.substr(1);
}

/// Mean and standard deviation over positions in octaves, and T30 as a picture.
std::string averages(const RoomReport& report, const PositionAverage& average,
                     const std::optional<double>& schroeder_hz) {
    std::string rows;
    for (std::size_t p = 0; p < kAcousticParameterCount; ++p) {
        const ParameterText text = parameter_text(p);
        std::string means = html_cell(symbol_with_unit(text)) + html_cell("mean");
        std::string deviations = html_cell("") + html_cell("deviation");
        const auto add = [&](const auto& of) {
            means +=
                mean_cell(of(average.mean), of(average.counts), average.positions, text.decimals);
            deviations += value_cell(of(average.deviation), text.decimals);
        };
        for (std::size_t b = 0; b < kBandCount; ++b)
            add([&](const PairParameters& all) { return all.octaves[p][b]; });
        add([&](const PairParameters& all) { return all.broadband[p]; });
        rows += html_row(means);
        if (average.positions > 1) rows += html_row(deviations);
        if (p == static_cast<std::size_t>(AcousticParameter::t30))
            rows += times_with_scattering(report) + statistical_times(report);
    }
    std::string html = "<h2>Averages over positions</h2>\n<p>" +
                       formatted(
                           "Mean and standard deviation over %s of a source and a "
                           "receiver (ISO 3382-2); levels are averaged in dB.",
                           counted(average.positions, "pair").c_str());
    html += schroeder_hz
                ? formatted(
                      " Schroeder frequency f<sub>S</sub> = 2000 &radic;(T30/V) = %.0f Hz: "
                      "in octaves below it single modes are heard.",
                      *schroeder_hz) +
                      bass(report.measurement.waves_below_hz)
                : std::string(" The Schroeder frequency is not known, without T30 or volume.");
    if (report.room.volume_m3)
        html +=
            " Estimates by Sabine and Eyring are those of a diffuse field, from the volume and the "
            "areas below." +
            diffuseness(report, average);
    if (const std::optional<double>& t30_s =
            average.mean.broadband[static_cast<std::size_t>(AcousticParameter::t30)].value;
        t30_s && report.room.volume_m3)
        html += near_pairs(report, *t30_s);
    html += "</p>\n<table class=\"wide\">\n" +
            head_row(html_header("octave in Hz") + html_header("") +
                     band_headers(schroeder_hz, report.measurement.waves_below_hz) +
                     html_header("single number")) +
            rows + "</table>\n";
    const std::string plot = decay_time_svg(average, schroeder_hz);
    if (plot.empty()) return html;
    return html + "<figure>\n" + plot +
           "<figcaption>T30, mean and standard deviation over positions</figcaption>\n</figure>\n";
}

/// How errors are to be read.
std::string uncertainty(const RoomReport& report) {
    if (report.frames_given)
        return "<p>The number of frames was given, so that the standard errors of the energy "
               "responses are unknown. Those of IACC are of the noise of the reverberation.</p>\n";
    return "<p>± is the standard error of the estimate in the unit of its value (jackknife over "
           "independent windows); values have as many digits. It covers the randomness of the "
           "simulation, not the uncertainty of geometry and coefficients. The error of IACC is "
           "that of the noise of the reverberation only. Means over positions have none: the pairs "
           "of a source share its rays.</p>\n";
}

/// Remarks on positions and on the measurement. Errors are printed with their values, so that the
/// number of pairs with large ones is sufficient.
std::vector<std::string> remarks_of(const RoomReport& report) {
    const Measurement& m = report.measurement;
    std::vector<std::string> remarks = report.remarks;
    remarks.insert(remarks.end(), m.warnings.begin(), m.warnings.end());
    for (std::size_t pair = 0; pair < m.audible.size(); ++pair)
        if (!m.audible[pair]) remarks.push_back(pair_warning(m, pair));
    if (const std::string summary = uncertainty_summary(m); !summary.empty())
        remarks.push_back(summary +
                          formatted(": of level more than %g dB, of C80 %g dB, of T30 %g %%, of "
                                    "EDT %g %%, in an octave from 125 Hz to 4 kHz",
                                    m.limits.level_db, m.limits.c80_db, 100 * m.limits.t30,
                                    100 * m.limits.edt));
    remarks.insert(remarks.end(), m.missing_decays.begin(), m.missing_decays.end());
    return remarks;
}

/// A table of the third octaves of a pair; empty if they are omitted.
std::string third_octaves(const PairParameters& parameters) {
    if (parameters.third_octaves.empty()) return {};
    std::string header = html_header("third octave in Hz");
    for (std::size_t p = 0; p < kThirdOctaveParameterCount; ++p)
        header += html_header(symbol_with_unit(parameter_text(p)));
    std::string rows;
    for (std::size_t third = 0; third < kThirdOctaveCount; ++third) {
        std::string cells = html_cell(third_octave_name(third));
        for (std::size_t p = 0; p < kThirdOctaveParameterCount; ++p)
            cells += value_cell(parameters.third_octaves[p][third], parameter_text(p).decimals);
        rows += html_row(cells);
    }
    return "<table>\n" + head_row(header) + rows +
           "</table>\n<p>Third octaves: the absorption of surfaces is interpolated between "
           "octaves, that of air is exact.</p>\n";
}

/// The octaves of a pair with its curves.
std::string pair_section(const RoomReport& report, std::size_t s, std::size_t r,
                         const std::optional<double>& schroeder_hz) {
    const Measurement& m = report.measurement;
    const std::size_t pair = m.pair(s, r);
    std::string html =
        "<h3>" + html_text(m.sources[s].name) + " at " + html_text(report.receivers[r]) + "</h3>\n";
    if (!m.audible[pair]) return html + "<p>The source is not audible at this receiver.</p>\n";
    html += "<table>\n" + head_row(html_header("octave in Hz") +
                                   band_headers(schroeder_hz, report.measurement.waves_below_hz) +
                                   html_header("single number"));
    for (std::size_t p = 0; p < kAcousticParameterCount; ++p) {
        const ParameterText text = parameter_text(p);
        std::string cells = html_cell(symbol_with_unit(text));
        for (const MeasuredValue& value : m.parameters[pair].octaves[p])
            cells += value_cell(value, text.decimals);
        html += html_row(cells + value_cell(m.parameters[pair].broadband[p], text.decimals));
    }
    html += html_row("<td>STI</td><td colspan=\"8\"></td>" + value_cell(m.parameters[pair].sti, 2));
    return "<section>\n" + html + "</table>\n" + third_octaves(m.parameters[pair]) +
           "<div class=\"plots\">\n<figure>\n" + decay_svg(m.responses[pair]) +
           "<figcaption>Decay curves (backward integration)</figcaption>\n</figure>\n<figure>\n" +
           echogram_svg(m.responses[pair]) +
           "<figcaption>Echogram of the octave of 1 kHz</figcaption>\n</figure>\n</div>\n"
           "</section>\n";
}

/// The standard errors in place of the values.
PairParameters errors_of(const PairParameters& parameters) {
    PairParameters errors;
    for (std::size_t p = 0; p < kAcousticParameterCount; ++p) {
        for (std::size_t b = 0; b < kBandCount; ++b)
            errors.octaves[p][b].value = parameters.octaves[p][b].standard_error;
        errors.broadband[p].value = parameters.broadband[p].standard_error;
    }
    errors.sti.value = parameters.sti.standard_error;
    for (const auto& of_parameter : parameters.third_octaves)
        for (std::size_t t = 0; t < kThirdOctaveCount; ++t) {
            if (t == 0) errors.third_octaves.emplace_back();
            errors.third_octaves.back()[t].value = of_parameter[t].standard_error;
        }
    return errors;
}

}  // namespace

std::string report_html(const RoomReport& report) {
    const std::string title =
        html_text(report.head.project.empty() ? report.scene_name : report.head.project);
    std::string html = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
    html +=
        "<meta name=\"viewport\" content=\"width=device-width\">\n<title>Room acoustics: " + title +
        "</title>\n" + kStyle + "</head>\n<body>\n";
    html += "<h1>Room acoustics: " + title +
            "</h1>\n<p>Parameters of ISO 3382-1 and IEC 60268-16 by simulation.</p>\n";
    const Measurement& m = report.measurement;
    const PositionAverage average = average_over_positions(audible_parameters(m, report.in_room));
    const std::optional<double> f_s = schroeder_hz(report, average);
    html += head(report.head) + positions_section(report) + summary(report, average) +
            uncertainty(report) + averages(report, average, f_s);
    const std::vector<std::string> remarks = remarks_of(report);
    if (!remarks.empty()) {
        html += "<h2>Remarks</h2>\n<ul>\n";
        for (const std::string& remark : remarks) html += "<li>" + html_text(remark) + "</li>\n";
        html += "</ul>\n";
    }
    html += speech_section(report) + measured_section(report);
    html += conditions_section(report) + materials_section(report) + "<h2>Octaves</h2>\n";
    for (std::size_t s = 0; s < m.sources.size(); ++s)
        for (std::size_t r = 0; r < m.receivers.size(); ++r)
            html += pair_section(report, s, r, f_s);
    return html +
           "<div class=\"sign\"><div>place, date</div><div>name, signature</div></div>\n"
           "</body>\n</html>\n";
}

std::string room_report_json(const RoomReport& report) {
    const Measurement& m = report.measurement;
    const PositionAverage average = average_over_positions(audible_parameters(m, report.in_room));
    const auto place = [](const std::string& name, const Vec3& p) {
        return "{\"name\":" + json_string(name) +
               formatted(",\"position\":[%.6g,%.6g,%.6g]}", double{p.x}, double{p.y}, double{p.z});
    };
    const auto list = [](std::size_t count, const auto& item) {
        std::string json = "[";
        for (std::size_t i = 0; i < count; ++i) json += (i ? ",\n " : "\n ") + item(i);
        return json + "]";
    };
    std::string json = "{\"sources\":" + list(m.sources.size(), [&](std::size_t s) {
                           return place(m.sources[s].name, m.sources[s].position_at(0));
                       });
    json += ",\n\"receivers\":" + list(m.receivers.size(), [&](std::size_t r) {
                return place(report.receivers[r], m.receivers[r].position);
            });
    json += ",\n\"pairs\":" + list(m.parameters.size(), [&](std::size_t pair) {
                return "{\"source\":" + json_string(m.sources[pair / m.receivers.size()].name) +
                       ",\"receiver\":" + json_string(report.receivers[pair % m.receivers.size()]) +
                       "," + parameters_json(m.parameters[pair]) + ",\"standard_errors\":{" +
                       parameters_json(errors_of(m.parameters[pair])) + "}}";
            });
    json += ",\n\"positions\":{\"count\":" + std::to_string(average.positions) + ",\n\"mean\":{" +
            parameters_json(average.mean) + "},\n\"standard_deviation\":{" +
            parameters_json(average.deviation) + "},\n\"counts\":{" +
            parameters_json(average.counts) + "}}";
    if (m.waves_below_hz > 0) json += ",\n\"waves_below_hz\":" + json_value(m.waves_below_hz);
    return json + ",\n\"schroeder_frequency_hz\":" + json_value(schroeder_hz(report, average)) +
           "}\n";
}

}  // namespace aula
