#pragma once

#include <cstdint>
#include <functional>

#include "aula/engine/scene.h"

namespace aula::test {

/// A closed box with its lowest corner at `corner`: 12 triangles that face inwards, all of material
/// `material`.
Object box(const Vec3& size, std::uint32_t material = 0, const Vec3& corner = Vec3(0));

/// A closed box from the origin. Its walls are divided into squares of about `cell_m`, two
/// triangles each. The squares' corners lie up to `bump_m` off the wall: above 1 mm each triangle
/// has a separate plane.
Object bumpy_box(const Vec3& size, float cell_m, float bump_m);

/// A triangulated sphere around the origin: an icosahedron, each face divided into 4^subdivisions.
Object icosphere(float radius_m, int subdivisions);

/// Assigns a material to the two walls of a box that are perpendicular to the y axis.
void set_walls_across_y(Object& box, std::uint32_t material);

/// A square in the plane z = 0 around the origin, facing up.
Object square(float half_side_m);

/// A closed prism with an L-shaped floor: 6 x 6 m without the quarter x, y > 3; height 3 m.
Object l_shaped_room();

/// The object with each triangle divided into four. `middle` gives the midpoint of an edge from its
/// ends. All materials become 0.
Object quartered(Object object, const std::function<Vec3(const Vec3&, const Vec3&)>& middle);

double surface_m2(const Object& object);
double volume_m3(const Object& object);

/// A scene of one object, one grey material and one source, for tests of the estimators only:
/// without air absorption, direct sound and image sources.
Scene grey_room(const Object& object, float absorption, float scattering, const Vec3& source,
                const Vec3& listener);

}  // namespace aula::test
