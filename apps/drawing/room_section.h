#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// Where a plane cuts the surfaces of a room.
struct RoomSection {
    std::vector<std::array<glm::vec2, 2>> walls;  ///< lines of the cut, m, world axes
    glm::vec2 min{0};                             ///< bounds of the whole room, m
    glm::vec2 max{0};
};

/// The plan at the height `z_m`, in x and y. A surface in the plane itself does not belong to it.
RoomSection floor_plan(const RayScene& scene, float z_m);

/// The same of the upright plane at `y_m`, in x and z.
RoomSection side_view(const RayScene& scene, float y_m);

}  // namespace aula
