#include "apps/bench/base/table.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/bench/base/machine.h"

namespace aula::bench {

namespace {

std::string fixed(double x, int decimals) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*f", decimals, x);
    return text.data();
}

std::string to_text(const Value& value, int decimals) {
    if (const auto* number = std::get_if<double>(&value)) return fixed(*number, decimals);
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
    if (const auto* text = std::get_if<std::string>(&value)) return *text;
    if (const auto* position = std::get_if<std::array<double, 3>>(&value)) {
        return fixed((*position)[0], decimals) + "," + fixed((*position)[1], decimals) + "," +
               fixed((*position)[2], decimals);
    }
    return "-";
}

bool is_text(const Column& column, const std::vector<Row>& rows) {
    return std::any_of(rows.begin(), rows.end(), [&](const Row& row) {
        return std::holds_alternative<std::string>(row.at(column.figure));
    });
}

nlohmann::ordered_json json_of(const Value& value) {
    return std::visit(
        [](const auto& v) -> nlohmann::ordered_json {
            if constexpr (std::is_same_v<std::decay_t<decltype(v)>, std::monostate>) {
                return nullptr;
            } else {
                return v;
            }
        },
        value);
}

}  // namespace

std::vector<Column> columns_of(std::initializer_list<const char*> figures) {
    static const std::vector<Column> all{{"basis", "basis", 0},
                                         {"bent_paths", "bent paths", 1},
                                         {"cache_entries", "entries", 0},
                                         {"cache_ns", "cache", 0},
                                         {"cells", "cells", 0},
                                         {"change", "change", 0},
                                         {"cost_to_one", "over one", 2},
                                         {"counted_to_measured", "counted/measured", 2},
                                         {"cpu_per_second", "CPU s/s", 2},
                                         {"difference_db", "finer grid dB", 2},
                                         {"diffraction_ms", "diffraction ms", 2},
                                         {"diffraction_ns", "diffraction", 0},
                                         {"diffraction_share", "share", 3},
                                         {"direction_noise_deg", "direction deg", 2},
                                         {"edges", "edges", 0},
                                         {"edges_s", "finding s", 2},
                                         {"energy_ratio", "energy ratio", 4},
                                         {"energy_ratio_error", "+-", 4},
                                         {"error_to_pt", "over pt", 3},
                                         {"estimator", "estimator", 0},
                                         {"expected_modes", "expected", 0},
                                         {"field", "field", 0},
                                         {"first_receiver_ms", "first ms", 2},
                                         {"fluctuation_db", "fluctuation dB", 3},
                                         {"frame_cpu_ms", "CPU ms", 2},
                                         {"frame_ms", "frame ms", 2},
                                         {"frames", "frames", 0},
                                         {"gather_ns", "gather", 0},
                                         {"grid_s", "grid s", 2},
                                         {"highest_hz", "to Hz", 0},
                                         {"largest_db", "largest dB", 2},
                                         {"load_s", "loading s", 2},
                                         {"longest_ms", "longest ms", 2},
                                         {"memory_mb", "MB", 1},
                                         {"modes", "modes", 0},
                                         {"modes_s", "modes s", 2},
                                         {"movement", "movement", 0},
                                         {"mover", "mover", 0},
                                         {"noise", "noise", 4},
                                         {"noise_to_pt", "over pt", 3},
                                         {"octave_hz", "octave Hz", 0},
                                         {"over_rays_db", "over rays dB", 1},
                                         {"pair_ms", "pair ms", 2},
                                         {"patch_size_m", "lambda m", 3},
                                         {"poles_s", "poles s", 2},
                                         {"moved_s", "moved s", 2},
                                         {"prepare_s", "prepare s", 2},
                                         {"quality", "quality", 0},
                                         {"ratio", "raw over frame", 3},
                                         {"raw_ns", "raw", 0},
                                         {"raw_times_one_thread", "raw speed-up", 2},
                                         {"ray_scene_s", "ray scene s", 2},
                                         {"rays", "rays", 0},
                                         {"receiver_ms", "receiver ms", 2},
                                         {"receiver_to_trace", "over trace", 3},
                                         {"receivers", "receivers", 0},
                                         {"reference_error", "reference +-", 4},
                                         {"response_ms", "IR ms", 2},
                                         {"response_s", "response s", 2},
                                         {"rest_error", "error at rest", 4},
                                         {"schroeder_hz", "Schroeder Hz", 0},
                                         {"segments", "segments", 0},
                                         {"source_trace_ms", "trace ms", 1},
                                         {"sources", "sources", 0},
                                         {"specular_ns", "specular", 0},
                                         {"tau_s", "tau s", 2},
                                         {"times_one_thread", "speed-up", 2},
                                         {"trace_ns", "trace ns", 0},
                                         {"tracking_error", "tracking error", 4},
                                         {"triangles", "triangles", 0},
                                         {"volume_m3", "m3", 1},
                                         {"windows", "windows", 0},
                                         {"worst_cpu_ms", "worst ms", 2},
                                         {"worst_frame", "worst frame", 0},
                                         {"worst_to_mean", "worst/mean", 2}};
    std::vector<Column> columns;
    for (const char* figure : figures) {
        const auto found = std::find_if(all.begin(), all.end(),
                                        [&](const Column& c) { return c.figure == figure; });
        assert(found != all.end());
        columns.push_back(*found);
    }
    return columns;
}

const Value& Row::at(const std::string& name) const {
    static const Value nothing;
    const auto found = std::find_if(figures.begin(), figures.end(),
                                    [&](const auto& figure) { return figure.first == name; });
    return found == figures.end() ? nothing : found->second;
}

std::string format_table(const std::vector<Column>& columns, const std::vector<Row>& rows) {
    std::vector<std::string> lines(rows.size() + 1);
    for (const Column& column : columns) {
        std::vector<std::string> cells{column.heading};
        const bool text = is_text(column, rows);
        for (const Row& row : rows) {
            cells.push_back(to_text(row.at(column.figure), column.decimals));
        }
        std::size_t width = 0;
        for (const std::string& cell : cells) width = std::max(width, cell.size());
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const std::string blank(width - cells[i].size(), ' ');
            if (!lines[i].empty()) lines[i] += "  ";
            lines[i] += text ? cells[i] + blank : blank + cells[i];
        }
    }
    std::string table;
    for (std::string& line : lines) {
        line.erase(line.find_last_not_of(' ') + 1);
        table += line + "\n";
    }
    return table;
}

std::string format_markdown(const std::vector<Column>& columns, const std::vector<Row>& rows) {
    std::string heading = "|";
    std::string rule = "|";
    for (const Column& column : columns) {
        heading += " " + column.heading + " |";
        rule += is_text(column, rows) ? "---|" : "---:|";
    }
    std::string table = heading + "\n" + rule + "\n";
    for (const Row& row : rows) {
        table += "|";
        for (const Column& column : columns) {
            table.append(" ").append(to_text(row.at(column.figure), column.decimals)).append(" |");
        }
        table += "\n";
    }
    return table;
}

std::string to_json(const std::vector<Row>& rows) {
    nlohmann::ordered_json document;
    document["machine"] = machine_line();
    document["rows"] = nlohmann::ordered_json::array();
    for (const Row& row : rows) {
        nlohmann::ordered_json entry;
        for (const auto& [name, value] : row.figures) entry[name] = json_of(value);
        document["rows"].push_back(entry);
    }
    return document.dump(2) + "\n";
}

}  // namespace aula::bench
