#pragma once

#include "engine/scene/scene.h"

namespace aula {

/// The axes that a host program counts in. Aula's are right-handed, x to the front and z up.
enum class Axes {
    z_up,              ///< Aula's
    y_up,              ///< right-handed, z to the back: glTF, OpenGL; (x, y, z) -> (x, -z, y)
    y_up_left_handed,  ///< z to the front: Unity; (x, y, z) -> (x, z, y)
    z_up_left_handed,  ///< y to the right: Unreal, in metres; (x, y, z) -> (x, -y, z)
};

/// A position or direction of the host in Aula's axes.
Vec3 from_axes(Axes axes, const Vec3& v);

/// One of Aula's in the host's axes.
Vec3 to_axes(Axes axes, const Vec3& v);

/// A rigid motion of the host in Aula's axes.
RigidTransform from_axes(Axes axes, const RigidTransform& transform);

/// The pose at a position that looks along `front`, with the top of the head towards `up`; both in
/// Aula's axes, of any length, and not along one line.
Pose pose_looking(const Vec3& position, const Vec3& front, const Vec3& up = {0, 0, 1});

}  // namespace aula
