#include "engine/rays/convex_room.h"

#include <catch2/catch.hpp>

#include "tests/support/rooms.h"

namespace {

using namespace aula;

const Vec3 kInside(1, 1, 2);

Scene room(const Object& object) { return test::grey_room(object, 0.1F, 1, kInside, kInside); }

bool is_convex(const Scene& scene, const Vec3& inside = kInside) {
    return is_convex_room(RayScene(scene), {&inside, 1});
}

}  // namespace

TEST_CASE("an empty box is convex, also with its faces outwards or in parts") {
    CHECK(is_convex(room(test::box(Vec3(5, 4, 3)))));
    Scene outwards = room(test::box(Vec3(5, 4, 3)));
    for (auto& triangle : outwards.objects[0].triangles) std::swap(triangle[0], triangle[1]);
    CHECK(is_convex(outwards));
    CHECK(is_convex(room(test::bumpy_box(Vec3(5, 4, 3), 1.5F, 0))));
}

TEST_CASE(
    "a room with a corner, a hole, an object, a movement or a listener outside is not convex") {
    CHECK_FALSE(is_convex(room(test::l_shaped_room())));
    CHECK_FALSE(is_convex(room(test::box(Vec3(5, 4, 3))), Vec3(1, 1, -2)));
    CHECK_FALSE(is_convex(room(test::box(Vec3(5, 4, 3))), Vec3(6, 1, 2)));
    Scene furnished = room(test::box(Vec3(5, 4, 3)));
    furnished.objects.push_back(test::box(Vec3(1), 0, Vec3(3, 2, 1)));
    CHECK_FALSE(is_convex(furnished));
    Scene twice = room(test::box(Vec3(5, 4, 3)));
    twice.objects.push_back(twice.objects[0]);
    CHECK_FALSE(is_convex(twice));
    Scene open = room(test::box(Vec3(5, 4, 3)));
    open.objects[0].triangles.pop_back();
    open.objects[0].triangle_materials.pop_back();
    CHECK_FALSE(is_convex(open));
    Scene moving = room(test::box(Vec3(5, 4, 3)));
    moving.objects[0].movable = true;
    CHECK_FALSE(is_convex(moving));
}

TEST_CASE("a sheet of two faces is no room, and in a room it is an object") {
    // The faces have different diagonals: each edge belongs to two triangles.
    Object sheet = test::box(Vec3(1));
    sheet.vertices = {{1, 1, 0}, {3, 1, 0}, {3, 2, 0}, {1, 2, 0}};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 0, 3}, {1, 3, 2}};
    sheet.triangle_materials.assign(4, 0);
    CHECK_FALSE(is_convex(room(sheet)));
    Scene with_rug = room(test::box(Vec3(5, 4, 3)));
    with_rug.objects.push_back(sheet);
    CHECK_FALSE(is_convex(with_rug));
}
