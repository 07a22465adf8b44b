#pragma once

#include "aula/engine/scene.h"

namespace aula {

/// The coordinate axes of a host program. Aula's axes are right-handed, with x to the front, y to
/// the left and z up. The conversions only exchange axes and signs; lengths are in metres in all of
/// them.
enum class Axes {
    z_up,              ///< the axes of Aula
    y_up,              ///< right-handed: glTF, OpenGL; (x, y, z) is (x, -z, y) in Aula
    y_up_left_handed,  ///< left-handed: Unity; (x, y, z) is (x, z, y) in Aula
    z_up_left_handed,  ///< left-handed: Unreal; (x, y, z) is (x, -y, z) in Aula
};

/// Converts a position or direction from the host's axes to Aula's.
Vec3 from_axes(Axes axes, const Vec3& v);

/// Converts a position or direction from Aula's axes to the host's.
Vec3 to_axes(Axes axes, const Vec3& v);

/// Converts a rigid motion from the host's axes to Aula's.
RigidTransform from_axes(Axes axes, const RigidTransform& transform);

/// The pose at `position` that looks along `front`, with the top of the head towards `up`. All
/// three vectors are in Aula's axes. `front` and `up` are longer than 0 and not parallel; `up` need
/// not be perpendicular to `front`.
Pose pose_looking(const Vec3& position, const Vec3& front, const Vec3& up = {0, 0, 1});

}  // namespace aula
