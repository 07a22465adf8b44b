#include "apps/room/remote/head_tracker.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

#include "aula/engine/scene.h"

namespace aula {

namespace {

std::optional<glm::quat> quaternion_of(const OscMessage& message) {
    const auto w = message.number(0);
    const auto x = message.number(1);
    const auto y = message.number(2);
    const auto z = message.number(3);
    if (!w || !x || !y || !z) return std::nullopt;
    constexpr double kShortest = 1e-6;
    const glm::dquat rotation(*w, *x, *y, *z);
    if (!(glm::length(rotation) > kShortest)) return std::nullopt;
    return glm::quat(glm::normalize(rotation));
}

std::optional<glm::mat3> rotation_of(const OscMessage& message) {
    if (message.address == "/SceneRotator/quaternions") {
        const auto quaternion = quaternion_of(message);
        return quaternion ? std::optional(glm::mat3_cast(*quaternion)) : std::nullopt;
    }
    if (message.address != "/SceneRotator/ypr" && message.address != "/ypr") return std::nullopt;
    const auto yaw_deg = message.number(0);
    const auto pitch_deg = message.number(1);
    const auto roll_deg = message.number(2);
    if (!yaw_deg || !pitch_deg || !roll_deg) return std::nullopt;
    constexpr double kDegree = std::numbers::pi / 180;
    return Pose{.yaw_rad = static_cast<float>(*yaw_deg * kDegree),
                .pitch_rad = static_cast<float>(-*pitch_deg * kDegree),
                .roll_rad = static_cast<float>(*roll_deg * kDegree)}
        .rotation();
}

/// Yaw, pitch and roll of a rotation: the inverse of Pose::rotation().
Vec3 angles_of(const glm::mat3& rotation) {
    const glm::dvec3 front = rotation[0];
    const glm::dvec3 left = rotation[1];
    const glm::dvec3 up = rotation[2];
    const double pitch_rad = std::asin(std::clamp(front.z, -1.0, 1.0));
    constexpr double kVertical = 1e-6;
    // Of a head that looks straight up or down only the sum of yaw and roll is known.
    if (std::hypot(front.x, front.y) < kVertical)
        return {std::atan2(-left.x, left.y), pitch_rad, 0};
    return {std::atan2(front.y, front.x), pitch_rad, std::atan2(left.z, up.z)};
}

}  // namespace

std::optional<Vec3> head_angles_rad(const OscMessage& message, bool inverted) {
    const auto rotation = rotation_of(message);
    if (!rotation) return std::nullopt;
    return angles_of(inverted ? glm::transpose(*rotation) : *rotation);
}

}  // namespace aula
