#include "aula/engine/axes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace aula {

namespace {

/// Orthonormal; its columns are the host's axes in Aula's.
glm::mat3 to_aula(Axes axes) {
    switch (axes) {
        case Axes::z_up:
            break;
        case Axes::y_up:
            return {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0, -1, 0)};
        case Axes::y_up_left_handed:
            return {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0, 1, 0)};
        case Axes::z_up_left_handed:
            return {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1)};
    }
    return glm::mat3(1);
}

}  // namespace

Vec3 from_axes(Axes axes, const Vec3& v) { return to_aula(axes) * v; }

Vec3 to_axes(Axes axes, const Vec3& v) { return glm::transpose(to_aula(axes)) * v; }

RigidTransform from_axes(Axes axes, const RigidTransform& transform) {
    const glm::mat3 m = to_aula(axes);
    return {m * transform.rotation * glm::transpose(m), m * transform.translation};
}

Pose pose_looking(const Vec3& position, const Vec3& front, const Vec3& up) {
    Pose pose;
    pose.position = position;
    const Vec3 x = glm::normalize(front);
    const auto angle = [](float sine, float cosine) {
        return static_cast<float>(std::atan2(double{sine}, double{cosine}));
    };
    pose.pitch_rad = static_cast<float>(std::asin(std::clamp(double{x.z}, -1.0, 1.0)));
    // For a vertical view direction the yaw is that of the top of the head.
    const bool upright = x.x != 0 || x.y != 0;
    pose.yaw_rad = upright ? angle(x.y, x.x) : angle(-x.z * up.y, -x.z * up.x);
    const glm::mat3 level = pose.rotation();
    pose.roll_rad = angle(-glm::dot(up, level[1]), glm::dot(up, level[2]));
    return pose;
}

}  // namespace aula
