#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "aula/engine/scene.h"
#include "engine/direct/edge_paths.h"
#include "engine/edges/scene_edges.h"
#include "engine/rays/ray_scene.h"

namespace aula::test {

/// Half the height of obstacles that stand for infinite ones.
inline constexpr float kFar_m = 60;

/// A rigid prism along z of a convex base, counter-clockwise.
inline Object prism(const std::vector<std::array<float, 2>>& base, float low_m = -kFar_m,
                    float high_m = kFar_m) {
    Object object;
    const auto n = static_cast<std::uint32_t>(base.size());
    for (const auto& p : base) {
        object.vertices.emplace_back(p[0], p[1], low_m);
        object.vertices.emplace_back(p[0], p[1], high_m);
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = 2 * i;
        const std::uint32_t b = 2 * ((i + 1) % n);
        object.triangles.push_back({a, b, b + 1});
        object.triangles.push_back({a, b + 1, a + 1});
    }
    for (std::uint32_t i = 1; i + 1 < n; ++i) {
        object.triangles.push_back({0, 2 * i, 2 * (i + 1)});
        object.triangles.push_back({1, 2 * i + 1, 2 * (i + 1) + 1});
    }
    object.triangle_materials.assign(object.triangles.size(), 0);
    return object;
}

inline Object bar(float half_width_m, float half_depth_m) {
    return prism({{-half_width_m, -half_depth_m},
                  {half_width_m, -half_depth_m},
                  {half_width_m, half_depth_m},
                  {-half_width_m, half_depth_m}});
}

/// A scene of obstacles of one material, and its edges.
struct Place {
    explicit Place(std::vector<Object> objects, float absorption = 0)
        : rays(scene_of(std::move(objects), absorption)) {}

    static Scene scene_of(std::vector<Object> objects, float absorption) {
        Scene scene;
        scene.objects = std::move(objects);
        scene.materials = {{"rigid", Bands::filled(absorption), Bands{}}};
        return scene;
    }

    /// The edge along z at a place.
    const DiffractionEdge* edge_at(double x, double y) const {
        for (const DiffractionEdge& edge : edges.all()) {
            if (std::abs(edge.axis.z) > 0.99 &&
                std::hypot(edge.start.x - x, edge.start.y - y) < 1e-3) {
                return &edge;
            }
        }
        FAIL("no edge");
        return nullptr;
    }

    /// The straight path and the paths over single edges.
    std::vector<EdgePath> single_paths(const Vec3& source, const Vec3& listener) const {
        PairMemory memory;
        return paths.find(source, listener, Bands{}, memory);
    }

    RayScene rays;
    SceneEdges edges{rays};
    EdgePaths paths{rays, edges, 343.2};
};

}  // namespace aula::test
