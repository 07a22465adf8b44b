#include "apps/dataset/plan/manifest.h"

#include <cmath>
#include <utility>

#include "aula/engine/directivity.h"
#include "aula/exception.h"
#include "engine/input/names.h"
#include "engine/scene/scene_values.h"
#include "process/regular_file.h"

namespace aula {

namespace {

constexpr std::uint64_t kMaxBytes = std::uint64_t{16} << 20U;
constexpr const char* kManifest = "a manifest";
constexpr int kMostPerScene = 10'000;
constexpr NumberRange kClearance_m{0, 1000, true, "metres from 0 to 1000"};
constexpr NumberRange kCoordinate_m{-kLargestCoordinate_m, kLargestCoordinate_m, true, "metres"};
constexpr NumberRange kAngle_deg{-360, 360, true, "degrees from -360 to 360"};
constexpr NumberRange kEdge_m{0.1, 1000, true, "metres from 0.1 to 1000"};

BoxRooms read_boxes(const JsonReader& json) {
    constexpr const char* kSizes = "three lengths in metres";
    json.allow_keys({"size_m", "walls", "floor", "ceiling"});
    std::vector<NumberDistribution> size_m;
    const JsonReader sizes = json.require("size_m", kSizes);
    for (const JsonReader& item : sizes.items(kSizes)) size_m.emplace_back(item, kEdge_m);
    if (size_m.size() != 3) sizes.fail(std::string("expected ") + kSizes);
    BoxRooms boxes{std::move(size_m), MaterialDistribution(json.require("walls", "a material")),
                   std::nullopt, std::nullopt};
    json.read("floor", [&](const JsonReader& x) { boxes.floor.emplace(x); });
    json.read("ceiling", [&](const JsonReader& x) { boxes.ceiling.emplace(x); });
    return boxes;
}

Bounds read_region(const JsonReader& json) {
    constexpr const char* kCorners = "the lowest and the highest corner";
    const std::vector<JsonReader> corners = json.items(kCorners);
    if (corners.size() != 2) json.fail(std::string("expected ") + kCorners);
    const Bounds region{read_point(corners[0]), read_point(corners[1])};
    if (!region.contains(region.min)) json.fail(std::string("expected ") + kCorners);
    return region;
}

RoomGroup read_group(const JsonReader& json) {
    constexpr const char* kRooms = "a group of rooms with either box or scene";
    json.allow_keys({"count", "box", "scene", "region_m", "materials"});
    RoomGroup group{
        static_cast<std::uint64_t>(
            json.require("count", "a number of scenes").integer(1, static_cast<int>(kMostScenes))),
        SceneRooms{NameDistribution(""), std::nullopt, {}}};
    const auto box = json.find("box");
    const auto scene = json.find("scene");
    if (box.has_value() == scene.has_value()) json.fail(std::string("expected ") + kRooms);
    if (box) {
        for (const char* const key : {"region_m", "materials"})
            if (const auto member = json.find(key))
                member->fail("is used with a box; expected it with a scene only");
        group.rooms = read_boxes(*box);
        return group;
    }
    SceneRooms rooms{NameDistribution(*scene, "a scene file"), std::nullopt, {}};
    json.read("region_m", [&](const JsonReader& x) { rooms.region = read_region(x); });
    json.read("materials", [&](const JsonReader& materials) {
        for (const auto& [name, material] : materials.members("materials by their names"))
            rooms.materials.emplace(name, MaterialDistribution(material));
    });
    group.rooms = std::move(rooms);
    return group;
}

Placement read_placement(const JsonReader& json) {
    constexpr NumberRange kCount{1, kMostPerScene, true, "a whole number from 1 to 10000"};
    Placement p;
    json.read("count", [&](const JsonReader& x) { p.count = NumberDistribution(x, kCount, true); });
    json.read("walk", [&](const JsonReader& x) {
        x.allow_keys({"steps", "length_m"});
        p.walk = Walk{x.require("steps", "a number of positions").integer(2, kMostPerScene),
                      NumberDistribution(x.require("length_m", kEdge_m.expected), kEdge_m)};
    });
    json.read("wall_clearance_m",
              [&](const JsonReader& x) { p.wall_clearance_m = x.real(kClearance_m); });
    json.read("z_m", [&](const JsonReader& x) { p.z_m.emplace(x, kCoordinate_m); });
    json.read("yaw_deg",
              [&](const JsonReader& x) { p.yaw_deg = NumberDistribution(x, kAngle_deg); });
    json.read("pitch_deg",
              [&](const JsonReader& x) { p.pitch_deg = NumberDistribution(x, kAngle_deg); });
    return p;
}

NameDistribution read_directivity(const JsonReader& json) {
    NameDistribution directivity(json, "the name of a directivity");
    for (const std::string& name : directivity.names())
        if (!Directivity::find(name))
            json.fail("unknown directivity " + quoted(name) + "; expected one of " +
                      quoted_list(Directivity::names()));
    return directivity;
}

}  // namespace

std::uint64_t Manifest::scenes() const {
    std::uint64_t count = 0;
    for (const RoomGroup& group : groups) count += group.count;
    return count;
}

bool is_manifest(const std::filesystem::path& file) {
    constexpr std::uint64_t kBegin = 1024;
    try {
        const std::string begin = RegularFile(file, kManifest).read(0, kBegin);
        return begin.find("\"aula_dataset\"") != std::string::npos;
    } catch (const InputError&) {
        return false;
    }
}

Manifest read_manifest(const std::filesystem::path& file) {
    Manifest manifest;
    manifest.file = file;
    const std::string name = file.string();
    manifest.json = parse_json(read_regular_file(file, kMaxBytes, kManifest), name);
    const JsonReader root(manifest.json, name);
    constexpr NumberRange kVersion{1, 1, true, "1, the version of the format"};
    root.require("aula_dataset", kVersion.expected).number(kVersion);
    std::vector<std::string> keys = settings_keys();
    keys.insert(keys.end(), {"aula_dataset", "rooms", "sources", "receivers"});
    root.allow_keys(keys);
    manifest.settings = read_settings(root);
    constexpr const char* kGroups = "a list of at least one group of rooms";
    const JsonReader rooms = root.require("rooms", kGroups);
    for (const JsonReader& item : rooms.items(kGroups)) {
        manifest.groups.push_back(read_group(item));
        if (manifest.scenes() > kMostScenes)
            item.fail("too many scenes; expected at most " + std::to_string(kMostScenes));
    }
    if (manifest.groups.empty()) rooms.fail(std::string("is empty; expected ") + kGroups);
    root.read("sources", [&](const JsonReader& json) {
        json.allow_keys(
            {"count", "walk", "wall_clearance_m", "z_m", "yaw_deg", "pitch_deg", "directivity"});
        manifest.sources = read_placement(json);
        json.read("directivity",
                  [&](const JsonReader& x) { manifest.directivity = read_directivity(x); });
    });
    manifest.receivers.source_clearance_m = 0.5F;
    root.read("receivers", [&](const JsonReader& json) {
        json.allow_keys({"count", "walk", "wall_clearance_m", "source_clearance_m", "z_m",
                         "yaw_deg", "pitch_deg"});
        manifest.receivers = read_placement(json);
        manifest.receivers.source_clearance_m = 0.5F;
        json.read("source_clearance_m", [&](const JsonReader& x) {
            manifest.receivers.source_clearance_m = x.real(kClearance_m);
        });
    });
    const double pairs = manifest.sources.count.highest() * manifest.sources.steps() *
                         manifest.receivers.count.highest() * manifest.receivers.steps() *
                         static_cast<double>(manifest.settings.array.size());
    if (pairs > static_cast<double>(kMostPairs))
        root.fail("up to " + std::to_string(std::llround(pairs)) +
                  " pairs of a source and a microphone in a scene; expected at most 100000");
    return manifest;
}

}  // namespace aula
