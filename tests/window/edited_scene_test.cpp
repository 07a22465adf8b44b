#include "apps/window/model/edited_scene.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>

#include "apps/room/edit/scene_edits.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"

using namespace aula;
using namespace aula::test;

namespace {

OpenedScene opened(const Scene& scene, const std::filesystem::path& file = "room.json") {
    WindowOptions options;
    options.load = [&](const std::filesystem::path&) {
        LoadedScene loaded;
        loaded.scene = scene;
        return loaded;
    };
    return open_scene(options, file);
}

Scene with_absorption(const EditedScene& edited, float absorption) {
    Material material = material_of(edited.scene(), 0);
    material.absorption = Bands::filled(absorption);
    return with_material(edited.scene(), {0}, material);
}

float absorption(const EditedScene& edited) { return material_of(edited.scene(), 0).absorption[4]; }

}  // namespace

TEST_CASE("An opened scene loops all signals, and options of the command line apply") {
    WindowOptions options;
    options.load = [](const std::filesystem::path&) {
        LoadedScene loaded;
        loaded.scene = small_room();
        return loaded;
    };
    options.change = [](Scene& scene) { scene.simulation.rays = 77; };
    const OpenedScene scene = open_scene(options, "room.json");
    CHECK(scene.scene->sources[0].loop);
    CHECK(scene.scene->simulation.rays == 77);
    CHECK_FALSE(scene.read->scene.sources[0].loop);
    CHECK(scene.rays->triangle_count() == 12);
}

TEST_CASE("An edit of a material is undone and redone without a change of the geometry") {
    EditedScene edited(opened(small_room()));
    const auto version = edited.version();
    const auto geometry = edited.geometry_version();
    edited.pick(0);
    const auto change = edited.edit(with_absorption(edited, 0.7F), {Vec3(1)});
    CHECK(change.scene);
    CHECK_FALSE(change.sources);
    CHECK(absorption(edited) == 0.7F);
    CHECK(edited.version() > version);
    CHECK(edited.geometry_version() == geometry);
    CHECK(edited.surface());

    CHECK(edited.undo().scene);
    CHECK(absorption(edited) == 0.3F);
    CHECK(edited.source_positions().empty());
    CHECK_FALSE(edited.can_undo());
    CHECK(edited.redo().scene);
    CHECK(absorption(edited) == 0.7F);
    CHECK(edited.source_positions() == EditedScene::SourcePositions{Vec3(1)});
}

TEST_CASE("A moved source is an undo step that leaves the scene unchanged") {
    EditedScene edited(opened(small_room()));
    const auto version = edited.version();
    edited.move_sources({Vec3(1)});
    edited.move_sources({Vec3(2)});
    CHECK_FALSE(edited.undo().scene);
    CHECK(edited.source_positions() == EditedScene::SourcePositions{Vec3(1)});
    CHECK_FALSE(edited.undo().scene);
    CHECK(edited.source_positions().empty());
    CHECK(edited.version() == version);
}

TEST_CASE("Consecutive remote edits form one undo step, and an edit by hand ends it") {
    EditedScene edited(opened(small_room()));
    edited.edit_remotely(with_absorption(edited, 0.5F), {});
    edited.edit_remotely(with_absorption(edited, 0.6F), {});
    CHECK(absorption(edited) == 0.6F);
    edited.edit(with_absorption(edited, 0.7F), {});
    edited.edit_remotely(with_absorption(edited, 0.8F), {});
    edited.undo();
    CHECK(absorption(edited) == 0.7F);
    edited.undo();
    CHECK(absorption(edited) == 0.6F);
    edited.undo();
    CHECK(absorption(edited) == 0.3F);
    CHECK_FALSE(edited.can_undo());
}

TEST_CASE("A reloaded file with other geometry and sources changes both, and so does its undo") {
    EditedScene edited(opened(small_room()));
    edited.pick(0);
    Scene larger = small_room();
    for (Vec3& vertex : larger.objects[0].vertices) vertex *= 2;
    larger.sources[0].name = "other";
    const auto geometry = edited.geometry_version();
    const auto change = edited.reload(opened(larger));
    CHECK(change.scene);
    CHECK(change.sources);
    CHECK(edited.geometry_version() > geometry);
    CHECK_FALSE(edited.surface());
    CHECK(edited.bounds().max == Vec3(10, 8, 6));

    CHECK(edited.undo().sources);
    CHECK(edited.bounds().max == Vec3(5, 4, 3));
    CHECK(edited.rays().triangle(0).area_m2() == Approx(10));
}

TEST_CASE("A reloaded file with other materials only keeps the ray scene and the picked surface") {
    EditedScene edited(opened(small_room()));
    edited.pick(3);
    const RayScene* rays = &edited.rays();
    Scene other = small_room();
    other.materials[0].absorption = Bands::filled(0.9F);
    CHECK_FALSE(edited.reload(opened(other)).sources);
    CHECK(&edited.rays() == rays);
    CHECK(edited.surface());
    CHECK(absorption(edited) == 0.9F);
}

TEST_CASE("Another scene begins without history and selection") {
    EditedScene edited(opened(small_room()));
    edited.edit(with_absorption(edited, 0.7F), {});
    edited.pick(0);
    const auto geometry = edited.geometry_version();
    edited.restart(opened(small_room(), "other.json"));
    CHECK(edited.file() == "other.json");
    CHECK_FALSE(edited.can_undo());
    CHECK_FALSE(edited.surface());
    CHECK(edited.geometry_version() > geometry);
}

TEST_CASE("A picked surface holds all triangles in its plane and their area") {
    EditedScene edited(opened(small_room()));
    edited.pick(0);
    REQUIRE(edited.surface());
    CHECK(edited.surface()->picked == 0);
    CHECK(edited.surface()->triangles.size() == 2);
    CHECK(edited.surface()->area_m2 == Approx(20));
    edited.deselect();
    CHECK_FALSE(edited.surface());
}

TEST_CASE("Without geometry the bounds contain listener and sources with a margin of 1 m") {
    const EditedScene edited(opened(free_field({4, 0, 0})));
    CHECK(edited.bounds().min == Vec3(-1));
    CHECK(edited.bounds().max == Vec3(5, 1, 1));
}

TEST_CASE("Moving objects of the ray scene follow the time of the scene") {
    Scene scene = small_room();
    Trajectory path;
    path.points = {{0, {}}, {10, {.position = {0, 0, 10}}}};
    scene.objects[0].path = path;
    EditedScene edited(opened(scene));
    const float before = edited.rays().triangle(0).vertices[0].z;
    edited.move_objects(5);
    CHECK(edited.rays().triangle(0).vertices[0].z == Approx(before + 5));
}

TEST_CASE("A change of the file is reported once, at most every half second") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "room.json";
    std::ofstream(file) << "{}";
    EditedScene edited(opened(small_room(), file));
    CHECK_FALSE(edited.file_changed(1));
    std::filesystem::last_write_time(
        file, std::filesystem::last_write_time(file) + std::chrono::seconds(2));
    CHECK_FALSE(edited.file_changed(1.4));
    CHECK(edited.file_changed(1.6));
    CHECK_FALSE(edited.file_changed(3));
}
