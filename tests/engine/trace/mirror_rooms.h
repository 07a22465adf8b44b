#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "engine/base/sampling.h"
#include "engine/trace/specular_paths.h"

// Rooms of plane mirrors, with a material for each wall.

namespace aula::test {

/// Adds a plane quadrilateral.
inline void add_quad(Object& object, const std::array<Vec3, 4>& corners,
                     std::uint32_t material = 0) {
    const auto first = static_cast<std::uint32_t>(object.vertices.size());
    object.vertices.insert(object.vertices.end(), corners.begin(), corners.end());
    object.triangles.push_back({first, first + 1, first + 2});
    object.triangles.push_back({first, first + 2, first + 3});
    object.triangle_materials.insert(object.triangle_materials.end(), 2, material);
}

/// The walls of a box from 0 to `size`; wall 2 axis + side has material 2 axis + side.
inline Object mirror_box(const Vec3& size) {
    Object object;
    for (int axis = 0; axis < 3; ++axis) {
        Vec3 u(0);
        Vec3 v(0);
        u[(axis + 1) % 3] = size[(axis + 1) % 3];
        v[(axis + 2) % 3] = size[(axis + 2) % 3];
        for (int side = 0; side < 2; ++side) {
            Vec3 corner(0);
            if (side == 1) corner[axis] = size[axis];
            add_quad(object, {corner, corner + u, corner + u + v, corner + v},
                     static_cast<std::uint32_t>(2 * axis + side));
        }
    }
    return object;
}

inline Material material(float absorption, float scattering) {
    return {"", Bands::filled(absorption), Bands::filled(scattering)};
}

/// A scene with materials 0 to 5, each with other coefficients.
inline Scene scene_of(std::vector<Object> objects) {
    Scene scene;
    scene.objects = std::move(objects);
    for (int i = 0; i < 6; ++i) {
        scene.materials.push_back(
            material(0.1F + 0.05F * static_cast<float>(i), 0.02F * static_cast<float>(i)));
    }
    return scene;
}

/// A rectangle across the room in the plane x = `at`.
inline void add_screen(Object& object, float at, float y0, float y1, float z0, float z1) {
    add_quad(object, {Vec3(at, y0, z0), Vec3(at, y1, z0), Vec3(at, y1, z1), Vec3(at, y0, z1)});
}

/// `count` unit parallelograms, no two coplanar, around a point 100 m above the origin: too many
/// sequences to list beyond order 1.
inline Object far_mirrors(int count) {
    Object mirrors;
    RandomStream random(5);
    for (int i = 0; i < count; ++i) {
        const Vec3 at = Vec3(0, 0, 100) + 20.0F * uniform_direction(random.uniform_2d());
        const Vec3 u = uniform_direction(random.uniform_2d());
        const Vec3 v = uniform_direction(random.uniform_2d());
        add_quad(mirrors, {at, at + u, at + u + v, at + v});
    }
    return mirrors;
}

inline std::set<std::uint64_t> ids(const std::vector<SoundPath>& paths) {
    std::set<std::uint64_t> all;
    for (const SoundPath& p : paths) all.insert(p.key);
    return all;
}

inline constexpr float kRadius_m = 0.5F;
inline const Vec3 kSize(5, 4, 3);
inline const Vec3 kSource(1.2F, 1.1F, 1.5F);
inline const Vec3 kListener(3.7F, 2.9F, 1.2F);

}  // namespace aula::test
