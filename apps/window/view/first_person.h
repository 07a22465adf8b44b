#pragma once

#include "aula/engine/scene.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// Walking input: each component -1..1; larger values run.
struct WalkInput {
    float ahead = 0;
    float left = 0;
    float turn_left = 0;
    float look_up = 0;

    bool any() const { return ahead != 0 || left != 0 || turn_left != 0 || look_up != 0; }
};

/// The pose after `time_s` seconds of walking: 1.5 m/s and 90 degrees/s per unit of input, at
/// constant height. With `walls` the movement slides along them at a clearance of 0.25 m; null: no
/// collisions.
Pose walked(const Pose& from, const WalkInput& input, double time_s, const RayScene* walls);

}  // namespace aula
