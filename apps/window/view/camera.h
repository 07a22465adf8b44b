#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "aula/engine/scene.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// The view of the scene: an orbit camera around a target, or first person at the listener.
struct Camera {
    bool first_person = false;
    Vec3 target{0};
    float yaw_rad = -2.2F;   ///< azimuth of the eye from the target
    float pitch_rad = 0.8F;  ///< elevation of the eye from the target
    float distance_m = 10;
    /// A sphere around everything that is drawn, between whose near and far sides depth is
    /// resolved.
    Vec3 centre{0};
    float radius_m = 10;

    /// Sets the sphere around the points. Without points it does nothing.
    void surround(std::span<const Vec3> points);

    /// Changes target and distance so that the points fill an image of the given width and height,
    /// seen in the present direction. Without points it does nothing.
    void show(std::span<const Vec3> points, float width, float height);

    void turn(float yaw_step_rad, float pitch_step_rad);
    void zoom(float factor);
    /// Moves the target in the image plane, by fractions of the image height.
    void pan(float right, float up);

    Vec3 eye(const Pose& listener) const;
    glm::mat4 view(const Pose& listener) const;
    glm::mat4 projection(const Pose& listener, float aspect) const;
};

/// Intersection of a ray with a horizontal plane; empty for nearly horizontal rays.
std::optional<Vec3> on_level(const Ray& ray, float z);

/// The projection of a camera to a screen rectangle: corner and size in pixels, y down.
class Screen {
 public:
    Screen(const Camera& camera, const Pose& listener, glm::vec2 corner, glm::vec2 size);

    const glm::mat4& matrix() const { return matrix_; }
    const Vec3& eye() const { return eye_; }

    /// Pixel of a point; empty behind the eye.
    std::optional<glm::vec2> project(const Vec3& point) const;

    /// Image scale at a point: pixels per metre across the line of sight; 0 behind the eye.
    float pixels_per_metre(const Vec3& point) const;

    /// The ray from the eye through a pixel.
    Ray ray(glm::vec2 pixel) const;

 private:
    glm::mat4 matrix_;
    Vec3 eye_;
    Vec3 right_;
    glm::vec2 corner_;
    glm::vec2 size_;
};

}  // namespace aula
