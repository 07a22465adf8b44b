#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/godot/body_node.h"
#include "apps/godot/sound/axes.h"

namespace aula::godot {

/// The triangles of a surface, in the axes of Aula and the frame of the room.
struct RoomMesh {
    std::string name;  ///< the node's path and the number of the surface
    std::string material;
    std::vector<float> vertices;           ///< 3 coordinates each, m
    std::vector<std::uint32_t> triangles;  ///< 3 indices each
    std::uint64_t body = 0;                ///< id of the BodyNode that moves it; 0: none
};

/// A material with values of its own.
struct RoomMaterial {
    std::string name;
    std::vector<float> absorption, scattering, sound_reduction_db;
};

/// The nodes below an AulaRoom.
struct RoomGeometry {
    std::vector<RoomMesh> meshes;
    std::vector<RoomMaterial> materials;
};

/// The transform of a Node3D in the world.
Transform global_transform(Object node);

/// Collects the meshes below a room. Their material is that of the nearest body above them, else
/// the one that ships of the name of the surface's Godot material, else `material`, else plaster.
/// [main thread]
RoomGeometry collect_geometry(Object room, const MaterialResource* material);

}  // namespace aula::godot
