#pragma once

#include <cstdint>
#include <functional>

#include "engine/scene/scene.h"

namespace aula::test {

/// A closed box from the origin, 12 triangles that face in, all of material `material`.
Object box(const Vec3& size, std::uint32_t material = 0, const Vec3& corner = Vec3(0));

/// A closed box from the origin whose walls are divided in squares of about `cell_m`, two triangles
/// each; the corners of squares lie up to `bump_m` beside the wall, so that every triangle has a
/// separate plane where that is more than 1 mm.
Object bumpy_box(const Vec3& size, float cell_m, float bump_m);

/// A sphere of triangles round the origin: an icosahedron, each face divided in 4^subdivisions.
Object icosphere(float radius_m, int subdivisions);

/// A square in the plane z = 0 round the origin, facing up.
Object square(float half_side_m);

/// A closed prism with an L-shaped floor: 6 x 6 m without the quarter x, y > 3; height 3 m.
Object l_shaped_room();

/// Every triangle divided in four; `middle` gives the middle of an edge from its ends. The
/// materials become 0.
Object quartered(Object object, const std::function<Vec3(const Vec3&, const Vec3&)>& middle);

double surface_m2(const Object& object);
double volume_m3(const Object& object);

/// A scene of one object and one grey material, one source, no air absorption, purely what the
/// estimators find: no direct sound, no image sources, specular order 0.
Scene grey_room(const Object& object, float absorption, float scattering, const Vec3& source,
                const Vec3& listener);

}  // namespace aula::test
