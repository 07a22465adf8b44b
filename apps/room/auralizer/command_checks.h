#pragma once

#include "aula/auralizer.h"

namespace aula {

// Checks of the arguments of an auralizer's commands. They throw InputError: a single value that is
// not finite would make all later samples NaN.

/// Throws InputError with this text unless a condition holds.
void require(bool holds, const char* otherwise);

void check_options(const AuralizerOptions& options);
void check_position(const Vec3& position);
void check_pose(const Pose& pose);
void check_gain(float gain_db);
void check_transform(const RigidTransform& transform);
void check_material(const Material& material);
void check_part_gains(const PartGains& gains);

}  // namespace aula
