#pragma once

#include "aula/engine/scene.h"

namespace aula {

/// The coordinate axes of a host program. Aula's are right-handed, x to the front and z up.
enum class Axes {
    z_up,              ///< Aula's
    y_up,              ///< right-handed, z to the back: glTF, OpenGL; (x, y, z) -> (x, -z, y)
    y_up_left_handed,  ///< z to the front: Unity; (x, y, z) -> (x, z, y)
    z_up_left_handed,  ///< y to the right: Unreal, in metres; (x, y, z) -> (x, -y, z)
};

/// Converts a position or direction from the host's axes to Aula's.
Vec3 from_axes(Axes axes, const Vec3& v);

/// Converts a position or direction from Aula's axes to the host's.
Vec3 to_axes(Axes axes, const Vec3& v);

/// Converts a rigid motion from the host's axes to Aula's.
RigidTransform from_axes(Axes axes, const RigidTransform& transform);

/// The pose at `position` with the view direction `front` and the top of the head towards `up`.
/// Both vectors are in Aula's axes, of any length, and not parallel.
Pose pose_looking(const Vec3& position, const Vec3& front, const Vec3& up = {0, 0, 1});

}  // namespace aula
