#include "engine/rays/scene_planes.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "engine/base/sampling.h"

using aula::Object;
using aula::RayScene;
using aula::Scene;
using aula::ScenePlanes;
using aula::Vec3;

namespace {

void add_triangle(Object& object, const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto first = static_cast<std::uint32_t>(object.vertices.size());
    object.vertices.insert(object.vertices.end(), {a, b, c});
    object.triangles.push_back({first, first + 1, first + 2});
    object.triangle_materials.push_back(0);
}

Scene scene_of(std::vector<Object> objects) {
    Scene scene;
    scene.objects = std::move(objects);
    scene.materials.resize(1);
    return scene;
}

std::size_t distinct_planes(const RayScene& rays, const ScenePlanes& planes) {
    std::set<std::uint32_t> used;
    for (std::uint32_t t = 0; t < rays.triangle_count(); ++t) used.insert(planes.of_triangle(t));
    return used.size();
}

/// Any two unit vectors that span the plane of a normal.
std::pair<Vec3, Vec3> axes_of(const Vec3& normal) {
    const Vec3 other = std::abs(normal.x) < 0.5F ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const Vec3 u = glm::normalize(glm::cross(normal, other));
    return {u, glm::cross(normal, u)};
}

}  // namespace

TEST_CASE("coplanar triangles share a plane for either orientation and any direction") {
    aula::RandomStream random(1);
    for (int trial = 0; trial < 500; ++trial) {
        // Every eighth normal lies on the borders of the index's cells and signs.
        const Vec3 normal =
            trial % 8 == 0
                ? glm::normalize(Vec3(trial % 3 - 1, trial % 5 - 2, trial % 7 == 0 ? 1 : 1e-8F))
                : aula::uniform_direction(random.uniform_2d());
        const auto [u, v] = axes_of(normal);
        const Vec3 middle = 20.0F * aula::uniform_direction(random.uniform_2d());
        Object object;
        for (int i = 0; i < 20; ++i) {
            std::array<Vec3, 3> p;
            for (Vec3& x : p) {
                const auto at = random.uniform_2d();
                // Up to 0.2 mm beside the plane; triangles of metres, so 0.1 degrees hold.
                x = middle + 20 * at[0] * u + 20 * at[1] * v +
                    2e-4F * (2 * random.uniform() - 1) * normal;
            }
            if (glm::length(glm::cross(p[1] - p[0], p[2] - p[0])) < 8) continue;
            if (i % 2 == 0) std::swap(p[0], p[1]);
            add_triangle(object, p[0], p[1], p[2]);
        }
        const RayScene rays(scene_of({object}));
        CHECK(distinct_planes(rays, ScenePlanes(rays)) == 1);
    }
}

TEST_CASE("planes that differ by more than the tolerance are separate") {
    const auto planes_with = [](const Vec3& lift_a, const Vec3& lift_b) {
        Object object;
        add_triangle(object, {0, 0, 0}, {2, 0, 0}, {0, 2, 0});
        add_triangle(object, Vec3{3, 0, 0} + lift_a, Vec3{5, 0, 0} + lift_b,
                     Vec3{3, 2, 0} + lift_a);
        const RayScene rays(scene_of({object}));
        return distinct_planes(rays, ScenePlanes(rays));
    };
    CHECK(planes_with({0, 0, 0}, {0, 0, 0}) == 1);
    CHECK(planes_with({0, 0, 0.0008F}, {0, 0, 0.0008F}) == 1);
    CHECK(planes_with({0, 0, 0.0015F}, {0, 0, 0.0015F}) == 2);
    CHECK(planes_with({0, 0, -0.01F}, {0, 0, 0.01F}) == 2);  // 0.6 degrees
}

TEST_CASE("degenerate triangles have no plane") {
    Object object;
    add_triangle(object, {0, 0, 0}, {1, 0, 0}, {2, 0, 0});
    add_triangle(object, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const RayScene rays(scene_of({object}));
    const ScenePlanes planes(rays);
    CHECK(planes.of_triangle(0) == ScenePlanes::kNoPlane);
    CHECK(planes.of_triangle(1) == 0);
    CHECK(planes.count() == 1);
}

TEST_CASE("a moving object's planes move with it and separate from shared planes") {
    Object wall;
    add_triangle(wall, {0, 0, 0}, {0, 4, 0}, {0, 0, 4});
    Object door;
    add_triangle(door, {0, 0, 0}, {0, 1, 0}, {0, 0, 2});
    add_triangle(door, {0, 1, 0}, {0, 1, 2}, {0, 0, 2});
    door.path = aula::Trajectory{};
    door.path->points = {{0, {.position = {0, 5, 0}}},
                         {1, {.position = {0, 5, 0}, .yaw_rad = 0.5F}},
                         {2, {.position = {1, 5, 0}, .yaw_rad = 0.5F}}};
    RayScene rays(scene_of({wall, door}));
    ScenePlanes planes(rays);
    CHECK(planes.count() == 1);

    rays.move(1);
    planes.scene_moved();
    CHECK(planes.count() == 2);
    const std::uint32_t own = planes.of_triangle(1);
    CHECK(own != planes.of_triangle(0));
    CHECK(planes.of_triangle(2) == own);

    rays.move(2);
    planes.scene_moved();
    CHECK(planes.count() == 2);
    CHECK(planes.of_triangle(1) == own);
    for (std::uint32_t t = 0; t < 3; ++t) {
        for (const Vec3& v : rays.triangle(t).vertices) {
            const auto& plane = planes[planes.of_triangle(t)];
            // Rounding of floats of some metres.
            CHECK(std::abs(plane.distance_m(ScenePlanes::Point(v))) < 1e-5);
            for (int axis = 0; axis < 3; ++axis) {
                CHECK(v[axis] >= plane.bounds.min[axis]);
                CHECK(v[axis] <= plane.bounds.max[axis]);
            }
        }
    }
}

TEST_CASE(
    "a wall keeps its plane when a larger object leaves it, and the object returns to its own") {
    Object wall;
    add_triangle(wall, {0, 0, 0}, {0, 1, 0}, {0, 0, 1});
    Object door;
    add_triangle(door, {0, 0, 0}, {0, 4, 0}, {0, 0, 4});
    door.path = aula::Trajectory{};
    door.path->points = {{0, {.position = {0, 5, 0}}}, {1, {.position = {2, 5, 0}}}};
    door.path->points.push_back({2, {.position = {0, 5, 0}}});
    RayScene rays(scene_of({wall, door}));
    ScenePlanes planes(rays);
    CHECK(planes.count() == 1);
    for (const double time_s : {0.5, 1.0, 1.5, 2.0}) {
        rays.move(time_s);
        planes.scene_moved();
        CAPTURE(time_s);
        CHECK(planes.of_triangle(0) != planes.of_triangle(1));
        for (std::uint32_t t = 0; t < 2; ++t) {
            for (const Vec3& v : rays.triangle(t).vertices) {
                const auto& plane = planes[planes.of_triangle(t)];
                CHECK(std::abs(plane.distance_m(ScenePlanes::Point(v))) < 1e-5);  // rounding
                for (int axis = 0; axis < 3; ++axis) {
                    CHECK(v[axis] >= plane.bounds.min[axis]);
                    CHECK(v[axis] <= plane.bounds.max[axis]);
                }
            }
        }
    }
}

TEST_CASE("a plane reflects if any of its triangles does, in any order of the triangles") {
    for (const std::uint32_t mirror : {0U, 1U, 2U}) {
        CAPTURE(mirror);
        Object object;
        add_triangle(object, {0, 0, 0}, {3, 0, 0}, {0, 3, 0});
        add_triangle(object, {3, 3, 0}, {1, 3, 0}, {3, 1, 0});
        add_triangle(object, {9, 9, 0}, {8, 9, 0}, {9, 8, 0});
        object.triangle_materials.assign(3, 0);
        object.triangle_materials[mirror] = 1;
        Scene scene = scene_of({object});
        scene.materials[0].absorption = aula::Bands::filled(1);
        scene.materials.push_back({"mirror", aula::Bands{}, aula::Bands{}});
        const RayScene rays(scene);
        const ScenePlanes planes(rays);
        REQUIRE(planes.count() == 1);
        CHECK(planes[0].reflects);
    }
}

TEST_CASE("planes reflect if some band is neither absorbed nor scattered completely") {
    Object object;
    add_triangle(object, {0, 0, 0}, {2, 0, 0}, {0, 2, 0});
    Scene scene = scene_of({object});
    const auto reflects = [&](const aula::Bands& absorption, const aula::Bands& scattering) {
        scene.materials[0].absorption = absorption;
        scene.materials[0].scattering = scattering;
        const RayScene rays(scene);
        return ScenePlanes(rays)[0].reflects;
    };
    const aula::Bands none = aula::Bands::filled(0);
    const aula::Bands all = aula::Bands::filled(1);
    aula::Bands all_but_one = all;
    all_but_one[7] = 0.9F;
    CHECK(reflects(none, none));
    CHECK(reflects(all_but_one, all_but_one));
    CHECK_FALSE(reflects(all, none));
    CHECK_FALSE(reflects(none, all));
    // One band is scattered, and all others are absorbed.
    aula::Bands one = none;
    one[7] = 1;
    CHECK_FALSE(reflects(all_but_one, one));
}
