#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// Where a horizontal plane cuts the surfaces of a room.
struct FloorPlan {
    std::vector<std::array<glm::vec2, 2>> walls;  ///< lines of the cut, m, world axes
    glm::vec2 min{0};                             ///< bounds of the whole room, m
    glm::vec2 max{0};
};

/// The plan at the height `z_m`. A surface in the plane itself does not belong to it.
FloorPlan floor_plan(const RayScene& scene, float z_m);

}  // namespace aula
