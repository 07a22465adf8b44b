#pragma once

#include <aula.h>

#include <array>

namespace aula::godot {

/// A vector of the engine: x to the right, y up, -z to the front.
using Vector = std::array<float, 3>;

/// A transform as the engine stores it (Transform3D): the rows of the matrix, and the origin.
struct Transform {
    std::array<Vector, 3> rows{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Vector origin{};

    Vector operator()(const Vector& point) const;
};

/// A rotation with the position and about the orientation of a transform, without its scale,
/// shear and mirroring; no rotation if the matrix has no inverse.
Transform rigid(const Transform& transform);

/// inner, relative to a rigid transform.
Transform relative(const Transform& inner, const Transform& rigid_outer);

/// The same point in the axes of Aula: (x, -z, y).
Vector to_aula(const Vector& vector);

/// The pose of a rigid transform whose -z is the front.
aula_pose pose_of(const Transform& rigid_transform);

/// What moves things from a rigid transform to another, as aula_room_set_transform() takes it.
std::array<float, 12> motion(const Transform& rigid_from, const Transform& rigid_to);

}  // namespace aula::godot
