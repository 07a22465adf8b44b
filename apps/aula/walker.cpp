#include "apps/aula/walker.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aula {

namespace {

constexpr float kSpeed_m_s = 1.5F;
constexpr float kTurn_rad_s = 0.5F * std::numbers::pi_v<float>;
/// A press is enough to walk on until a held key repeats, at 20 Hz or faster, or is let go.
constexpr float kPress_s = 0.2F;

/// Adds a press to what is still to go; presses do not pile up, the other direction stops first.
float pressed(float to_go, float step) {
    if (to_go * step < 0) return 0;
    return std::clamp(to_go + step, -std::abs(step), std::abs(step));
}

/// Takes up to `most` off what is still to go and returns it.
float take(float& to_go, float most) {
    const float taken = std::clamp(to_go, -most, most);
    to_go -= taken;
    return taken;
}

}  // namespace

void Walker::press(Key key) {
    const float step_m = kSpeed_m_s * kPress_s;
    const float step_rad = kTurn_rad_s * kPress_s;
    if (key == Key::forward) ahead_m_ = pressed(ahead_m_, step_m);
    if (key == Key::back) ahead_m_ = pressed(ahead_m_, -step_m);
    if (key == Key::left) left_m_ = pressed(left_m_, step_m);
    if (key == Key::right) left_m_ = pressed(left_m_, -step_m);
    if (key == Key::turn_left) turn_rad_ = pressed(turn_rad_, step_rad);
    if (key == Key::turn_right) turn_rad_ = pressed(turn_rad_, -step_rad);
}

const Pose& Walker::advance(double time_s) {
    const auto dt_s = static_cast<float>(time_s);
    pose_.yaw_rad += take(turn_rad_, kTurn_rad_s * dt_s);
    const float ahead_m = take(ahead_m_, kSpeed_m_s * dt_s);
    const float left_m = take(left_m_, kSpeed_m_s * dt_s);
    const float cos_yaw = std::cos(pose_.yaw_rad);
    const float sin_yaw = std::sin(pose_.yaw_rad);
    pose_.position.x += ahead_m * cos_yaw - left_m * sin_yaw;
    pose_.position.y += ahead_m * sin_yaw + left_m * cos_yaw;
    return pose_;
}

}  // namespace aula
