#include "apps/dataset/plan/planned_scene.h"

#include <algorithm>
#include <utility>

#include "apps/dataset/base/json_values.h"
#include "apps/dataset/base/sha256.h"
#include "apps/output/json_text.h"
#include "apps/room/edit/scene_state.h"
#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "engine/input/json_reader.h"
#include "engine/input/names.h"
#include "engine/scene/scene_values.h"

namespace aula {

namespace {

/// Scene files that are kept, so that scenes of one file do not read it each.
constexpr std::size_t kKeptFiles = 8;

/// "geometry" and "materials" of a scene file with a box. A box has two triangles per wall: those
/// of the floor, of the ceiling, then of the walls.
JsonValue::Object box_members(const PlannedScene& planned) {
    JsonValue::Array surfaces;
    std::uint64_t first = 0;
    for (const char* const name : {"floor", "ceiling"}) {
        surfaces.push_back(json_value(
            JsonValue::Object{{"material", json_value(std::string(name))},
                              {"triangles", json_value(JsonValue::Array{json_value(JsonValue::Array{
                                                json_value(first), json_value(first + 1)})})}}));
        first += 2;
    }
    JsonValue::Object room{{"name", json_value(std::string("room"))},
                           planned.geometry.front(),
                           {"material", json_value(std::string("walls"))},
                           {"surfaces", json_value(std::move(surfaces))}};
    return {{"geometry", json_value(JsonValue::Array{json_value(std::move(room))})},
            {"materials", json_value(planned.materials)}};
}

/// Replaces materials of a scene by those of the plan.
void replace_materials(Scene& scene, const PlannedScene& planned, const std::string& file) {
    for (const JsonMember& member : planned.materials) {
        const auto found = std::find_if(scene.materials.begin(), scene.materials.end(),
                                        [&](const Material& m) { return m.name == member.key; });
        if (found == scene.materials.end())
            throw InputError(file, "", "has no material " + quoted(member.key));
        *found = read_material(member.key, JsonReader(member.value, file));
    }
}

JsonValue pose_json(const PlannedPose& pose) {
    return json_value(JsonValue::Object{{"position", json_value(pose.position)},
                                        {"yaw_deg", json_value(pose.yaw_deg)},
                                        {"pitch_deg", json_value(pose.pitch_deg)}});
}

template <typename T>
T contents_of(const JsonReader& json) {
    const T* const contents = std::get_if<T>(&json.value().value);
    if (contents == nullptr) json.fail("is of another type; expected a line of a plan");
    return *contents;
}

/// {"box": [x, y, z]} or {"file": NAME, "sha256": HASH}.
JsonValue::Object read_room(const JsonReader& json) {
    constexpr const char* kRoom = "a box or a scene file with its hash";
    constexpr NumberRange kEdge_m{0, 1000, false, "metres above 0, at most 1000"};
    constexpr std::size_t kLongestName = 4096;  // PATH_MAX
    if (const auto box = json.find("box")) {
        json.allow_keys({"box"});
        const std::vector<JsonReader> edges = box->items(kRoom);
        if (edges.size() != 3) box->fail(std::string("expected ") + kRoom);
        for (const JsonReader& edge : edges) edge.number(kEdge_m);
    } else {
        json.allow_keys({"file", "sha256"});
        const JsonReader file = json.require("file", kRoom);
        const std::string name = file.string(kRoom);
        if (name.empty() || name.size() > kLongestName) file.fail(std::string("expected ") + kRoom);
        const JsonReader hash = json.require("sha256", kRoom);
        if (!is_sha256(hash.string(kRoom))) hash.fail(std::string("expected ") + kRoom);
    }
    return std::get<JsonValue::Object>(json.value().value);
}

}  // namespace

std::optional<std::array<double, 3>> PlannedScene::box_m() const {
    const JsonValue* const box = find_member(geometry, "box");
    if (box == nullptr) return std::nullopt;
    const std::string name = "box";
    const std::vector<JsonReader> edges = JsonReader(*box, name).items("a box");
    return std::array{edges.at(0).number({}), edges.at(1).number({}), edges.at(2).number({})};
}

PlannedPose read_pose(const JsonReader& json) {
    constexpr NumberRange kAngle{-360, 360, true, "degrees"};
    PlannedPose pose;
    pose.position = read_point(json.require("position", "a position"));
    pose.yaw_deg = json.require("yaw_deg", kAngle.expected).number(kAngle);
    pose.pitch_deg = json.require("pitch_deg", kAngle.expected).number(kAngle);
    return pose;
}

std::string scene_line(const PlannedScene& scene) {
    JsonValue::Object line{
        {"scene", json_value(scene.index)},       {"first_item", json_value(scene.first_item)},
        {"items", json_value(scene.items)},       {"seed", json_value(scene.seed)},
        {"geometry", json_value(scene.geometry)}, {"materials", json_value(scene.materials)}};
    if (!scene.error.empty()) {
        line.push_back({"error", json_value(scene.error)});
        return json_line(json_value(std::move(line)));
    }
    JsonValue::Array receivers;
    for (const PlannedPose& receiver : scene.receivers) receivers.push_back(pose_json(receiver));
    line.push_back({"sources", json_value(scene.sources)});
    line.push_back({"receivers", json_value(std::move(receivers))});
    return json_line(json_value(std::move(line)));
}

PlannedScene read_scene_line(const std::string& line, const std::string& name) {
    constexpr const char* kLine = "a member of a line of a plan";
    const JsonValue value = parse_json(line, name);
    const JsonReader json(value, name);
    PlannedScene scene;
    scene.index = json.require("scene", kLine).unsigned_integer();
    scene.first_item = json.require("first_item", kLine).unsigned_integer();
    scene.items = json.require("items", kLine).unsigned_integer();
    scene.seed = json.require("seed", kLine).unsigned_integer();
    if (scene.items < 1 || scene.items > kMostPairs)
        json.fail(std::to_string(scene.items) + " items; expected 1 to " +
                  std::to_string(kMostPairs));
    scene.geometry = read_room(json.require("geometry", kLine));
    scene.materials = contents_of<JsonValue::Object>(json.require("materials", kLine));
    json.read("error", [&](const JsonReader& x) { scene.error = x.string(kLine); });
    if (!scene.error.empty()) return scene;
    const JsonReader sources = json.require("sources", kLine);
    for (const JsonReader& source : sources.items(kLine)) read_pose(source);
    scene.sources = contents_of<JsonValue::Array>(sources);
    for (const JsonReader& item : json.require("receivers", kLine).items(kLine))
        scene.receivers.push_back(read_pose(item));
    if (scene.items != scene.sources.size() * scene.receivers.size())
        json.fail(std::to_string(scene.sources.size()) + " sources and " +
                  std::to_string(scene.receivers.size()) + " receivers; expected " +
                  std::to_string(scene.items) + " pairs, the number of items");
    return scene;
}

std::shared_ptr<const SceneFiles::File> SceneFiles::read(const std::string& name) {
    const std::lock_guard lock(mutex_);
    const auto found = files_.find(name);
    if (found != files_.end()) return found->second;
    if (files_.size() == kKeptFiles) files_.clear();
    // Sources are replaced; their files may be absent or have other paths elsewhere.
    File file{load_scene(folder_ / name, SignalFiles::optional).scene, {}};
    file.scene.sources.clear();
    file.sha256 = scene_hash(file.scene);
    return files_[name] = std::make_shared<const File>(std::move(file));
}

Scene build_scene(const PlannedScene& planned, const DatasetSettings& settings, SceneFiles& files) {
    const std::string name = "scene " + std::to_string(planned.index);
    JsonValue::Object root{{"aula", json_value(std::uint64_t{1})},
                           {"sources", json_value(planned.sources)},
                           {"listener", pose_json(planned.receivers.at(0))}};
    const JsonValue* const file = find_member(planned.geometry, "file");
    if (file == nullptr)
        for (JsonMember& member : box_members(planned)) root.push_back(std::move(member));
    // The reader of scene files also checks the plan.
    Scene scene = parse_scene(json_line(json_value(std::move(root))), name, "").scene;
    if (file != nullptr) {
        const JsonValue geometry = json_value(planned.geometry);
        const JsonReader json(geometry, name);
        const std::string path = json.require("file", "a scene file").string("a scene file");
        const auto base = files.read(path);
        if (base->sha256 != json.require("sha256", "a hash").string("a hash"))
            throw InputError(path, "", "has changed since the plan; expected its content then");
        Scene placed = base->scene;
        placed.sources = std::move(scene.sources);
        placed.listener = scene.listener;
        replace_materials(placed, planned, path);
        scene = std::move(placed);
    }
    scene.simulation = settings.simulation;
    scene.simulation.seed = planned.seed;
    return scene;
}

std::string scene_hash(const Scene& scene) { return sha256(scene_state(scene, false)); }

std::vector<Pose> microphone_poses(const PlannedScene& planned, const DatasetSettings& settings) {
    std::vector<Pose> poses;
    for (const PlannedPose& receiver : planned.receivers) {
        const Pose pose = receiver.pose();
        for (const Vec3& microphone : settings.array) {
            poses.push_back(pose);
            poses.back().position += pose.rotation() * microphone;
        }
    }
    return poses;
}

}  // namespace aula
