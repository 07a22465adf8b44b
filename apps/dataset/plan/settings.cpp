#include "apps/dataset/plan/settings.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <utility>

#include "apps/output/json_text.h"
#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "engine/input/names.h"
#include "engine/scene/scene_values.h"

namespace aula {

namespace {

/// Text of one line.
std::string read_line(const JsonReader& json, const char* expected) {
    constexpr std::size_t kLongest = 1000;  // an attribute of HDF5 has at most 64 KiB
    std::string text = json.string(expected);
    if (text.size() > kLongest)
        json.fail(std::to_string(text.size()) + " bytes; expected at most " +
                  std::to_string(kLongest));
    const auto control = [](unsigned char c) { return c < 0x20; };
    if (text.empty() || std::any_of(text.begin(), text.end(), control))
        json.fail(aula::quoted(text) + " is not usable; expected " + expected + " on one line");
    return text;
}

/// Whether the calendar has this day.
bool is_day(int year, int month, int day) {
    return std::chrono::year_month_day(std::chrono::year(year),
                                       std::chrono::month(static_cast<unsigned>(month)),
                                       std::chrono::day(static_cast<unsigned>(day)))
        .ok();
}

std::string read_date(const JsonReader& json) {
    std::string text = json.string("a date");
    const std::string form = "0000-00-00";
    const auto fits = [](char c, char f) {
        return f == '0' ? std::isdigit(static_cast<unsigned char>(c)) != 0 : c == f;
    };
    const bool has_form =
        text.size() == form.size() && std::equal(text.begin(), text.end(), form.begin(), fits);
    if (!has_form || !is_day(std::stoi(text.substr(0, 4)), std::stoi(text.substr(5, 2)),
                             std::stoi(text.substr(8, 2))))
        json.fail(aula::quoted(text) + " is not usable; expected a date as 2026-11-24");
    return text;
}

/// The settings of the propagation, by the reader of scene files.
Simulation read_simulation(const JsonReader& json, const std::string& text) {
    for (const char* const key : {"seed", "threads"})
        if (const auto member = json.find(key))
            member->fail("is not a setting of a dataset; expected no " + std::string(key) +
                         (std::string_view(key) == "seed" ? " (each scene has its own)"
                                                          : " (aula dataset run --threads)"));
    const std::string scene =
        R"({"aula": 1, "sources": [{"position": [0, 0, 0]}], "listener": {"position": [1, 0, 0]},)"
        R"("simulation": )" +
        text + "}";
    Simulation simulation = parse_scene(scene, json.file(), "").scene.simulation;
    simulation.threads = 1;
    return simulation;
}

void read_measurement(const JsonReader& json, DatasetSettings& settings) {
    constexpr NumberRange kError{0, 1e6, false, "a standard error above 0"};
    constexpr int kMostFrames = 1'000'000;
    json.allow_keys({"frames", "level_db", "c80_db", "t30", "edt", "max_frames"});
    if (const auto frames = json.find("frames")) {
        if (json.members("").size() > 1)
            frames->fail("is used with limits of errors; expected one or the other");
        settings.frames = frames->integer(1, kMostFrames);
    }
    MeasurementLimits& limits = settings.limits;
    json.read("level_db", [&](const JsonReader& x) { limits.level_db = x.number(kError); });
    json.read("c80_db", [&](const JsonReader& x) { limits.c80_db = x.number(kError); });
    json.read("t30", [&](const JsonReader& x) { limits.t30 = x.number(kError); });
    json.read("edt", [&](const JsonReader& x) { limits.edt = x.number(kError); });
    json.read("max_frames",
              [&](const JsonReader& x) { settings.max_frames = x.integer(1, kMostFrames); });
}

void read_output(const JsonReader& json, DatasetSettings& settings) {
    json.allow_keys({"sample_rate_hz", "format"});
    json.read("sample_rate_hz",
              [&](const JsonReader& x) { settings.sample_rate_hz = x.integer(8000, 192'000); });
    json.read("format", [&](const JsonReader& x) {
        const std::string name = x.string("the name of a format");
        for (const auto& [known, format] : kOutputFormats) {
            if (name != known) continue;
            settings.format = format;
            return;
        }
        x.fail("unknown format " + quoted(name) + "; expected mono, foa, toa or binaural");
    });
}

std::vector<Vec3> read_array(const JsonReader& json) {
    constexpr const char* kArray = "a list of at least one microphone [x, y, z]";
    constexpr std::size_t kMost = 1024;
    std::vector<Vec3> array;
    for (const JsonReader& item : json.items(kArray)) array.push_back(read_point(item));
    if (array.empty() || array.size() > kMost)
        json.fail(std::to_string(array.size()) + " microphones; expected 1 to " +
                  std::to_string(kMost));
    return array;
}

}  // namespace

const std::vector<std::string>& settings_keys() {
    static const std::vector<std::string> keys{"title",      "licence",     "date",   "seed",
                                               "simulation", "measurement", "output", "array"};
    return keys;
}

DatasetSettings read_settings(const JsonReader& root) {
    DatasetSettings settings;
    settings.simulation.threads = 1;
    root.read("title", [&](const JsonReader& x) { settings.title = read_line(x, "a title"); });
    constexpr const char* kLicence = "a licence such as CC0-1.0";
    settings.licence = read_line(root.require("licence", kLicence), kLicence);
    root.read("date", [&](const JsonReader& x) { settings.date = read_date(x); });
    root.read("seed", [&](const JsonReader& x) { settings.seed = x.unsigned_integer(); });
    root.read("simulation", [&](const JsonReader& x) {
        settings.simulation = read_simulation(x, json_line(x.value()));
    });
    root.read("measurement", [&](const JsonReader& x) { read_measurement(x, settings); });
    root.read("output", [&](const JsonReader& x) { read_output(x, settings); });
    root.read("array", [&](const JsonReader& x) { settings.array = read_array(x); });
    return settings;
}

std::string format_name(OutputFormat format) {
    for (const auto& [name, known] : kOutputFormats)
        if (known == format) return name;
    return {};
}

}  // namespace aula
