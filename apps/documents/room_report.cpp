#include "apps/documents/room_report.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

#include "apps/documents/parameter_text.h"
#include "apps/documents/position_average.h"
#include "apps/documents/report_plots.h"
#include "apps/documents/report_sections.h"
#include "apps/documents/svg_plot.h"
#include "apps/session/base/formatted.h"
#include "apps/session/base/json_text.h"
#include "apps/session/edit/scene_state.h"
#include "apps/session/offline/measurement_text.h"
#include "aula/engine/material_library.h"

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
h2, h3 { break-after: avoid; }
@media print { body { margin: 0; max-width: none; padding: 0; font-size: 11px; }
  th, td { padding: 2px 5px; } .wide th, .wide td { padding: 2px 3px; font-size: 9px; }
  small { font-size: 8px; } .plots svg { width: 330px; height: auto; } }
</style>
)";

std::string number_or_dash(const std::optional<double>& value, int decimals) {
    return value ? fixed_text(*value, decimals) : "-";
}

/// Decimals of a value: as many as its standard error has until its first digit, at most `most`.
int certain_decimals(const MeasuredValue& value, int most) {
    const double error = value.standard_error.value_or(0);
    if (!(error > 0)) return most;
    return std::clamp(static_cast<int>(std::ceil(-std::log10(error))), 0, most);
}

/// A cell with a value and, below it, its standard error; the digits follow the error.
std::string value_cell(const MeasuredValue& value, int most_decimals) {
    const int decimals = certain_decimals(value, most_decimals);
    std::string cell = "<td>" + number_or_dash(value.value, decimals);
    if (value.value && value.standard_error) {
        const bool is_small = *value.standard_error < 0.5 * std::pow(10, -decimals);
        cell += is_small ? "<small>&lt; " + fixed_text(std::pow(10, -decimals), decimals)
                         : "<small>± " + fixed_text(*value.standard_error, decimals);
        cell += "</small>";
    }
    return cell + "</td>";
}

/// A row of a name and a text.
std::string text_row(const std::string& name, const std::string& text) {
    return html_row(html_cell(name) + html_cell(text));
}

std::string band_headers() {
    std::string cells;
    for (std::size_t band = 0; band < kBandCount; ++band) cells += html_header(band_name(band));
    return cells;
}

/// The Schroeder frequency by the mean T30 of 500 and 1000 Hz; empty if that or the volume is not
/// known.
std::optional<double> schroeder_hz(const RoomReport& report, const PositionAverage& average) {
    const std::optional<double>& t30_s =
        average.mean.broadband[static_cast<std::size_t>(AcousticParameter::t30)].value;
    if (!t30_s || !report.room.volume_m3) return std::nullopt;
    return schroeder_frequency_hz(*t30_s, *report.room.volume_m3);
}

/// The octaves; those below the Schroeder frequency have a star.
std::string marked_band_headers(const std::optional<double>& schroeder_hz) {
    std::string cells;
    for (std::size_t band = 0; band < kBandCount; ++band) {
        const bool is_below = schroeder_hz && double{kBandCentres_hz[band]} < *schroeder_hz;
        cells += html_header(band_name(band) + (is_below ? " *" : ""));
    }
    return cells;
}

std::string band_cells(const Bands& bands, int decimals) {
    std::string cells;
    for (const float value : bands.value)
        cells += html_cell(fixed_text(static_cast<double>(value), decimals));
    return cells;
}

std::string symbol_with_unit(const ParameterText& text) {
    return text.unit.empty() ? text.symbol : text.symbol + " in " + text.unit;
}

std::string coordinates(const Vec3& p) {
    return formatted("%.2f, %.2f, %.2f", double{p.x}, double{p.y}, double{p.z});
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

/// Project, client, author and date.
std::string head(const ReportHead& head) {
    std::string rows;
    const auto add = [&](const char* name, const std::string& text) {
        if (!text.empty()) rows += text_row(name, text);
    };
    add("project", head.project);
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

/// Single numbers of all pairs, their mean and deviation.
std::string summary(const RoomReport& report, const PositionAverage& average) {
    const Measurement& m = report.measurement;
    std::string html = "<h2>Single numbers</h2>\n<table class=\"wide pairs\">\n";
    std::string header = html_header("source") + html_header("receiver");
    for (std::size_t p = 0; p < kDescribedParameterCount; ++p) {
        const ParameterText text = parameter_text(p);
        header += "<th>" + text.symbol + "<small>" + (text.unit.empty() ? "&nbsp;" : text.unit) +
                  "</small><small>" + octaves_of(p) + "</small></th>";
    }
    html += html_row(header);
    for (std::size_t s = 0; s < m.sources.size(); ++s)
        for (std::size_t r = 0; r < m.receivers.size(); ++r) {
            html += single_numbers(html_cell(m.sources[s].name) + html_cell(report.receivers[r]),
                                   m.parameters[m.pair(s, r)]);
        }
    if (average.positions > 1)
        html += single_numbers("<td>mean over positions</td><td></td>", average.mean) +
                single_numbers("<td>standard deviation</td><td></td>", average.deviation);
    return html +
           "</table>\n<p>The single numbers are means of the octaves below their names, in energy "
           "for L_J (ISO 3382-1, annex A; for T20, T30 and C50, which it does not list, as for EDT "
           "and C80). STI: IEC 60268-16:2011, male speech. \"-\": the decay is not sufficient, or "
           "the source is not audible.</p>\n";
}

/// Mean and standard deviation over positions in octaves, and T30 as a picture.
std::string averages(const PositionAverage& average, const std::optional<double>& schroeder_hz) {
    std::string rows;
    for (std::size_t p = 0; p < kAcousticParameterCount; ++p) {
        const ParameterText text = parameter_text(p);
        std::string means = html_cell(symbol_with_unit(text)) + html_cell("mean");
        std::string deviations = html_cell("") + html_cell("deviation");
        const auto add = [&](const MeasuredValue& mean, const MeasuredValue& deviation) {
            means += value_cell(mean, text.decimals);
            deviations += value_cell(deviation, text.decimals);
        };
        for (std::size_t b = 0; b < kBandCount; ++b)
            add(average.mean.octaves[p][b], average.deviation.octaves[p][b]);
        add(average.mean.broadband[p], average.deviation.broadband[p]);
        rows += html_row(means);
        if (average.positions > 1) rows += html_row(deviations);
    }
    std::string html = "<h2>Averages over positions</h2>\n<p>" +
                       formatted(
                           "Mean and standard deviation over %s of a source and a "
                           "receiver (ISO 3382-2); levels are averaged in dB.",
                           counted(average.positions, "pair").c_str());
    html += schroeder_hz
                ? formatted(
                      " Schroeder frequency f<sub>S</sub> = 2000 &radic;(T30/V) = %.0f Hz: in "
                      "octaves below it, marked *, single modes are heard, and geometrical "
                      "acoustics is not valid.",
                      *schroeder_hz)
                : std::string(" The Schroeder frequency is not known, without T30 or volume.");
    html += "</p>\n<table class=\"wide\">\n" +
            html_row(html_header("octave in Hz") + html_header("") +
                     marked_band_headers(schroeder_hz) + html_header("single number")) +
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

/// Yaw and pitch of a source.
std::string orientation(const Pose& pose) {
    constexpr double kDegrees = 180 / std::numbers::pi;
    return formatted("%.0f°, %.0f°", kDegrees * double{pose.yaw_rad},
                     kDegrees * double{pose.pitch_rad});
}

/// Distances of all pairs, a row for each receiver.
std::string distances(const RoomReport& report) {
    const Measurement& m = report.measurement;
    std::string header = html_header("distance in m");
    for (const Source& source : m.sources) header += html_header(source.name);
    std::string rows;
    for (std::size_t r = 0; r < m.receivers.size(); ++r) {
        std::string cells = html_cell(report.receivers[r]);
        for (const Source& source : m.sources)
            cells += html_cell(fixed_text(
                double{glm::distance(source.position_at(0), m.receivers[r].position)}, 2));
        rows += html_row(cells);
    }
    return "<table>\n" + html_row(header) + rows + "</table>\n";
}

std::string positions(const RoomReport& report) {
    const Measurement& m = report.measurement;
    std::vector<PlanPoint> points;
    std::string rows;
    for (const Source& source : m.sources) {
        points.push_back({glm::vec2(source.position_at(0)), source.name, true});
        rows += html_row(html_cell("source") + html_cell(source.name) +
                         html_cell(coordinates(source.position_at(0))) +
                         html_cell(directivity_name(source)) +
                         html_cell(orientation(source.pose_at(0))) +
                         html_cell(formatted("%g", double{source.gain_db})));
    }
    for (std::size_t r = 0; r < m.receivers.size(); ++r) {
        points.push_back({glm::vec2(m.receivers[r].position), report.receivers[r], false});
        rows +=
            html_row(html_cell("receiver " + std::to_string(r)) + html_cell(report.receivers[r]) +
                     html_cell(coordinates(m.receivers[r].position)) + html_cell("") +
                     html_cell("") + html_cell(""));
    }
    return "<h2>Sources and receivers</h2>\n<figure>\n" + plan_svg(report.plan, points) +
           formatted(
               "<figcaption>Plan at the height of %.2f m, the mean of the receivers. Discs: "
               "sources. Crosses: receivers.</figcaption>\n</figure>\n",
               double{report.plan_height_m}) +
           "<table class=\"text\">\n" +
           html_row(html_header("") + html_header("name") + html_header("x, y, z in m") +
                    html_header("directivity") + html_header("yaw, pitch") +
                    html_header("gain in dB")) +
           rows + "</table>\n" + distances(report) +
           "<p>Yaw 0° looks along x, 90° along y. Gains are those of the signals; the "
           "parameters do not depend on them.</p>\n";
}

std::string yes_no(bool value) { return value ? "yes" : "no"; }

std::string conditions(const RoomReport& report) {
    const Measurement& m = report.measurement;
    const Simulation& simulation = m.simulation;
    const Medium& medium = report.scene.medium;
    std::string html = "<h2>Conditions</h2>\n<table class=\"text\">\n";
    html += text_row("program", report.program);
    html += html_row("<td>scene (SHA-256)</td><td class=\"hash\">" + html_text(report.scene_hash) +
                     "</td>");
    html += text_row("estimator", estimator_name(simulation.estimator));
    html += text_row("rays per source and frame", std::to_string(simulation.ray_count()));
    html += text_row("frames", std::to_string(m.frames));
    html += text_row("seed", std::to_string(simulation.seed));
    html += text_row("length of the responses", formatted("%.3g s", m.length_s));
    html += text_row("highest reflection order",
                     simulation.order == 0 ? "no limit" : std::to_string(simulation.order));
    html += text_row("highest order of image sources", std::to_string(simulation.specular_order));
    html += text_row("direct sound, purely specular paths, transmission",
                     yes_no(simulation.direct) + ", " + yes_no(simulation.specular) + ", " +
                         yes_no(simulation.transmission));
    html += text_row("highest diffraction order", std::to_string(simulation.diffraction_order));
    if (m.patch_size_m > 0)
        html += text_row("size of patches", formatted("%.2g m", double{m.patch_size_m}));
    html += text_row("temperature, humidity, pressure",
                     formatted("%g °C, %g %%, %g kPa", double{medium.temperature_c},
                               double{medium.humidity_percent}, double{medium.pressure_kpa}));
    html += text_row("speed of sound", formatted("%.1f m/s", double{medium.speed_of_sound_m_s()}));
    html += text_row("air absorption", medium.air_absorption ? "ISO 9613-1" : "none");
    html +=
        text_row("volume", report.room.volume_m3 ? formatted("%.1f m³", *report.room.volume_m3)
                                                 : std::string("unknown: the room is not closed"));
    html += text_row("surface that sound reaches", formatted("%.1f m²", report.room.surface_m2));
    if (report.room.volume_m3)
        html += text_row("mean free path", formatted("%.2f m", report.room.field.mean_free_path_m));
    html += "</table>\n<table>\n" + html_row(html_header("octave in Hz") + band_headers());
    html +=
        html_row(html_cell("speech at 1 m in dB") + band_cells(report.scene.speech.speech_db, 1));
    html += report.scene.speech.noise_db
                ? html_row(html_cell("noise at the receivers in dB") +
                           band_cells(*report.scene.speech.noise_db, 1))
                : html_row("<td>noise at the receivers</td><td colspan=\"8\">none</td>");
    return html + "</table>\n";
}

/// Where the coefficients of each material come from.
std::string material_sources(const RoomReport& report) {
    const std::vector<LibraryMaterial> library = material_library();
    std::string rows;
    for (const Material& material : report.scene.materials) {
        const auto shipped = std::find_if(
            library.begin(), library.end(),
            [&](const LibraryMaterial& candidate) { return candidate.material == material; });
        const auto said = report.material_sources.find(material.name);
        rows += text_row(material.name, said != report.material_sources.end() ? said->second
                                        : shipped == library.end()
                                            ? "given by the scene"
                                            : "Aula's library. " + shipped->source);
    }
    if (rows.empty()) return {};
    return "<h3>Sources of the coefficients</h3>\n<table class=\"text\">\n" + rows + "</table>\n";
}

/// The materials of layers of mesh files, and what was guessed.
std::string layers(const RoomReport& report) {
    std::string html;
    if (!report.layers.empty()) {
        html = "<h3>Layers of the model</h3>\n<table class=\"text\">\n" +
               html_row(html_header("file") + html_header("layer") + html_header("material"));
        for (const LayerMaterial& layer : report.layers)
            html += html_row(html_cell(layer.file) + html_cell(layer.layer) +
                             html_cell(layer.material));
        html += "</table>\n";
    }
    if (report.guesses.empty()) return html;
    html += "<p>The model does not say, and was guessed:</p>\n<ul>\n";
    for (const std::string& guess : report.guesses) html += "<li>" + html_text(guess) + "</li>\n";
    return html + "</ul>\n";
}

std::string materials(const RoomReport& report) {
    std::string html = "<h2>Materials</h2>\n<table>\n" +
                       html_row(html_header("material") + html_header("area in m²") +
                                html_header("coefficient") + band_headers());
    for (std::size_t i = 0; i < report.scene.materials.size(); ++i) {
        const Material& material = report.scene.materials[i];
        const double area_m2 = i < report.room.area_m2.size() ? report.room.area_m2[i] : 0;
        html += html_row(html_cell(material.name) + html_cell(fixed_text(area_m2, 1)) +
                         html_cell("absorption") + band_cells(material.absorption, 2));
        html += html_row(html_cell("") + html_cell("") + html_cell("scattering") +
                         band_cells(material.scattering, 2));
        if (material.sound_reduction_db)
            html += html_row(html_cell("") + html_cell("") + html_cell("sound reduction in dB") +
                             band_cells(*material.sound_reduction_db, 1));
    }
    if (report.room.volume_m3)
        html += html_row(
            html_cell("mean of the room") + html_cell(fixed_text(report.room.surface_m2, 1)) +
            html_cell("absorption") + band_cells(report.room.field.mean_absorption, 2));
    return html + "</table>\n<p>Areas are of the surfaces that sound reaches.</p>\n" +
           material_sources(report) + layers(report);
}

/// The octaves of a pair with its curves.
std::string pair_section(const RoomReport& report, std::size_t s, std::size_t r,
                         const std::optional<double>& schroeder_hz) {
    const Measurement& m = report.measurement;
    const std::size_t pair = m.pair(s, r);
    std::string html =
        "<h3>" + html_text(m.sources[s].name) + " at " + html_text(report.receivers[r]) + "</h3>\n";
    if (!m.audible[pair]) return html + "<p>The source is not audible at this receiver.</p>\n";
    html += "<table>\n" + html_row(html_header("octave in Hz") + marked_band_headers(schroeder_hz) +
                                   html_header("single number"));
    for (std::size_t p = 0; p < kAcousticParameterCount; ++p) {
        const ParameterText text = parameter_text(p);
        std::string cells = html_cell(symbol_with_unit(text));
        for (const MeasuredValue& value : m.parameters[pair].octaves[p])
            cells += value_cell(value, text.decimals);
        html += html_row(cells + value_cell(m.parameters[pair].broadband[p], text.decimals));
    }
    html += html_row("<td>STI</td><td colspan=\"8\"></td>" + value_cell(m.parameters[pair].sti, 2));
    return "<section>\n" + html + "</table>\n<div class=\"plots\">\n<figure>\n" +
           decay_svg(m.responses[pair]) +
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
    return errors;
}

}  // namespace

std::string report_html(const RoomReport& report) {
    const std::string title = html_text(report.title);
    std::string html = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
    html +=
        "<meta name=\"viewport\" content=\"width=device-width\">\n<title>Room acoustics: " + title +
        "</title>\n" + kStyle + "</head>\n<body>\n";
    html += "<h1>Room acoustics: " + title +
            "</h1>\n<p>Parameters of ISO 3382-1 and IEC 60268-16 by simulation.</p>\n";
    const Measurement& m = report.measurement;
    const PositionAverage average = average_over_positions(audible_parameters(m));
    const std::optional<double> f_s = schroeder_hz(report, average);
    html += head(report.head) + positions(report) + summary(report, average) + uncertainty(report) +
            averages(average, f_s);
    const std::vector<std::string> warnings = warnings_of(m);
    if (!warnings.empty()) {
        html += "<h2>Remarks</h2>\n<ul>\n";
        for (const std::string& warning : warnings) html += "<li>" + html_text(warning) + "</li>\n";
        html += "</ul>\n";
    }
    html += speech_section(report) + measured_section(report);
    html += conditions(report) + materials(report) + "<h2>Octaves</h2>\n";
    for (std::size_t s = 0; s < m.sources.size(); ++s)
        for (std::size_t r = 0; r < m.receivers.size(); ++r)
            html += pair_section(report, s, r, f_s);
    return html +
           "<div class=\"sign\"><div>place, date</div><div>name, signature</div></div>\n"
           "</body>\n</html>\n";
}

std::string room_report_json(const RoomReport& report) {
    const Measurement& m = report.measurement;
    const PositionAverage average = average_over_positions(audible_parameters(m));
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
            parameters_json(average.deviation) + "}}";
    return json + ",\n\"schroeder_frequency_hz\":" + json_value(schroeder_hz(report, average)) +
           "}\n";
}

}  // namespace aula
