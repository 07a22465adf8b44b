#pragma once

#include <optional>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// A place of ears or of a mouth above a floor, m.
inline constexpr float kStandingHeight_m = 1.6F;

/// Places in the largest room of a scene where people can stand, the most open one first. They are
/// on a grid; each has a floor below, space above and around, and surfaces in most directions. In
/// the open they are on the ground. Empty if there is none.
std::vector<Vec3> standing_places(const RayScene& scene, const Bounds& bounds);

/// A place for a source: far from the middle of the room. `places` are standing places.
std::optional<Vec3> source_place(const RayScene& scene, const std::vector<Vec3>& places);

/// A place for a listener who sees the source and is some metres away from it.
std::optional<Vec3> listener_place(const RayScene& scene, const std::vector<Vec3>& places,
                                   const Vec3& source);

}  // namespace aula
