#include "apps/window/view/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

namespace aula {

namespace {

constexpr float kNear_m = 0.05F;
constexpr float kFar_m = 3000;
constexpr float kHeight_rad = 0.9F;             ///< vertical field of view of the orbit camera
constexpr float kFirstPersonHeight_rad = 1.2F;  ///< vertical field of view in first person

Vec3 direction_of(float yaw_rad, float pitch_rad) {
    return {std::cos(pitch_rad) * std::cos(yaw_rad), std::cos(pitch_rad) * std::sin(yaw_rad),
            std::sin(pitch_rad)};
}

}  // namespace

Camera Camera::around(const Vec3& low, const Vec3& high) {
    Camera camera;
    camera.target = (low + high) * 0.5F;
    camera.distance_m = std::max(1.0F, 1.12F * glm::distance(low, high));
    // From a corner along the longer side.
    const Vec3 size = high - low;
    camera.yaw_rad = size.x > size.y ? -2.0F : -2.6F;
    return camera;
}

void Camera::turn(float yaw_step_rad, float pitch_step_rad) {
    yaw_rad += yaw_step_rad;
    pitch_rad = std::clamp(pitch_rad + pitch_step_rad, -1.55F, 1.55F);
}

void Camera::zoom(float factor) { distance_m = std::clamp(distance_m * factor, 0.3F, 2000.0F); }

void Camera::pan(float right, float up) {
    const Vec3 away = direction_of(yaw_rad, pitch_rad);
    const Vec3 to_right = glm::normalize(glm::cross(Vec3(0, 0, 1), away));
    const Vec3 to_up = glm::cross(away, to_right);
    const float height_m = 2 * distance_m * std::tan(kHeight_rad / 2);
    target += height_m * (right * to_right + up * to_up);
}

Vec3 Camera::eye(const Pose& listener) const {
    if (first_person) return listener.position;
    return target + distance_m * direction_of(yaw_rad, pitch_rad);
}

glm::mat4 Camera::view(const Pose& listener) const {
    if (first_person) {
        const glm::mat3 axes = listener.rotation();
        return glm::lookAt(listener.position, listener.position + axes[0], axes[2]);
    }
    return glm::lookAt(eye(listener), target, Vec3(0, 0, 1));
}

glm::mat4 Camera::projection(float aspect) const {
    return glm::perspective(first_person ? kFirstPersonHeight_rad : kHeight_rad, aspect, kNear_m,
                            kFar_m);
}

Screen::Screen(const Camera& camera, const Pose& listener, glm::vec2 corner, glm::vec2 size)
    : eye_(camera.eye(listener)), corner_(corner), size_(size) {
    const glm::mat4 view = camera.view(listener);
    matrix_ = camera.projection(size.x / std::max(1.0F, size.y)) * view;
    right_ = {view[0][0], view[1][0], view[2][0]};
}

std::optional<glm::vec2> Screen::project(const Vec3& point) const {
    const glm::vec4 clip = matrix_ * glm::vec4(point, 1);
    if (clip.w < kNear_m) return std::nullopt;
    return corner_ +
           size_ * glm::vec2(0.5F + 0.5F * clip.x / clip.w, 0.5F - 0.5F * clip.y / clip.w);
}

float Screen::pixels_per_metre(const Vec3& point) const {
    const auto here = project(point);
    const auto beside = project(point + right_ * 0.1F);
    return here && beside ? glm::distance(*here, *beside) * 10 : 0;
}

Ray Screen::ray(glm::vec2 pixel) const {
    const glm::vec2 relative = (pixel - corner_) / size_;
    const glm::vec4 far =
        glm::inverse(matrix_) * glm::vec4(2 * relative.x - 1, 1 - 2 * relative.y, 0.5F, 1);
    return {eye_, glm::normalize(Vec3(far) / far.w - eye_)};
}

}  // namespace aula
