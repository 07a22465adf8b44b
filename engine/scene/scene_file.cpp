#include "aula/engine/scene_file.h"

#include <algorithm>
#include <sstream>
#include <unordered_set>

#include "aula/exception.h"
#include "engine/input/names.h"
#include "engine/mesh/mesh_import.h"
#include "engine/scene/scene_geometry.h"
#include "engine/scene/scene_reading.h"
#include "engine/scene/scene_values.h"
#include "process/files.h"

namespace aula {
namespace {

// Checks that names are unique; stores the location of each.
class UniqueNames {
 public:
    void add(const std::string& name, const JsonReader& json) {
        if (!names_.insert(name).second) {
            json.fail("duplicate name " + quoted(name) + "; expected each name once");
        }
    }

 private:
    std::unordered_set<std::string> names_;
};

std::vector<Object> read_geometry(const JsonReader& json, const std::filesystem::path& folder,
                                  MaterialTable& materials, std::vector<std::string>& warnings) {
    std::vector<Object> objects;
    UniqueNames names;
    for (const JsonReader& item : json.items("a list of geometry")) {
        item.attempt([&] {
            objects.push_back(read_object(item, folder, materials, warnings));
            item.read("name",
                      [&](const JsonReader& name) { names.add(objects.back().name, name); });
        });
    }
    return objects;
}

Medium read_medium(const JsonReader& json) {
    json.allow_keys({"temperature_c", "humidity_percent", "pressure_kpa", "air_absorption"});
    constexpr NumberRange kTemperature_c{-100, 100, true, "degrees Celsius from -100 to 100"};
    constexpr NumberRange kHumidity_percent{0, 100, true, "percent from 0 to 100"};
    constexpr NumberRange kPressure_kpa{1, 1000, true, "kilopascals from 1 to 1000"};
    Medium medium;
    json.read("temperature_c",
              [&](const JsonReader& x) { medium.temperature_c = x.real(kTemperature_c); });
    json.read("humidity_percent",
              [&](const JsonReader& x) { medium.humidity_percent = x.real(kHumidity_percent); });
    json.read("pressure_kpa",
              [&](const JsonReader& x) { medium.pressure_kpa = x.real(kPressure_kpa); });
    json.read("air_absorption", [&](const JsonReader& x) { medium.air_absorption = x.boolean(); });
    return medium;
}

SpeechConditions read_speech(const JsonReader& json) {
    json.allow_keys({"level_db", "noise_level_db"});
    constexpr float kHighest_db = SpeechConditions::kHighestLevel_db;
    constexpr NumberRange kLevel_db{-kHighest_db, kHighest_db, true, "decibels from -200 to 200"};
    SpeechConditions speech;
    json.read("level_db", [&](const JsonReader& x) {
        speech.speech_db = x.is_number() ? SpeechConditions::male_speech_db(x.real(kLevel_db))
                                         : read_bands(x, kLevel_db, 0);
    });
    json.read("noise_level_db",
              [&](const JsonReader& x) { speech.noise_db = read_bands(x, kLevel_db, 0); });
    return speech;
}

// "position", or the start of the path; the origin, after an error, if both are absent.
Vec3 read_position(const JsonReader& json, const std::optional<Trajectory>& path) {
    if (path && !json.find("position")) return path->points.front().pose.position;
    Vec3 position(0);
    const bool unread_path = !path && json.find("path");
    if (unread_path && !json.find("position")) return position;
    json.attempt([&] {
        position = read_point(json.require("position", "a list of 3 numbers, x, y, z in metres"));
    });
    return position;
}

// Reports a file that is missing or is not a regular file.
void require_file(const JsonReader& json, const std::filesystem::path& file, const char* expected) {
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (std::filesystem::is_regular_file(status)) return;
    json.fail((std::filesystem::is_directory(status) ? "a folder, "
               : std::filesystem::exists(status)     ? "not a regular file, "
                                                     : "no such file, ") +
              quoted(file.string()) + "; expected " + expected);
}

void read_signal(const JsonReader& json, const std::filesystem::path& folder, SignalFiles signals,
                 Source& source) {
    constexpr const char* kExpected = "a sound file, \"impulse\" or \"noise\"";
    const std::string signal = json.string(kExpected);
    if (signal == "impulse") {
        source.signal = Source::Signal::impulse;
    } else if (signal == "noise") {
        source.signal = Source::Signal::noise;
    } else {
        source.signal = Source::Signal::file;
        source.signal_file = folder / utf8_path(signal);
        if (signals != SignalFiles::required) return;
        const auto inside = SoundInModel::of_name(source.signal_file);
        require_file(json, inside ? inside->model : source.signal_file, kExpected);
    }
}

void read_directivity(const JsonReader& json, const std::filesystem::path& folder, Source& source) {
    const std::string name = json.string("the name of a directivity or a file");
    if (const auto shipped = Directivity::find(name)) {
        source.directivity = *shipped;
        return;
    }
    const std::filesystem::path file = folder / utf8_path(name);
    const bool is_file_name = name.find_first_of("/.") != std::string::npos;
    std::error_code error;
    if (name.empty() || (!is_file_name && !std::filesystem::exists(file, error))) {
        const std::vector<std::string> names = Directivity::names();
        json.fail("unknown directivity " + quoted(name) + did_you_mean(name, names) +
                  "; expected one of " + quoted_list(names) + ", or a file");
    }
    require_file(json, file, "a SOFA or JSON file of a directivity");
    source.directivity_file = file;
    try {
        source.directivity = load_directivity(file);
    } catch (const InputError& bad) {
        json.fail(std::string("cannot use the directivity: ") + bad.what());
    }
}

/// The pose of a source, or its place on the listener.
void read_pose(const JsonReader& json, Source& source) {
    json.attempt([&] { source.path = find_trajectory(json); });
    source.set_pose(read_orientation(json, read_position(json, source.path)));
    json.read("relative_to", [&](const JsonReader& x) {
        constexpr const char* kExpected = "\"world\" or \"listener\"";
        const std::string frame = x.string(kExpected);
        if (frame == "world") return;
        if (frame != "listener") x.fail(quoted(frame) + "; expected " + kExpected);
        for (const char* const key : {"path", "yaw_deg", "pitch_deg", "roll_deg"})
            if (const auto other = json.find(key))
                other->fail(
                    "a source relative to the listener moves and turns with it; expected a "
                    "position alone");
        source.from_listener = source.position;
    });
}

std::vector<Source> read_sources(const JsonReader& json, const std::filesystem::path& folder,
                                 SignalFiles signals) {
    constexpr const char* kExpected = "a list of at least one source";
    constexpr NumberRange kGain_db{-200, 200, true, "decibels from -200 to 200"};
    constexpr std::size_t kMost = 1024;  // bounds memory: each source has its caches
    std::vector<Source> sources;
    UniqueNames names;
    const auto items = json.items(kExpected);
    if (items.size() > kMost) {
        json.fail(std::to_string(items.size()) + " sources; expected at most " +
                  std::to_string(kMost));
    }
    for (const JsonReader& item : items) {
        sources.emplace_back();
        Source& source = sources.back();
        source.name = "source" + std::to_string(sources.size());
        item.attempt([&] {
            item.allow_keys({"name", "position", "yaw_deg", "pitch_deg", "roll_deg", "directivity",
                             "signal", "gain_db", "loop", "path", "relative_to"});
            item.attempt([&] {
                const auto name = item.find("name");
                if (name) source.name = name->string("a name");
                if (source.name.empty()) name->fail("an empty name; expected a name");
                names.add(source.name, name.value_or(item));
            });
            read_pose(item, source);
            item.read("directivity",
                      [&](const JsonReader& x) { read_directivity(x, folder, source); });
            item.read("signal",
                      [&](const JsonReader& x) { read_signal(x, folder, signals, source); });
            item.read("gain_db", [&](const JsonReader& x) { source.gain_db = x.real(kGain_db); });
            item.read("loop", [&](const JsonReader& x) { source.loop = x.boolean(); });
        });
    }
    if (sources.empty()) json.fail(std::string("no source; expected ") + kExpected);
    return sources;
}

Listener read_listener(const JsonReader& json) {
    json.allow_keys({"position", "yaw_deg", "pitch_deg", "roll_deg", "path"});
    Listener listener;
    json.attempt([&] { listener.path = find_trajectory(json); });
    listener.pose = read_orientation(json, read_position(json, listener.path));
    return listener;
}

Estimator read_estimator(const JsonReader& json) {
    const std::vector<std::string> names{
        estimator_name(Estimator::pt), estimator_name(Estimator::dpc_published),
        estimator_name(Estimator::dpc), estimator_name(Estimator::patch)};
    const std::string name = json.string("the name of an estimator");
    if (const auto estimator = estimator_from_name(name)) return *estimator;
    json.fail("unknown estimator " + quoted(name) + "; expected one of " + quoted_list(names));
}

Quality read_quality(const JsonReader& json) {
    constexpr const char* kExpected = "\"draft\", \"normal\" or \"fine\"";
    const std::string name = json.string(kExpected);
    if (const auto quality = quality_from_name(name)) return *quality;
    json.fail("unknown quality " + quoted(name) + "; expected " + kExpected);
}

/// false, "auto" or a frequency.
float read_waves(const JsonReader& json) {
    constexpr NumberRange kWaves_hz{Simulation::kLowestWaves_hz, Simulation::kHighestWaves_hz, true,
                                    "\"auto\", false, or Hz from 20 to 500"};
    if (json.is_false()) return 0;
    return json.is_text("auto") ? Simulation::kHighestWaves_hz : json.real(kWaves_hz);
}

Simulation read_simulation(const JsonReader& json) {
    json.allow_keys({"estimator", "quality", "rays", "order", "response_time_s", "patch_size_m",
                     "listener_radius_m", "frame_rate_hz", "ir_length_s", "seed", "threads",
                     "memory_mb", "direct", "diffraction_order", "specular_order", "specular",
                     "transmission", "waves"});
    constexpr NumberRange kResponseTime_s{0, Simulation::kMaxResponseTime_s, true,
                                          "seconds from 0 to 3600"};
    constexpr NumberRange kLength_m{0, Simulation::kMaxLength_m, false,
                                    "metres above 0, at most 1e6"};
    constexpr NumberRange kRate_hz{0, Simulation::kMaxFrameRate_hz, false,
                                   "frames per second above 0, at most 1000"};
    constexpr NumberRange kIrLength_s{0, Simulation::kMaxIrLength_s, false,
                                      "\"auto\", or seconds above 0, at most 10"};
    Simulation s;
    json.read("estimator", [&](const JsonReader& x) { s.estimator = read_estimator(x); });
    json.read("quality", [&](const JsonReader& x) { s.quality = read_quality(x); });
    json.read("rays", [&](const JsonReader& x) { s.rays = x.integer(1, Simulation::kMaxRays); });
    json.read("order", [&](const JsonReader& x) { s.order = x.integer(0, Simulation::kMaxOrder); });
    json.read("response_time_s",
              [&](const JsonReader& x) { s.response_time_s = x.real(kResponseTime_s); });
    json.read("patch_size_m", [&](const JsonReader& x) { s.patch_size_m = x.real(kLength_m); });
    json.read("listener_radius_m",
              [&](const JsonReader& x) { s.listener_radius_m = x.real(kLength_m); });
    json.read("frame_rate_hz", [&](const JsonReader& x) { s.frame_rate_hz = x.real(kRate_hz); });
    json.read("ir_length_s", [&](const JsonReader& x) {
        if (!x.is_text("auto")) s.ir_length_s = x.real(kIrLength_s);
    });
    json.read("seed", [&](const JsonReader& x) { s.seed = x.unsigned_integer(); });
    json.read("threads",
              [&](const JsonReader& x) { s.threads = x.integer(1, Simulation::kMaxThreads); });
    json.read("memory_mb",
              [&](const JsonReader& x) { s.memory_mb = x.integer(1, Simulation::kMaxMemory_mb); });
    json.read("direct", [&](const JsonReader& x) { s.direct = x.boolean(); });
    json.read("diffraction_order", [&](const JsonReader& x) {
        s.diffraction_order = x.integer(0, Simulation::kHighestDiffractionOrder);
    });
    json.read("specular_order", [&](const JsonReader& x) {
        s.specular_order = x.integer(0, Simulation::kHighestSpecularOrder);
    });
    json.read("specular", [&](const JsonReader& x) { s.specular = x.boolean(); });
    json.read("transmission", [&](const JsonReader& x) { s.transmission = x.boolean(); });
    json.read("waves", [&](const JsonReader& x) { s.waves_hz = read_waves(x); });
    return s;
}

std::string point_text(const Vec3& p) {
    std::ostringstream text;
    text << '(' << p.x << ", " << p.y << ", " << p.z << ')';
    return text.str();
}

void warn_if_outside(const std::string& name, const JsonReader& json, const Vec3& position,
                     const std::optional<Trajectory>& path, const Bounds& bounds,
                     std::vector<std::string>& warnings) {
    std::vector<Vec3> positions;
    if (path) {
        for (const Trajectory::Keyframe& point : path->points)
            positions.push_back(point.pose.position);
    } else {
        positions.push_back(position);
    }
    for (const Vec3& p : positions) {
        if (bounds.contains(p)) continue;
        warnings.push_back(json.message(name + " is outside the geometry at " + point_text(p) +
                                        "; the geometry's bounds are " + point_text(bounds.min) +
                                        " to " + point_text(bounds.max)));
        return;
    }
}

}  // namespace

SceneErrors::SceneErrors(std::vector<std::string> messages)
    : InputError(messages.front()), messages_(std::move(messages)) {}

LoadedScene parse_scene(const std::string& text, const std::string& name,
                        const std::filesystem::path& folder, SignalFiles signals) {
    return read_scene(parse_json(text, name), name, folder, signals);
}

LoadedScene read_scene(JsonValue json, const std::string& name, const std::filesystem::path& folder,
                       SignalFiles signals) {
    LoadedScene loaded;
    loaded.json = std::make_shared<const JsonValue>(std::move(json));
    JsonErrors errors;
    const JsonReader root(*loaded.json, name, &errors);
    Scene& scene = loaded.scene;
    std::vector<JsonReader> source_items;
    std::optional<JsonReader> listener;
    root.attempt([&] {
        root.allow_keys({"aula", "geometry", "materials", "medium", "sources", "listener",
                         "simulation", "speech", "expect"});
        root.attempt([&] {
            constexpr NumberRange kVersion{1, 1, true, "1, the version of the format"};
            root.require("aula", kVersion.expected).number(kVersion);
        });
        MaterialTable materials(root.find("materials"));
        root.read("geometry", [&](const JsonReader& geometry) {
            scene.objects = read_geometry(geometry, folder, materials, loaded.warnings);
        });
        scene.materials = materials.take();
        root.read("medium", [&](const JsonReader& x) { scene.medium = read_medium(x); });
        root.attempt([&] {
            constexpr const char* kSources = "a list of at least one source";
            const JsonReader sources = root.require("sources", kSources);
            scene.sources = read_sources(sources, folder, signals);
            source_items = sources.items(kSources);
        });
        root.attempt([&] {
            listener = root.require("listener", "an object with the listener's position");
            scene.listener = read_listener(*listener);
        });
        root.read("simulation",
                  [&](const JsonReader& x) { scene.simulation = read_simulation(x); });
        root.read("speech", [&](const JsonReader& x) { scene.speech = read_speech(x); });
    });
    if (!errors.empty()) throw SceneErrors(errors.messages(name));

    scene.attach_sources();
    if (scene.objects.empty()) return loaded;
    const Bounds bounds = geometry_bounds(scene.objects);
    for (std::size_t i = 0; i < scene.sources.size(); ++i) {
        const Source& source = scene.sources[i];
        warn_if_outside("the source " + quoted(source.name), source_items[i], source.position,
                        source.path, bounds, loaded.warnings);
    }
    warn_if_outside("the listener", *listener, scene.listener.pose.position, scene.listener.path,
                    bounds, loaded.warnings);
    return loaded;
}

}  // namespace aula
