#include "apps/drawing/room_section.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

namespace {

using namespace aula;

/// A closed box, without a file.
Scene box(const Vec3& low, const Vec3& high) {
    Scene scene;
    std::vector<Vec3> corners;
    for (int i = 0; i < 8; ++i)
        corners.push_back({(i & 1 ? high : low).x, (i & 2 ? high : low).y, (i & 4 ? high : low).z});
    scene.add_object(corners,
                     {{0, 1, 3},
                      {0, 3, 2},
                      {4, 5, 7},
                      {4, 7, 6},
                      {0, 1, 5},
                      {0, 5, 4},
                      {2, 3, 7},
                      {2, 7, 6},
                      {0, 2, 6},
                      {0, 6, 4},
                      {1, 3, 7},
                      {1, 7, 5}},
                     "plaster");
    return scene;
}

double length_m(const RoomSection& plan) {
    double sum = 0;
    for (const auto& [from, to] : plan.walls) sum += double{glm::distance(from, to)};
    return sum;
}

}  // namespace

TEST_CASE("The plan and the side view of a box are its outlines") {
    const RayScene rays(box({-1, 2, 0}, {5, 6, 3}));
    for (const float z : {0.01F, 1.2F, 2.99F}) {
        const RoomSection plan = floor_plan(rays, z);
        CHECK(length_m(plan) == Approx(20).epsilon(1e-5));
        CHECK(plan.min == glm::vec2(-1, 2));
        CHECK(plan.max == glm::vec2(5, 6));
    }
    const RoomSection side = side_view(rays, 4);
    CHECK(length_m(side) == Approx(18).epsilon(1e-5));
    CHECK(side.min == glm::vec2(-1, 0));
    CHECK(side.max == glm::vec2(5, 3));
    CHECK(side_view(rays, 1.9F).walls.empty());
    CHECK(floor_plan(rays, 3.1F).walls.empty());
    CHECK(floor_plan(rays, -0.1F).walls.empty());
}

TEST_CASE("A plane through corners and a horizontal face cuts each wall once") {
    Scene scene = box({0, 0, 0}, {4, 4, 4});
    // A shelf in the plane, and triangles that only touch it.
    scene.add_object({{1, 1, 2}, {2, 1, 2}, {2, 2, 2}, {1, 1, 3}}, {{0, 1, 2}, {0, 1, 3}}, "wood");
    const RoomSection plan = floor_plan(RayScene(scene), 2);
    CHECK(length_m(plan) == Approx(16).epsilon(1e-5));
}
