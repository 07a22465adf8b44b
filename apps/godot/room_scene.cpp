#include "apps/godot/room_scene.h"

#include <cstddef>
#include <fstream>
#include <nlohmann/json.hpp>

namespace aula::godot {
namespace {

using nlohmann::json;

/// Of the octaves, `fallback` for all if there is none.
std::vector<float> octaves(const RoomMaterial& material, const char* property,
                           const std::vector<float>& values, float fallback) {
    if (values.empty()) return std::vector<float>(AULA_BANDS, fallback);
    if (values.size() != AULA_BANDS)
        throw RoomError{std::string("the ") + property + " of " + material.name + " has " +
                        std::to_string(values.size()) +
                        " values; expected 8, for the octaves from 63 Hz to 8 kHz"};
    return values;
}

/// Absorption of a material without it, as of painted walls, and its scattering.
constexpr float kAbsorption = 0.1F, kScattering = 0.1F;

json pose_json(const aula_pose& pose) {
    constexpr double kDegrees = 180 / 3.14159265358979323846;
    return {{"position", {pose.position[0], pose.position[1], pose.position[2]}},
            {"yaw_deg", kDegrees * static_cast<double>(pose.yaw_rad)},
            {"pitch_deg", kDegrees * static_cast<double>(pose.pitch_rad)},
            {"roll_deg", kDegrees * static_cast<double>(pose.roll_rad)}};
}

json mesh_json(const RoomMesh& mesh) {
    json vertices = json::array(), faces = json::array();
    for (std::size_t i = 0; i < mesh.vertices.size(); i += 3)
        vertices.push_back({mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]});
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
        // The reader of scene files begins a triangle with its last corner: it is then the same.
        faces.push_back({mesh.triangles[i + 1], mesh.triangles[i + 2], mesh.triangles[i]});
    json object{{"name", mesh.name},
                {"material", mesh.material},
                {"vertices", std::move(vertices)},
                {"faces", std::move(faces)}};
    if (mesh.body != 0) object["path"] = {{"points", {{{"t", 0}, {"position", {0, 0, 0}}}}}};
    return object;
}

}  // namespace

void require(int result) {
    if (result != AULA_OK) throw RoomError{aula_message()};
}

SceneHandle make_scene(const RoomGeometry& geometry, const Transform& room_frame,
                       std::vector<MovingObject>& moving) {
    aula_scene* created = nullptr;
    require(aula_scene_create(&created));
    SceneHandle scene(created);
    for (const RoomMaterial& material : geometry.materials) {
        const auto absorption = octaves(material, "absorption", material.absorption, kAbsorption);
        const auto scattering = octaves(material, "scattering", material.scattering, kScattering);
        const auto reduction =
            octaves(material, "sound_reduction_db", material.sound_reduction_db, 0);
        require(aula_scene_add_material(
            scene.get(), material.name.c_str(), absorption.data(), scattering.data(),
            material.sound_reduction_db.empty() ? nullptr : reduction.data()));
    }
    for (const RoomMesh& mesh : geometry.meshes) {
        MovingObject added;
        require(aula_scene_add_object(scene.get(), mesh.name.c_str(), mesh.vertices.data(),
                                      mesh.vertices.size() / 3, mesh.triangles.data(),
                                      mesh.triangles.size() / 3, mesh.material.c_str(),
                                      mesh.body != 0, &added.object));
        if (mesh.body == 0) continue;
        added.body = mesh.body;
        added.at_rest = relative(rigid(global_transform(Object::of_id(mesh.body))), room_frame);
        added.motion = motion(added.at_rest, added.at_rest);
        moving.push_back(added);
    }
    return scene;
}

void save_scene(const std::string& file, const RoomGeometry& geometry,
                const std::vector<SavedSource>& sources, const aula_pose& listener, int rays,
                double ir_length_s) {
    json scene{{"aula", 1},
               {"geometry", json::array()},
               {"materials", json::object()},
               {"sources", json::array()},
               {"listener", pose_json(listener)},
               {"simulation", json::object()}};
    for (const RoomMesh& mesh : geometry.meshes) scene["geometry"].push_back(mesh_json(mesh));
    for (const RoomMaterial& material : geometry.materials) {
        json& saved = scene["materials"][material.name];
        saved["absorption"] = octaves(material, "absorption", material.absorption, kAbsorption);
        saved["scattering"] = octaves(material, "scattering", material.scattering, kScattering);
        if (!material.sound_reduction_db.empty())
            saved["sound_reduction_db"] =
                octaves(material, "sound_reduction_db", material.sound_reduction_db, 0);
    }
    for (const SavedSource& source : sources) {
        json saved = pose_json(source.pose);
        saved["name"] = source.name;
        saved["directivity"] = source.directivity;
        saved["gain_db"] = source.gain_db;
        saved["loop"] = source.loop;
        if (!source.signal.empty()) saved["signal"] = source.signal;
        scene["sources"].push_back(std::move(saved));
    }
    if (rays != 0) scene["simulation"]["rays"] = rays;
    if (ir_length_s != 0) scene["simulation"]["ir_length_s"] = ir_length_s;
    std::ofstream out(file);
    out << scene.dump(1, ' ', false, json::error_handler_t::replace) << '\n';
    if (!out.flush()) throw RoomError{"cannot write " + file};
}

}  // namespace aula::godot
