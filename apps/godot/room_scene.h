#pragma once

#include <aula.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "apps/godot/room_geometry.h"

namespace aula::godot {

/// What failed, in one line.
struct RoomError {
    std::string message;
};

struct DestroyScene {
    void operator()(aula_scene* scene) const { aula_scene_destroy(scene); }
};
using SceneHandle = std::unique_ptr<aula_scene, DestroyScene>;
/// With aula_room_destroy(). The room and the thread that gives it another scene share it.
using RoomHandle = std::shared_ptr<aula_room>;

/// Throws RoomError with the library's message unless `result` is AULA_OK.
void require(int result);

/// An object of a room that follows a body.
struct MovingObject {
    std::size_t object = 0;
    std::uint64_t body = 0;
    Transform at_rest;               ///< rigid transform of the body for which the mesh is given
    std::array<float, 12> motion{};  ///< the newest in the room; zeros: unknown
    std::string error;               ///< of the newest motion
};

/// The scene of a geometry, and its moving objects. Throws RoomError.
SceneHandle make_scene(const RoomGeometry& geometry, const Transform& room_frame,
                       std::vector<MovingObject>& moving);

/// A source as a scene file has it.
struct SavedSource {
    std::string name, directivity, signal;
    aula_pose pose{};
    double gain_db = 0;
    bool loop = false;
};

/// Writes a scene file. Numbers that are 0 in `rays` and `ir_length_s` are left out. Throws
/// RoomError.
void save_scene(const std::string& file, const RoomGeometry& geometry,
                const std::vector<SavedSource>& sources, const aula_pose& listener, int rays,
                double ir_length_s);

}  // namespace aula::godot
