#pragma once

#include "engine/rays/ray_scene.h"
#include "engine/scene/scene.h"

namespace aula {

/// What a walker wants: each -1..1, or more to run.
struct WalkInput {
    float ahead = 0;
    float left = 0;
    float turn_left = 0;
    float look_up = 0;

    bool any() const { return ahead != 0 || left != 0 || turn_left != 0 || look_up != 0; }
};

/// Where a walker is after `time_s`: at 1.5 m/s and 90 degrees a second, at the height they were.
/// With `walls` they do not go through those, but along them, and keep a shoulder's width off.
Pose walked(const Pose& from, const WalkInput& input, double time_s, const RayScene* walls);

}  // namespace aula
