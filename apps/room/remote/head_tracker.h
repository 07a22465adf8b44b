#pragma once

#include <optional>

#include "apps/room/remote/osc.h"
#include "aula/engine/vec3.h"

namespace aula {

/// Yaw, pitch and roll (as in Pose) of a head tracker's message; empty for other messages:
/// "/SceneRotator/quaternions" w x y z, or "/SceneRotator/ypr" and "/ypr" in degrees.
///
/// They are the orientation of the head. Axes are x to the front, y to the left and z up; rotations
/// are positive by the right-hand rule (yaw to the left, pitch down, roll to the right), first
/// roll, then pitch, then yaw. `inverted`: the messages have the inverse rotation, that of the
/// scene about the head. A quaternion need not have the length 1.
std::optional<Vec3> head_angles_rad(const OscMessage& message, bool inverted);

}  // namespace aula
