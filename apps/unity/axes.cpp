#include "apps/unity/axes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace aula::unity {
namespace {

using Vector = std::array<float, 3>;

float dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector normalized(const Vector& v) {
    const float length = std::sqrt(dot(v, v));
    return {v[0] / length, v[1] / length, v[2] / length};
}

Vector column(const float (&matrix)[16], int c) {
    return {matrix[4 * c], matrix[4 * c + 1], matrix[4 * c + 2]};
}

/// The same in the axes of Aula.
Vector to_aula(const Vector& v) { return {v[2], -v[0], v[1]}; }

/// Of axes of the engine, of any length. Without a direction there is no turn.
aula_pose pose_of(const Vector& position, const Vector& right, const Vector& front) {
    const Vector at = to_aula(position);
    aula_pose pose{{at[0], at[1], at[2]}, 0, 0, 0};
    const Vector view = to_aula(normalized(front));
    const Vector ear = to_aula(normalized(right));
    if (!std::isfinite(dot(view, ear))) return pose;
    pose.yaw_rad = std::atan2(view[1], view[0]);
    pose.pitch_rad = std::asin(std::clamp(view[2], -1.0F, 1.0F));
    // Without roll the right is horizontal; roll lowers it.
    const Vector level{std::sin(pose.yaw_rad), -std::cos(pose.yaw_rad), 0};
    pose.roll_rad = std::atan2(dot(ear, cross(view, level)), dot(ear, level));
    return pose;
}

}  // namespace

aula_pose pose_to_world(const float (&matrix)[16]) {
    return pose_of(column(matrix, 3), column(matrix, 0), column(matrix, 2));
}

aula_pose pose_from_world(const float (&matrix)[16]) {
    const Vector x = column(matrix, 0), y = column(matrix, 1), z = column(matrix, 2);
    // Columns of the inverse, by Cramer's rule, are the axes in the world.
    const Vector yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
    const float volume = dot(x, yz);
    const auto axis = [&](std::size_t i) {
        return Vector{yz[i] / volume, zx[i] / volume, xy[i] / volume};
    };
    const Vector right = axis(0), up = axis(1), front = axis(2);
    const Vector offset = column(matrix, 3);
    Vector position;
    for (std::size_t i = 0; i < 3; ++i)
        position[i] = -(right[i] * offset[0] + up[i] * offset[1] + front[i] * offset[2]);
    return pose_of(position, right, front);
}

}  // namespace aula::unity
