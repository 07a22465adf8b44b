#include "apps/room/edit/scene_edits.h"

#include <catch2/catch.hpp>

#include "tests/support/test_scenes.h"

using namespace aula;

TEST_CASE("A surface consists of all of its triangles and no others") {
    const Scene scene = test::small_room();
    const RayScene rays(scene);
    CHECK(surface_of(rays, 0) == std::vector<std::uint32_t>{0, 1});
    CHECK(surface_of(rays, 3) == std::vector<std::uint32_t>{2, 3});
    CHECK(triangles_like(scene, 5).size() == 12);
}

TEST_CASE(
    "Scenes with other materials and sources have the same geometry, and those with a moved object "
    "do "
    "not") {
    const Scene scene = test::small_room();
    Scene edited = with_material(scene, {0, 1}, {"curtain", {}, {}});
    edited.sources[0].position.x += 1;
    CHECK(same_geometry(scene, edited));
    Scene moved = scene;
    moved.objects[0].translation.x += 1;
    CHECK_FALSE(same_geometry(scene, moved));
    Scene moving = scene;
    moving.objects[0].path = Trajectory{{{0, {}}, {1, {}}}, false};
    CHECK_FALSE(same_geometry(scene, moving));
    CHECK(same_geometry(moving, Scene(moving)));
    Scene faster = moving;
    faster.objects[0].path->points[1].time_s = 2;
    CHECK_FALSE(same_geometry(moving, faster));
}

TEST_CASE("Changing the material of a surface does not modify the original scene") {
    const Scene scene = test::small_room();
    const Material curtain{"curtain", Bands::filled(0.6F), Bands::filled(0.4F)};
    const Scene edited = with_material(scene, {0, 1}, curtain);
    CHECK(material_of(edited, 0).name == "curtain");
    CHECK(material_of(edited, 1).absorption == curtain.absorption);
    CHECK(material_of(edited, 2).name == "wall");
    CHECK(material_of(scene, 0).name == "wall");
    CHECK(edited.materials.size() == 2);
    // An equal material adds nothing; another one of the same name does not change the first.
    CHECK(with_material(edited, {2}, curtain).materials.size() == 2);
    const Material other{"curtain", Bands::filled(0.2F), Bands::filled(0.4F)};
    const Scene twice = with_material(edited, {2}, other);
    CHECK(material_of(twice, 2).name == "curtain 2");
    CHECK(material_of(twice, 0).absorption == curtain.absorption);
    CHECK(with_material(twice, {3}, other).materials.size() == 3);
}

TEST_CASE("A material is replaced by name, also by one of the library") {
    const Scene scene = with_material(test::small_room(), {0, 1}, {"paper", {}, {}});
    const auto edited = with_material_replaced(scene, "wall", "curtain");
    REQUIRE(edited);
    CHECK(material_of(*edited, 5).name == "curtain");
    CHECK(material_of(*edited, 0).name == "paper");
    CHECK_FALSE(with_material_replaced(scene, "no such", "curtain"));
    CHECK_FALSE(with_material_replaced(scene, "wall", "no such"));
}
