#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>
#include <vector>

#include "aula/engine/scene.h"
#include "engine/direct/edge_paths.h"
#include "engine/edges/scene_edges.h"
#include "engine/rays/ray_scene.h"

namespace aula::test {

using Levels = std::array<double, kBandCount>;

inline constexpr float kWallEnd_m = 50;  // of the outer edges of walls that stand for infinite ones

/// A scene of rigid surfaces and its edge paths.
struct EdgePathScene {
    explicit EdgePathScene(std::vector<Object> objects) : rays(scene_of(std::move(objects))) {}

    static Scene scene_of(std::vector<Object> objects) {
        Scene scene;
        scene.objects = std::move(objects);
        scene.materials = {{"rigid", Bands{}, Bands{}}};
        return scene;
    }

    std::vector<EdgePath> find(const Vec3& source, const Vec3& listener) const {
        PairMemory memory;
        return paths.find(source, listener, Bands{}, memory);
    }

    std::vector<SoundPath> taps(const Vec3& source, const Vec3& listener) const {
        PairMemory memory;
        return paths.taps(paths.find(source, listener, Bands{}, memory), memory.primary);
    }

    /// Level of the pressure relative to free field, dB.
    Levels coherent_db(const Vec3& source, const Vec3& listener) const {
        ComplexBands sum{};
        for (const EdgePath& path : find(source, listener)) {
            for (std::size_t b = 0; b < kBandCount; ++b) sum[b] += path.field[b];
        }
        Levels level;
        for (std::size_t b = 0; b < kBandCount; ++b)
            level[b] = 20 * std::log10(std::abs(sum[b]) * double{glm::distance(source, listener)});
        return level;
    }

    /// The same of the energy of all taps.
    Levels energy_db(const Vec3& source, const Vec3& listener) const {
        Bands sum;
        for (const SoundPath& tap : taps(source, listener)) sum += tap.energy;
        const double d = double{glm::distance(source, listener)};
        Levels level;
        for (std::size_t b = 0; b < kBandCount; ++b)
            level[b] = 10 * std::log10(4 * std::numbers::pi * d * d * double{sum[b]});
        return level;
    }

    RayScene rays;
    SceneEdges edges{rays};
    EdgePaths paths{rays, edges, 343.2};
};

inline void add_quad(Object& object, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const auto first = static_cast<std::uint32_t>(object.vertices.size());
    for (const Vec3& corner : {a, b, c, d}) object.vertices.push_back(corner);
    object.triangles.push_back({first, first + 1, first + 2});
    object.triangles.push_back({first, first + 2, first + 3});
    object.triangle_materials.insert(object.triangle_materials.end(), 2, 0);
}

/// A rectangle of the plane y = 0.
inline void add_wall(Object& object, float x0, float x1, float z0, float z1) {
    add_quad(object, {x0, 0, z0}, {x1, 0, z0}, {x1, 0, z1}, {x0, 0, z1});
}

/// A wall in the plane y = 0 with an opening of 0.9 x 2 m.
inline Object door_wall() {
    Object wall;
    add_wall(wall, -kWallEnd_m, -0.45F, -kWallEnd_m, kWallEnd_m);
    add_wall(wall, 0.45F, kWallEnd_m, -kWallEnd_m, kWallEnd_m);
    add_wall(wall, -0.45F, 0.45F, -kWallEnd_m, 0);
    add_wall(wall, -0.45F, 0.45F, 2, kWallEnd_m);
    return wall;
}

/// A half plane x < 0 in the plane y = 0.
inline Object half_plane() {
    Object wall;
    add_wall(wall, -kWallEnd_m, 0, -kWallEnd_m, kWallEnd_m);
    return wall;
}

}  // namespace aula::test
