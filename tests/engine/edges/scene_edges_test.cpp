#include "engine/edges/scene_edges.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>

#include "tests/support/rooms.h"

using aula::DiffractionEdge;
using aula::Object;
using aula::RayScene;
using aula::Scene;
using aula::SceneEdges;
using aula::Vec3;

namespace {

Scene scene_of(std::vector<Object> objects) {
    Scene scene;
    scene.objects = std::move(objects);
    scene.materials.resize(1);
    return scene;
}

/// A rectangle in the plane y = 0 from the origin.
Object panel(float width_m, float height_m) {
    Object object;
    object.vertices = {{0, 0, 0}, {width_m, 0, 0}, {width_m, 0, height_m}, {0, 0, height_m}};
    object.triangles = {{0, 1, 2}, {0, 2, 3}};
    object.triangle_materials = {0, 0};
    return object;
}

Object at(Object object, const Vec3& place) {
    object.translation = place;
    return object;
}

}  // namespace

TEST_CASE("the foot of a wall on a floor is no edge, above the floor it is") {
    const auto count = [](float height_m) {
        const RayScene rays(
            scene_of({aula::test::square(5), at(panel(2, 1.5F), {-1, 0.3F, height_m})}));
        return SceneEdges(rays).count();
    };
    CHECK(count(0) == 4 + 3);
    CHECK(count(0.05F) == 4 + 4);
    // A gap of a mesh, and the gap under a door.
    CHECK(count(0.003F) == 4 + 3);
    CHECK(count(0.008F) == 4 + 4);
}

TEST_CASE("a box on a floor has eight edges, one that floats has twelve") {
    const auto count = [](float height_m) {
        const RayScene rays(scene_of(
            {aula::test::square(5), aula::test::box({1, 1, 1}, 0, {0.2F, 0.3F, height_m})}));
        return SceneEdges(rays).count();
    };
    CHECK(count(0) == 4 + 8);
    CHECK(count(0.05F) == 4 + 12);
}

TEST_CASE("fixed objects close each other's edges, and a movable object keeps all its edges") {
    const auto count = [](bool movable) {
        Object right = at(panel(2, 2), {2, 0, 0});
        right.movable = movable;
        const RayScene rays(scene_of({panel(2, 2), right}));
        return SceneEdges(rays).count();
    };
    CHECK(count(false) == 4);  // one wall of 4 x 2 m
    CHECK(count(true) == 8);
}

TEST_CASE("small objects that touch each other and are large together are not small") {
    const auto has_small = [](float distance_m) {
        std::vector<Object> bricks;
        for (int i = 0; i < 8; ++i) {
            const Vec3 corner(distance_m * static_cast<float>(i), 0, 0);
            bricks.push_back(aula::test::box(Vec3(0.1F), 0, corner));
        }
        const RayScene rays(scene_of(std::move(bricks)));
        return SceneEdges(rays).has_small();
    };
    CHECK_FALSE(has_small(0.1F));
    CHECK(has_small(0.2F));
}

TEST_CASE("the edges of an object move with it and keep their indices") {
    Object door = panel(0.9F, 2);
    // A triangle without an area has no edges and no orientation.
    const Vec3 middle = 0.5F * (door.vertices[0] + door.vertices[1]);
    door.triangles.push_back({0, 1, static_cast<std::uint32_t>(door.vertices.size())});
    door.triangle_materials.push_back(0);
    door.vertices.push_back(middle);
    door.path = aula::Trajectory{};
    door.path->points = {{0, {.position = {1, 0, 0}}},
                         {1, {.position = {1, 2, 0.5F}, .yaw_rad = 1, .roll_rad = 0.3F}}};
    const Scene scene = scene_of({panel(1, 2), door});
    RayScene rays(scene);
    SceneEdges edges(rays);
    REQUIRE(edges.count() == 8);
    const std::vector<DiffractionEdge> before = edges.all();

    rays.move(1.0);
    edges.scene_moved();
    const glm::mat3 turn = door.path->at(1).rotation();
    std::set<std::size_t> moved;
    for (std::uint32_t e = 0; e < edges.count(); ++e) {
        const Vec3 end(before[e].point(before[e].length_m));
        const bool is_door = glm::distance(Vec3(edges[e].start), Vec3(before[e].start)) > 1e-3F;
        const auto place = [&](const Vec3& p) {
            return is_door ? turn * (p - Vec3(1, 0, 0)) + Vec3(1, 2, 0.5F) : p;
        };
        if (is_door) moved.insert(e);
        // Rounding of floats of some metres.
        CHECK(glm::distance(Vec3(edges[e].start), place(Vec3(before[e].start))) < 1e-5F);
        CHECK(glm::distance(Vec3(edges[e].point(edges[e].length_m)), place(end)) < 1e-5F);
        CHECK(edges[e].triangles == before[e].triangles);
    }
    CHECK(moved == std::set<std::size_t>{4, 5, 6, 7});

    // Back at the start, and exact again.
    rays.move(0.0);
    edges.scene_moved();
    for (std::uint32_t e = 0; e < edges.count(); ++e)
        CHECK(glm::distance(edges[e].start, before[e].start) < 1e-5);
}
