#include <algorithm>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "apps/documents/report/report_cells.h"
#include "apps/documents/report/report_sections.h"
#include "apps/output/formatted.h"
#include "apps/room/edit/scene_state.h"
#include "apps/room/offline/measurement_text.h"
#include "aula/engine/material_library.h"

namespace aula {

namespace {

std::string coordinates(const Vec3& p) {
    return formatted("%.2f, %.2f, %.2f", double{p.x}, double{p.y}, double{p.z});
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
    return "<table>\n" + head_row(header) + rows + "</table>\n";
}

std::string yes_no(bool value) { return value ? "yes" : "no"; }

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
               head_row(html_header("file") + html_header("layer") + html_header("material") +
                        html_header("area in m²"));
        for (const LayerMaterial& layer : report.layers)
            html += html_row(html_cell(layer.file) + html_cell(layer.layer) +
                             html_cell(layer.material) + number_cell(layer.area_m2, 1));
        html += "</table>\n";
    }
    if (report.guesses.empty()) return html;
    html += "<p>The model does not say, and was guessed:</p>\n<ul>\n";
    for (const std::string& guess : report.guesses) html += "<li>" + html_text(guess) + "</li>\n";
    return html + "</ul>\n";
}

}  // namespace

std::string positions_section(const RoomReport& report) {
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
           head_row(html_header("") + html_header("name") + html_header("x, y, z in m") +
                    html_header("directivity") + html_header("yaw, pitch") +
                    html_header("gain in dB")) +
           rows + "</table>\n" + distances(report) +
           "<p>Yaw 0° looks along x, 90° along y. Gains are those of the signals; the "
           "parameters do not depend on them.</p>\n";
}

std::string conditions_section(const RoomReport& report) {
    const Measurement& m = report.measurement;
    const Simulation& simulation = m.simulation;
    const Medium& medium = report.scene.medium;
    std::string html = "<h2>Conditions</h2>\n<table class=\"text\">\n";
    html += text_row("program", report.program);
    html += text_row("scene", report.scene_name);
    html += html_row("<td>SHA-256 of the scene</td><td class=\"hash\">" +
                     html_text(report.scene_hash) + "</td>");
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
    if (m.waves_below_hz > 0)
        html += text_row("modes of the room below", formatted("%.0f Hz", m.waves_below_hz));
    for (const std::string& line : m.without_waves)
        html += text_row("rays at all frequencies", line);
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
    html += "</table>\n<table>\n" + head_row(html_header("octave in Hz") + band_headers());
    html += html_row(html_cell("speech at 1 m on axis in dB") +
                     band_cells(report.scene.speech.speech_db, 1));
    html += report.scene.speech.noise_db
                ? html_row(html_cell("noise at the receivers in dB") +
                           band_cells(*report.scene.speech.noise_db, 1))
                : html_row("<td>noise at the receivers</td><td colspan=\"8\">none</td>");
    return html + "</table>\n";
}

std::string materials_section(const RoomReport& report) {
    std::string html = "<h2>Materials</h2>\n<table>\n" +
                       head_row(html_header("material") + html_header("area in m²") +
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

}  // namespace aula
