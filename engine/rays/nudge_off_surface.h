#pragma once

#include "engine/rays/ray_scene.h"

namespace aula {

/// A place on a surface, or within 0.5 mm of one, moved 1 mm off it; any other as it is. A
/// surface parts two spaces: the more closed one is taken, else the one that its normal faces.
/// [propagation thread]
Vec3 off_surface(const RayScene& scene, const Vec3& place);

}  // namespace aula
