#include "apps/aula/walker.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aula {

namespace {

constexpr float kSpeed_m_s = 1.5F;
constexpr float kTurn_rad_s = 0.5F * std::numbers::pi_v<float>;
/// Duration of the movement of one press. A held key repeats sooner, at 20 Hz or faster.
constexpr float kPress_s = 0.2F;

/// The remaining distance after a press: at most one step. A press of the opposite direction stops
/// the movement.
float after_press(float remaining, float step) {
    if (remaining * step < 0) return 0;
    return std::clamp(remaining + step, -std::abs(step), std::abs(step));
}

/// Removes up to `max` from the remaining distance; returns the distance removed.
float consume(float& remaining, float max) {
    const float moved = std::clamp(remaining, -max, max);
    remaining -= moved;
    return moved;
}

}  // namespace

void Walker::press(Key key) {
    const float step_m = kSpeed_m_s * kPress_s;
    const float step_rad = kTurn_rad_s * kPress_s;
    if (key == Key::forward) ahead_m_ = after_press(ahead_m_, step_m);
    if (key == Key::back) ahead_m_ = after_press(ahead_m_, -step_m);
    if (key == Key::left) left_m_ = after_press(left_m_, step_m);
    if (key == Key::right) left_m_ = after_press(left_m_, -step_m);
    if (key == Key::turn_left) turn_rad_ = after_press(turn_rad_, step_rad);
    if (key == Key::turn_right) turn_rad_ = after_press(turn_rad_, -step_rad);
}

const Pose& Walker::advance(double time_s) {
    const auto dt_s = static_cast<float>(time_s);
    pose_.yaw_rad += consume(turn_rad_, kTurn_rad_s * dt_s);
    const float ahead_m = consume(ahead_m_, kSpeed_m_s * dt_s);
    const float left_m = consume(left_m_, kSpeed_m_s * dt_s);
    const float cos_yaw = std::cos(pose_.yaw_rad);
    const float sin_yaw = std::sin(pose_.yaw_rad);
    pose_.position.x += ahead_m * cos_yaw - left_m * sin_yaw;
    pose_.position.y += ahead_m * sin_yaw + left_m * cos_yaw;
    return pose_;
}

}  // namespace aula
