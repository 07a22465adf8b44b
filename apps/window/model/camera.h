#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "engine/rays/ray_scene.h"
#include "engine/scene/scene.h"

namespace aula {

/// From where the scene is looked at: around a point, or from the listener's eyes.
struct Camera {
    bool first_person = false;
    Vec3 target{0};
    float yaw_rad = -2.2F;   ///< direction from the target to the eye
    float pitch_rad = 0.8F;  ///< above the horizon
    float distance_m = 10;

    /// A place from which a box is seen as a whole.
    static Camera around(const Vec3& low, const Vec3& high);

    void turn(float yaw_step_rad, float pitch_step_rad);
    void zoom(float factor);
    /// Moves the target along the screen, by shares of its height.
    void pan(float right, float up);

    Vec3 eye(const Pose& listener) const;
    glm::mat4 view(const Pose& listener) const;
    glm::mat4 projection(float aspect) const;
};

/// A camera with a screen rectangle, in pixels from its upper left corner.
class Screen {
 public:
    Screen(const Camera& camera, const Pose& listener, glm::vec2 corner, glm::vec2 size);

    const glm::mat4& matrix() const { return matrix_; }
    const Vec3& eye() const { return eye_; }

    /// Where a point is seen; empty behind the eye.
    std::optional<glm::vec2> project(const Vec3& point) const;

    /// Pixels that a length has at a point.
    float pixels_per_metre(const Vec3& point) const;

    /// From the eye through a pixel.
    Ray ray(glm::vec2 pixel) const;

 private:
    glm::mat4 matrix_;
    Vec3 eye_;
    Vec3 right_;
    glm::vec2 corner_;
    glm::vec2 size_;
};

}  // namespace aula
