#pragma once

#include <aula.h>

namespace aula::unity {

// Matrices of the engine, by columns, in left-handed axes: x to the right, y up, z to the front.

/// The pose of something whose matrix leads to the world. Its scale does not count.
aula_pose pose_to_world(const float (&matrix)[16]);

/// The pose of something whose matrix leads from the world.
aula_pose pose_from_world(const float (&matrix)[16]);

}  // namespace aula::unity
