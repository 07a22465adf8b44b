#include "apps/documents/room_report.h"

#include <algorithm>
#include <cmath>

#include "apps/documents/parameter_text.h"
#include "apps/documents/report_plots.h"
#include "apps/documents/report_sections.h"
#include "apps/documents/svg_plot.h"
#include "apps/session/base/formatted.h"
#include "apps/session/edit/scene_state.h"
#include "apps/session/offline/measurement_text.h"

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

/// A cell with a value and, below it, its standard error.
std::string value_cell(const MeasuredValue& value, int decimals) {
    std::string cell = "<td>" + number_or_dash(value.value, decimals);
    if (value.value && value.standard_error)
        cell += "<small>± " + fixed_text(*value.standard_error, decimals + 2) + "</small>";
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

/// Single numbers of all pairs.
std::string summary(const RoomReport& report) {
    const Measurement& m = report.measurement;
    std::string html = "<h2>Single numbers</h2>\n<table class=\"wide\">\n";
    std::string header = html_header("source") + html_header("receiver");
    for (std::size_t p = 0; p < kDescribedParameterCount; ++p) {
        const ParameterText text = parameter_text(p);
        header += "<th>" + text.symbol + "<small>" + text.unit + "</small></th>";
    }
    html += html_row(header);
    for (std::size_t s = 0; s < m.sources.size(); ++s)
        for (std::size_t r = 0; r < m.receivers.size(); ++r) {
            std::string cells = html_cell(m.sources[s].name) + html_cell(report.receivers[r]);
            for (std::size_t p = 0; p < kDescribedParameterCount; ++p)
                cells += value_cell(single_number(m.parameters[m.pair(s, r)], p),
                                    parameter_text(p).decimals);
            html += html_row(cells);
        }
    return html +
           "</table>\n<p>ISO 3382-1, annex A: means of 500 and 1000 Hz; of 125 to 1000 Hz for J_LF "
           "and J_LFC, in energy for L_J; of 500 to 2000 Hz for IACC. STI: IEC 60268-16:2011, male "
           "speech. \"-\": the decay is not sufficient, or the source is not audible.</p>\n";
}

/// How errors are to be read.
std::string uncertainty(const RoomReport& report) {
    if (report.frames_given)
        return "<p>The number of frames was given, so that the standard errors of the energy "
               "responses are unknown. Those of IACC are of the noise of the reverberation.</p>\n";
    return "<p>± is the standard error of the estimate in the unit of its value (jackknife over "
           "independent windows). It covers the randomness of the simulation, not the "
           "uncertainty of geometry and coefficients. The error of IACC is that of the noise of "
           "the reverberation only.</p>\n";
}

std::string positions(const RoomReport& report) {
    const Measurement& m = report.measurement;
    std::vector<PlanPoint> points;
    std::string rows;
    for (const Source& source : m.sources) {
        points.push_back({glm::vec2(source.position_at(0)), source.name, true});
        rows += html_row(html_cell("source") + html_cell(source.name) +
                         html_cell(coordinates(source.position_at(0))) +
                         html_cell(directivity_name(source)));
    }
    for (std::size_t r = 0; r < m.receivers.size(); ++r) {
        points.push_back({glm::vec2(m.receivers[r].position), report.receivers[r], false});
        rows +=
            html_row(html_cell("receiver " + std::to_string(r)) + html_cell(report.receivers[r]) +
                     html_cell(coordinates(m.receivers[r].position)) + html_cell(""));
    }
    return "<h2>Sources and receivers</h2>\n<figure>\n" + plan_svg(report.plan, points) +
           formatted(
               "<figcaption>Plan at the height of %.2f m. Discs: sources. Crosses: "
               "receivers.</figcaption>\n</figure>\n",
               double{report.plan_height_m}) +
           "<table class=\"text\">\n" +
           html_row(html_header("") + html_header("name") + html_header("x, y, z in m") +
                    html_header("directivity")) +
           rows + "</table>\n";
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
    html += text_row("rays per source and frame", std::to_string(simulation.rays));
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
    html += text_row("size of patches", formatted("%g m", double{simulation.patch_size_m}));
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
    return html + "</table>\n<p>Areas are of the surfaces that sound reaches.</p>\n";
}

/// The octaves of a pair with its curves.
std::string pair_section(const RoomReport& report, std::size_t s, std::size_t r) {
    const Measurement& m = report.measurement;
    const std::size_t pair = m.pair(s, r);
    std::string html =
        "<h3>" + html_text(m.sources[s].name) + " at " + html_text(report.receivers[r]) + "</h3>\n";
    if (!m.audible[pair]) return html + "<p>The source is not audible at this receiver.</p>\n";
    html += "<table>\n" +
            html_row(html_header("octave in Hz") + band_headers() + html_header("single number"));
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

}  // namespace

std::string report_html(const RoomReport& report) {
    const std::string title = html_text(report.title);
    std::string html = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
    html +=
        "<meta name=\"viewport\" content=\"width=device-width\">\n<title>Room acoustics: " + title +
        "</title>\n" + kStyle + "</head>\n<body>\n";
    html += "<h1>Room acoustics: " + title +
            "</h1>\n<p>Parameters of ISO 3382-1 and IEC 60268-16 by simulation.</p>\n";
    html += positions(report) + summary(report) + uncertainty(report);
    const Measurement& m = report.measurement;
    if (!m.warnings.empty()) {
        html += "<h2>Remarks</h2>\n<ul>\n";
        for (const std::string& warning : m.warnings)
            html += "<li>" + html_text(warning) + "</li>\n";
        html += "</ul>\n";
    }
    html += speech_section(report) + measured_section(report);
    html += conditions(report) + materials(report) + "<h2>Octaves</h2>\n";
    for (std::size_t s = 0; s < m.sources.size(); ++s)
        for (std::size_t r = 0; r < m.receivers.size(); ++r) html += pair_section(report, s, r);
    return html +
           "<div class=\"sign\"><div>place, date</div><div>name, signature</div></div>\n"
           "</body>\n</html>\n";
}

}  // namespace aula
