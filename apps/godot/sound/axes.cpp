#include "apps/godot/sound/axes.h"

#include <algorithm>
#include <cmath>

namespace aula::godot {
namespace {

float dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// a - factor * b.
Vector minus(const Vector& a, float factor, const Vector& b) {
    return {a[0] - factor * b[0], a[1] - factor * b[1], a[2] - factor * b[2]};
}

Vector column(const Transform& transform, std::size_t c) {
    return {transform.rows[0][c], transform.rows[1][c], transform.rows[2][c]};
}

}  // namespace

Vector Transform::operator()(const Vector& point) const {
    return {dot(rows[0], point) + origin[0], dot(rows[1], point) + origin[1],
            dot(rows[2], point) + origin[2]};
}

Transform rigid(const Transform& transform) {
    Vector x = column(transform, 0), y = column(transform, 1);
    const float x_length = std::sqrt(dot(x, x));
    x = {x[0] / x_length, x[1] / x_length, x[2] / x_length};
    y = minus(y, dot(x, y), x);
    const float y_length = std::sqrt(dot(y, y));
    y = {y[0] / y_length, y[1] / y_length, y[2] / y_length};
    const Vector z = cross(x, y);
    Transform result;
    result.origin = transform.origin;
    if (!std::isfinite(dot(z, z))) return result;
    for (std::size_t r = 0; r < 3; ++r) result.rows[r] = {x[r], y[r], z[r]};
    return result;
}

Transform relative(const Transform& inner, const Transform& rigid_outer) {
    Transform result;
    const Vector offset = minus(inner.origin, 1, rigid_outer.origin);
    for (std::size_t r = 0; r < 3; ++r) {
        const Vector axis = column(rigid_outer, r);
        for (std::size_t c = 0; c < 3; ++c) result.rows[r][c] = dot(axis, column(inner, c));
        result.origin[r] = dot(axis, offset);
    }
    return result;
}

Vector to_aula(const Vector& vector) { return {vector[0], -vector[2], vector[1]}; }

aula_pose pose_of(const Transform& rigid_transform) {
    const Vector back = to_aula(column(rigid_transform, 2));
    const Vector right = to_aula(column(rigid_transform, 0));
    const Vector position = to_aula(rigid_transform.origin);
    const Vector front{-back[0], -back[1], -back[2]};
    const float yaw = std::atan2(front[1], front[0]);
    // Without roll the right is horizontal; roll lowers it.
    const Vector level_right{std::sin(yaw), -std::cos(yaw), 0};
    const Vector bottom = cross(front, level_right);
    return {{position[0], position[1], position[2]},
            yaw,
            std::asin(std::clamp(front[2], -1.0F, 1.0F)),
            std::atan2(dot(right, bottom), dot(right, level_right))};
}

std::array<float, 12> motion(const Transform& rigid_from, const Transform& rigid_to) {
    const Transform inverse = relative(Transform{}, rigid_from);
    Transform moved;
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c)
            moved.rows[r][c] = dot(rigid_to.rows[r], column(inverse, c));
    const Vector right = to_aula(column(moved, 0));
    const Vector up = to_aula(column(moved, 1));
    const Vector back = to_aula(column(moved, 2));
    const Vector position = to_aula(rigid_to(inverse.origin));
    std::array<float, 12> rows{};
    for (std::size_t r = 0; r < 3; ++r) {
        rows[4 * r] = right[r];
        rows[4 * r + 1] = -back[r];
        rows[4 * r + 2] = up[r];
        rows[4 * r + 3] = position[r];
    }
    return rows;
}

}  // namespace aula::godot
