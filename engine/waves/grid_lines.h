#pragma once

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <span>
#include <vector>

#include "aula/engine/vec3.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// The planes of a grid, perpendicular to three axes along the main normals of a scene. The large
/// walls that are perpendicular to an axis lie in planes of the grid.
class GridLines {
 public:
    /// For the part of a scene around points of the world and one cell beyond, with cells of at
    /// most `cell_m`.
    GridLines(const RayScene& scene, std::span<const Vec3> points, float cell_m);

    Vec3 to_grid(const Vec3& world) const { return glm::transpose(axes_) * world; }
    Vec3 to_world(const Vec3& grid) const { return axes_ * grid; }
    /// A column for each axis of the grid, in world coordinates.
    const glm::mat3& axes() const { return axes_; }

    /// The positions of the planes across an axis, ascending, at least two.
    const std::vector<float>& planes(int axis) const {
        return planes_[static_cast<std::size_t>(axis)];
    }
    std::size_t cells(int axis) const { return planes(axis).size() - 1; }

 private:
    glm::mat3 axes_{1};
    std::array<std::vector<float>, 3> planes_;
};

}  // namespace aula
