#include "apps/dataset/plan/scene_drawing.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "apps/dataset/base/json_values.h"
#include "aula/exception.h"
#include "engine/base/mix64.h"
#include "engine/input/names.h"

namespace aula {

namespace {

/// The seed of a scene, exact in a double.
std::uint64_t scene_seed(std::uint64_t seed, std::uint64_t index) {
    return mix64(mix64(seed) + index) >> 11U;
}

/// A material as in a scene file. The remark "source" is the name of one that ships.
JsonValue material_json(const Material& material) {
    JsonValue::Object json{{"absorption", json_value(material.absorption)},
                           {"scattering", json_value(material.scattering)}};
    if (material.sound_reduction_db)
        json.push_back({"sound_reduction_db", json_value(*material.sound_reduction_db)});
    if (!material.name.empty()) json.push_back({"source", json_value(material.name)});
    return json_value(std::move(json));
}

JsonValue source_json(const std::string& name, const PlannedPose& pose,
                      const std::string& directivity) {
    return json_value(JsonValue::Object{{"name", json_value(name)},
                                        {"position", json_value(pose.position)},
                                        {"yaw_deg", json_value(pose.yaw_deg)},
                                        {"pitch_deg", json_value(pose.pitch_deg)},
                                        {"directivity", json_value(directivity)}});
}

}  // namespace

SceneDrawing::SceneDrawing(const Manifest& manifest)
    : manifest_(manifest), files_(manifest.file.parent_path()) {}

RoomSpace SceneDrawing::draw_box(const BoxRooms& rooms, PlannedScene& scene,
                                 RandomStream& random) const {
    Vec3 size_m(0);
    for (int axis = 0; axis < 3; ++axis)
        size_m[axis] =
            static_cast<float>(rooms.size_m[static_cast<std::size_t>(axis)].draw(random));
    scene.geometry = {{"box", json_value(size_m)}};
    const Material walls = rooms.walls.draw(random);
    scene.materials = {
        {"walls", material_json(walls)},
        {"floor", material_json(rooms.floor ? rooms.floor->draw(random) : walls)},
        {"ceiling", material_json(rooms.ceiling ? rooms.ceiling->draw(random) : walls)}};
    return RoomSpace(size_m);
}

const RoomSpace& SceneDrawing::draw_file(const SceneRooms& rooms, PlannedScene& scene,
                                         RandomStream& random) {
    const std::string& name = rooms.files.draw(random);
    auto room = rooms_.find({&rooms, name});
    if (room == rooms_.end()) {
        const auto file = files_.read(name);
        for (const auto& replaced : rooms.materials)
            if (std::none_of(file->scene.materials.begin(), file->scene.materials.end(),
                             [&](const Material& m) { return m.name == replaced.first; }))
                throw InputError(manifest_.file.string(), "",
                                 name + " has no material " + quoted(replaced.first) +
                                     "; expected the names of its materials");
        room = rooms_
                   .emplace(std::pair(&rooms, name),
                            FileRoom{file->sha256, RoomSpace(file->scene, rooms.region)})
                   .first;
    }
    scene.geometry = {{"file", json_value(name)}, {"sha256", json_value(room->second.sha256)}};
    for (const auto& [material, distribution] : rooms.materials)
        scene.materials.push_back({material, material_json(distribution.draw(random))});
    return room->second.space;
}

PlannedScene SceneDrawing::draw(std::uint64_t index) {
    PlannedScene scene;
    scene.index = index;
    scene.seed = scene_seed(manifest_.settings.seed, index);
    RandomStream random(scene.seed);
    std::uint64_t in_group = index;
    auto group = manifest_.groups.begin();
    for (; in_group >= group->count; ++group) in_group -= group->count;
    const auto sources = static_cast<std::size_t>(manifest_.sources.count.draw(random));
    const auto receivers = static_cast<std::size_t>(manifest_.receivers.count.draw(random));
    const auto source_steps = static_cast<std::size_t>(manifest_.sources.steps());
    scene.items =
        sources * source_steps * receivers * static_cast<std::size_t>(manifest_.receivers.steps());

    const auto* const boxes = std::get_if<BoxRooms>(&group->rooms);
    std::optional<RoomSpace> box;
    if (boxes != nullptr) box = draw_box(*boxes, scene, random);
    const RoomSpace& space =
        box ? *box : draw_file(std::get<SceneRooms>(group->rooms), scene, random);
    constexpr std::array<Vec3, 1> kPoint{Vec3(0)};
    try {
        const std::vector<PlannedPose> placed =
            space.draw_poses(manifest_.sources, sources, kPoint, {}, random);
        for (std::size_t s = 0; s < sources; ++s) {
            const std::string& directivity = manifest_.directivity.draw(random);
            const std::string name = "source-" + std::to_string(s);
            for (std::size_t step = 0; step < source_steps; ++step)
                scene.sources.push_back(source_json(
                    manifest_.sources.walk ? name + "-step-" + std::to_string(step) : name,
                    placed[s * source_steps + step], directivity));
        }
        scene.receivers = space.draw_poses(manifest_.receivers, receivers, manifest_.settings.array,
                                           placed, random);
    } catch (const InputError& error) {
        scene.error = error.what();
    }
    return scene;
}

}  // namespace aula
