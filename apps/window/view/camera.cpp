#include "apps/window/view/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

namespace aula {

namespace {

constexpr float kNear_m = 0.05F;                ///< to the near plane, at least
constexpr float kNearest_m = 0.3F;              ///< from the target of the orbit camera
constexpr float kHeight_rad = 0.9F;             ///< vertical field of view of the orbit camera
constexpr float kFirstPersonHeight_rad = 1.2F;  ///< vertical field of view in first person

Vec3 direction_of(float yaw_rad, float pitch_rad) {
    return {std::cos(pitch_rad) * std::cos(yaw_rad), std::cos(pitch_rad) * std::sin(yaw_rad),
            std::sin(pitch_rad)};
}

}  // namespace

void Camera::surround(std::span<const Vec3> points) {
    // Lines of rays, lobes and moving objects reach somewhat beyond the room.
    constexpr float kMargin = 1.5F;
    constexpr float kMargin_m = 1;
    if (points.empty()) return;
    Bounds bounds;
    bounds.add(points);
    centre = 0.5F * (bounds.min + bounds.max);
    radius_m = kMargin * 0.5F * bounds.diagonal_m() + kMargin_m;
}

void Camera::show(std::span<const Vec3> points, float width, float height) {
    constexpr float kFilled = 0.9F;  // of the image; names of sources stand beside the room
    if (points.empty() || !(width > 0 && height > 0)) return;
    const Vec3 away = direction_of(yaw_rad, pitch_rad);
    const Vec3 right = glm::normalize(glm::cross(Vec3(0, 0, 1), away));
    const Vec3 up = glm::cross(away, right);
    const float half_height = kFilled * std::tan(kHeight_rad / 2);
    const float half_width = half_height * width / height;
    // A point is in the image if its distance across the line of sight is at most half_width times
    // that along it. Both sides together are tightest for the greatest sums below.
    Vec3 high(-std::numeric_limits<float>::infinity());  // right, up, away
    Vec3 low = high;
    for (const Vec3& point : points) {
        const float along = glm::dot(point, away);
        const float x = glm::dot(point, right) / half_width;
        const float y = glm::dot(point, up) / half_height;
        high = glm::max(high, Vec3(x + along, y + along, along));
        low = glm::max(low, Vec3(along - x, along - y, -along));
    }
    const float middle = 0.5F * (high.z - low.z);
    target = 0.5F * half_width * (high.x - low.x) * right +
             0.5F * half_height * (high.y - low.y) * up + middle * away;
    distance_m =
        std::max({kNearest_m, 0.5F * (high.x + low.x) - middle, 0.5F * (high.y + low.y) - middle});
}

void Camera::turn(float yaw_step_rad, float pitch_step_rad) {
    yaw_rad += yaw_step_rad;
    pitch_rad = std::clamp(pitch_rad + pitch_step_rad, -1.55F, 1.55F);
}

void Camera::zoom(float factor) {
    constexpr float kFarthest = 20;  // radii: the room fills a tenth of the picture's height
    distance_m = std::clamp(distance_m * factor, kNearest_m, kFarthest * radius_m);
}

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

glm::mat4 Camera::projection(const Pose& listener, float aspect) const {
    const float to_centre_m = glm::distance(eye(listener), centre);
    return glm::perspective(first_person ? kFirstPersonHeight_rad : kHeight_rad, aspect,
                            std::max(kNear_m, to_centre_m - radius_m), to_centre_m + radius_m);
}

std::optional<Vec3> on_level(const Ray& ray, float z) {
    if (std::abs(ray.direction.z) < 0.02F) return std::nullopt;
    const float distance = (z - ray.origin.z) / ray.direction.z;
    if (distance <= 0) return std::nullopt;
    return ray.origin + distance * ray.direction;
}

Screen::Screen(const Camera& camera, const Pose& listener, glm::vec2 corner, glm::vec2 size)
    : eye_(camera.eye(listener)), corner_(corner), size_(size) {
    const glm::mat4 view = camera.view(listener);
    matrix_ = camera.projection(listener, size.x / std::max(1.0F, size.y)) * view;
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
