#include "apps/window/view/first_person.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace aula {

namespace {

constexpr float kSpeed_m_s = 1.5F;
constexpr float kTurn_rad_s = 0.5F * std::numbers::pi_v<float>;
constexpr float kSteepest_rad = 1.4F;
constexpr float kClearance_m = 0.25F;
/// Heights of the collision probes relative to the ears: ears and hips.
constexpr std::array<float, 2> kHeights_m{0.0F, -0.7F};
constexpr int kProbes = 16;

Hit nearest(const RayScene& walls, const Ray& ray) {
    Hit hit;
    walls.intersect(std::span(&ray, 1), std::span(&hit, 1));
    return hit;
}

/// True if no wall lies between two points, at all probe heights.
bool is_free(const RayScene& walls, const Vec3& from, const Vec3& to) {
    const float distance_m = glm::distance(from, to);
    if (distance_m == 0) return true;
    const Vec3 direction = (to - from) / distance_m;
    return std::none_of(kHeights_m.begin(), kHeights_m.end(), [&](float height_m) {
        return nearest(walls, {from + Vec3(0, 0, height_m), direction, distance_m}).any();
    });
}

/// The point `at`, pushed to kClearance_m from all walls that are closer.
Vec3 push_off_walls(const RayScene& walls, Vec3 at) {
    for (const float height_m : kHeights_m) {
        for (int i = 0; i < kProbes; ++i) {
            const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / kProbes;
            const Vec3 probe(std::cos(angle), std::sin(angle), 0);
            const Hit hit = nearest(walls, {at + Vec3(0, 0, height_m), probe, kClearance_m});
            if (!hit.any()) continue;
            Vec3 off = walls.facing_normal(hit, probe);
            off.z = 0;
            const float length = glm::length(off);
            if (length < 0.1F) continue;  // a floor or a ceiling
            off /= length;
            const float distance_m = -glm::dot(off, probe) * hit.distance_m;
            at += std::max(0.0F, kClearance_m - distance_m) * off;
        }
    }
    return at;
}

}  // namespace

Pose walked(const Pose& from, const WalkInput& input, double time_s, const RayScene* walls) {
    const auto dt_s = static_cast<float>(time_s);
    Pose pose = from;
    pose.yaw_rad += input.turn_left * kTurn_rad_s * dt_s;
    pose.pitch_rad = std::clamp(pose.pitch_rad + input.look_up * kTurn_rad_s * dt_s, -kSteepest_rad,
                                kSteepest_rad);
    const Vec3 ahead(std::cos(pose.yaw_rad), std::sin(pose.yaw_rad), 0);
    const Vec3 left(-ahead.y, ahead.x, 0);
    const Vec3 step = kSpeed_m_s * dt_s * (input.ahead * ahead + input.left * left);
    if (!walls) {
        pose.position += step;
        return pose;
    }
    if (step == Vec3(0)) return pose;
    // Short steps: a long step at a low frame rate must not cut a corner.
    constexpr float kLongestStep_m = 0.1F;
    const int steps = std::max(1, static_cast<int>(std::ceil(glm::length(step) / kLongestStep_m)));
    for (int i = 0; i < steps; ++i) {
        const Vec3 wanted =
            push_off_walls(*walls, pose.position + step * (1.0F / static_cast<float>(steps)));
        if (!is_free(*walls, pose.position, wanted)) break;
        pose.position = wanted;
    }
    return pose;
}

}  // namespace aula
