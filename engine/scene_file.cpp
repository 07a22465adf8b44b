#include "engine/scene_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <unordered_set>

#include "engine/error.h"
#include "engine/names.h"
#include "engine/scene_geometry.h"
#include "engine/scene_values.h"

namespace aula {
namespace {

std::string read_text(const std::filesystem::path& file) {
    constexpr const char* kExpected = "; expected a scene file";
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) {
        throw Error(file.string(), "", std::string("is a folder") + kExpected);
    }
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
        throw Error(file.string(), "",
                    std::string("cannot be opened, ") + std::strerror(errno) + kExpected);
    }
    // Not a regular file's size: the scene may come through a pipe.
    constexpr std::size_t kMostBytes = std::size_t{256} << 20U;
    std::string text;
    std::array<char, 65536> part{};
    do {
        stream.read(part.data(), part.size());
        text.append(part.data(), static_cast<std::size_t>(stream.gcount()));
        if (text.size() > kMostBytes) {
            throw Error(file.string(), "",
                        "holds more than " + std::to_string(kMostBytes) + " bytes" + kExpected);
        }
    } while (stream);
    if (stream.bad()) throw Error(file.string(), "", std::string("cannot be read") + kExpected);
    return text;
}

// Keeps names apart: remembers where each stands.
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
        objects.push_back(read_object(item, folder, materials, warnings));
        if (const auto name = item.find("name")) names.add(objects.back().name, *name);
    }
    return objects;
}

Medium read_medium(const JsonReader& json) {
    json.allow_keys({"temperature_c", "humidity_percent", "pressure_kpa", "air_absorption"});
    constexpr NumberRange kTemperature_c{-100, 100, true, "degrees Celsius from -100 to 100"};
    constexpr NumberRange kHumidity_percent{0, 100, true, "percent from 0 to 100"};
    constexpr NumberRange kPressure_kpa{1, 1000, true, "kilopascals from 1 to 1000"};
    Medium medium;
    if (const auto x = json.find("temperature_c")) medium.temperature_c = x->real(kTemperature_c);
    if (const auto x = json.find("humidity_percent")) {
        medium.humidity_percent = x->real(kHumidity_percent);
    }
    if (const auto x = json.find("pressure_kpa")) medium.pressure_kpa = x->real(kPressure_kpa);
    if (const auto x = json.find("air_absorption")) medium.air_absorption = x->boolean();
    return medium;
}

// "position", or where the path begins.
Vec3 read_position(const JsonReader& json, const std::optional<Path>& path) {
    if (path && !json.find("position")) return path->points.front().pose.position;
    return read_point(json.require("position", "a list of 3 numbers, x, y, z in metres"));
}

void read_signal(const JsonReader& json, const std::filesystem::path& folder, Source& source) {
    constexpr const char* kExpected = "a sound file, \"impulse\" or \"noise\"";
    const std::string signal = json.string(kExpected);
    if (signal == "impulse") {
        source.signal = Source::Signal::impulse;
    } else if (signal == "noise") {
        source.signal = Source::Signal::noise;
    } else {
        source.signal = Source::Signal::file;
        source.signal_file = folder / signal;
        std::error_code error;
        if (!std::filesystem::is_regular_file(source.signal_file, error)) {
            json.fail("no such file, " + quoted(source.signal_file.string()) + "; expected " +
                      kExpected);
        }
    }
}

std::vector<Source> read_sources(const JsonReader& json, const std::filesystem::path& folder) {
    constexpr const char* kExpected = "a list of at least one source";
    constexpr NumberRange kGain_db{-200, 200, true, "decibels from -200 to 200"};
    std::vector<Source> sources;
    UniqueNames names;
    for (const JsonReader& item : json.items(kExpected)) {
        item.allow_keys({"name", "position", "signal", "gain_db", "loop", "path"});
        Source source;
        source.name = "source" + std::to_string(sources.size() + 1);
        const auto name = item.find("name");
        if (name) source.name = name->string("a name");
        if (source.name.empty()) name->fail("an empty name; expected a name");
        names.add(source.name, name.value_or(item));
        source.path = find_path(item);
        source.position = read_position(item, source.path);
        if (const auto x = item.find("signal")) read_signal(*x, folder, source);
        if (const auto x = item.find("gain_db")) source.gain_db = x->real(kGain_db);
        if (const auto x = item.find("loop")) source.loop = x->boolean();
        sources.push_back(std::move(source));
    }
    if (sources.empty()) json.fail(std::string("no source; expected ") + kExpected);
    return sources;
}

Listener read_listener(const JsonReader& json) {
    json.allow_keys({"position", "yaw_deg", "pitch_deg", "roll_deg", "path"});
    Listener listener;
    listener.path = find_path(json);
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

Simulation read_simulation(const JsonReader& json) {
    json.allow_keys({"estimator", "rays", "order", "response_time_s", "patch_size_m",
                     "listener_radius_m", "frame_rate_hz", "ir_length_s", "seed", "threads",
                     "memory_mb", "direct", "specular_order", "specular"});
    constexpr NumberRange kResponseTime_s{0, 3600, true, "seconds from 0 to 3600"};
    constexpr NumberRange kLength_m{0, 1e6, false, "metres above 0, at most 1e6"};
    constexpr NumberRange kRate_hz{0, 1000, false, "frames per second above 0, at most 1000"};
    constexpr NumberRange kIrLength_s{0, 10, false, "seconds above 0, at most 10"};
    Simulation s;
    if (const auto x = json.find("estimator")) s.estimator = read_estimator(*x);
    if (const auto x = json.find("rays")) s.rays = x->integer(1, Simulation::kMostRays);
    if (const auto x = json.find("order")) s.order = x->integer(0, 1'000'000);
    if (const auto x = json.find("response_time_s")) s.response_time_s = x->real(kResponseTime_s);
    if (const auto x = json.find("patch_size_m")) s.patch_size_m = x->real(kLength_m);
    if (const auto x = json.find("listener_radius_m")) s.listener_radius_m = x->real(kLength_m);
    if (const auto x = json.find("frame_rate_hz")) s.frame_rate_hz = x->real(kRate_hz);
    if (const auto x = json.find("ir_length_s")) s.ir_length_s = x->real(kIrLength_s);
    if (const auto x = json.find("seed")) s.seed = x->unsigned_integer();
    if (const auto x = json.find("threads")) s.threads = x->integer(1, 1024);
    if (const auto x = json.find("memory_mb")) s.memory_mb = x->integer(1, 1'000'000);
    if (const auto x = json.find("direct")) s.direct = x->boolean();
    if (const auto x = json.find("specular_order")) {
        s.specular_order = x->integer(0, Simulation::kHighestSpecularOrder);
    }
    if (const auto x = json.find("specular")) s.specular = x->boolean();
    return s;
}

std::string point_text(const Vec3& p) {
    std::ostringstream text;
    text << '(' << p.x << ", " << p.y << ", " << p.z << ')';
    return text.str();
}

void warn_if_outside(const std::string& who, const JsonReader& json, const Vec3& position,
                     const std::optional<Path>& path, const Bounds& bounds,
                     std::vector<std::string>& warnings) {
    std::vector<Vec3> positions;
    if (path) {
        for (const Path::Point& point : path->points) positions.push_back(point.pose.position);
    } else {
        positions.push_back(position);
    }
    for (const Vec3& p : positions) {
        if (bounds.contains(p)) continue;
        warnings.push_back(json.message(who + " is outside the geometry at " + point_text(p) +
                                        "; the geometry's bounds are " + point_text(bounds.min) +
                                        " to " + point_text(bounds.max)));
        return;
    }
}

}  // namespace

LoadedScene load_scene(const std::filesystem::path& file) {
    const std::string name = file.string();
    LoadedScene loaded;
    loaded.json = parse_json(read_text(file), name);
    const JsonReader root(loaded.json, name);
    root.allow_keys(
        {"aula", "geometry", "materials", "medium", "sources", "listener", "simulation", "expect"});
    constexpr NumberRange kVersion{1, 1, true, "1, the version of the format"};
    root.require("aula", kVersion.expected).number(kVersion);

    const std::filesystem::path folder = file.parent_path();
    Scene& scene = loaded.scene;
    MaterialTable materials(root.find("materials"));
    if (const auto geometry = root.find("geometry")) {
        scene.objects = read_geometry(*geometry, folder, materials, loaded.warnings);
    }
    scene.materials = materials.take();
    if (const auto medium = root.find("medium")) scene.medium = read_medium(*medium);
    constexpr const char* kSources = "a list of at least one source";
    const JsonReader sources = root.require("sources", kSources);
    scene.sources = read_sources(sources, folder);
    const JsonReader listener = root.require("listener", "an object with the listener's position");
    scene.listener = read_listener(listener);
    if (const auto simulation = root.find("simulation")) {
        scene.simulation = read_simulation(*simulation);
        loaded.rays_given = simulation->find("rays").has_value();
    }

    if (scene.objects.empty()) return loaded;
    const Bounds bounds = geometry_bounds(scene.objects);
    const std::vector<JsonReader> source_items = sources.items(kSources);
    for (std::size_t i = 0; i < scene.sources.size(); ++i) {
        const Source& source = scene.sources[i];
        warn_if_outside("the source " + quoted(source.name), source_items[i], source.position,
                        source.path, bounds, loaded.warnings);
    }
    warn_if_outside("the listener", listener, scene.listener.pose.position, scene.listener.path,
                    bounds, loaded.warnings);
    return loaded;
}

}  // namespace aula
