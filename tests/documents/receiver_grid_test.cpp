#include "apps/documents/receiver_grid.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "aula/exception.h"

namespace {

using namespace aula;

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// The faces of a box; without those of the highest x and the highest z on request.
void add_box(Scene& scene, const Vec3& low, const Vec3& high, bool wall = true, bool top = true) {
    std::vector<Vec3> corners;
    for (int i = 0; i < 8; ++i)
        corners.push_back({(i & 1 ? high : low).x, (i & 2 ? high : low).y, (i & 4 ? high : low).z});
    Triangles triangles{{0, 1, 3}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4},
                        {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}};
    if (wall) triangles.insert(triangles.end(), {{1, 3, 7}, {1, 7, 5}});
    if (top) triangles.insert(triangles.end(), {{4, 5, 7}, {4, 7, 6}});
    scene.add_object(corners, triangles, "plaster");
}

Scene room() {
    Scene scene;
    add_box(scene, {0, 0, 0}, {6, 4, 3});
    scene.sources.emplace_back().name = "voice";
    scene.sources[0].position = {1, 1, 1.5F};
    scene.listener.pose.position = {5, 3, 1.2F};
    return scene;
}

ReceiverGrid grid_of(const Scene& scene, double height_m = 1.2, double spacing_m = 0.5) {
    return receiver_grid(scene, RayScene(scene), height_m, spacing_m);
}

/// Receivers in a box of the plane.
long count_in(const ReceiverGrid& grid, float x0, float y0, float x1, float y1) {
    return std::count_if(grid.receivers.begin(), grid.receivers.end(), [&](const Pose& pose) {
        return pose.position.x > x0 && pose.position.x < x1 && pose.position.y > y0 &&
               pose.position.y < y1;
    });
}

}  // namespace

TEST_CASE("A grid fills a box, centred, at the height and with the spacing") {
    const ReceiverGrid grid = grid_of(room());
    CHECK(grid.columns == 12);
    CHECK(grid.rows == 8);
    REQUIRE(grid.receivers.size() == 96);
    CHECK(grid.receivers[0].position == Vec3(0.25F, 0.25F, 1.2F));
    CHECK(grid.receivers[95].position.x == Approx(5.75));
    CHECK(grid.receivers[95].position.y == Approx(3.75));
    CHECK(grid.receivers[1].position.x - grid.receivers[0].position.x == Approx(0.5));
    // A spacing larger than the room: one receiver, in the middle.
    const ReceiverGrid one = grid_of(room(), 1.2, 50);
    REQUIRE(one.receivers.size() == 1);
    CHECK(one.receivers[0].position.x == Approx(3));
}

TEST_CASE("Receivers inside a solid or within 0.1 m of a surface are left out") {
    Scene scene = room();
    // A pillar of 1 m that stands on the floor without a face below it, and a low bench.
    add_box(scene, {2, 1, 0}, {3, 2, 3});
    add_box(scene, {4, 1, 0}, {5, 2, 1.15F});
    const ReceiverGrid grid = grid_of(scene);
    CHECK(count_in(grid, 1.9F, 0.9F, 3.1F, 2.1F) == 0);
    CHECK(count_in(grid, 3.9F, 0.9F, 5.1F, 2.1F) == 0);  // 0.05 m above the bench
    CHECK(grid.receivers.size() == 88);
    CHECK(grid.cells.size() == 88);
    CHECK(grid_of(scene, 1.3).receivers.size() == 92);
    // With a spacing of 0.15 m the first line is 0.075 m from the wall.
    for (const Pose& receiver : grid_of(scene, 1.2, 0.15).receivers) {
        CHECK(receiver.position.x > 0.099F);
        CHECK(receiver.position.y > 0.099F);
    }
}

TEST_CASE("A grid has the rooms of sources and listener, and nothing behind walls or outside") {
    Scene scene = room();
    // A room without source or listener, and one whose wall to the outside is missing.
    add_box(scene, {6.2F, 0, 0}, {9, 4, 3});
    CHECK(grid_of(scene).receivers.size() == Approx(96).margin(8));
    CHECK(count_in(grid_of(scene), 6.1F, 0, 9, 4) == 0);
    scene.listener.pose.position = {8, 2, 1.2F};
    CHECK(count_in(grid_of(scene), 6.1F, 0, 9, 4) > 30);

    Scene yard = room();
    yard.objects.clear();
    add_box(yard, {0, 0, 0}, {6, 4, 3}, true, false);  // no ceiling
    CHECK(grid_of(yard).receivers.size() == 96);
}

TEST_CASE("A grid reaches rooms behind rooms") {
    Scene scene;
    add_box(scene, {0, 0, 0}, {30, 4, 3});
    // Four walls with doors of 0.9 m by 2 m, at either end.
    for (int wall = 1; wall <= 4; ++wall) {
        const float x = 6.0F * static_cast<float>(wall);
        const float from = wall % 2 ? 0.9F : 0;
        const float to = wall % 2 ? 4 : 3.1F;
        const float door_from = wall % 2 ? 0 : 3.1F;
        const float door_to = wall % 2 ? 0.9F : 4;
        scene.add_object({{x, from, 0}, {x, to, 0}, {x, to, 3}, {x, from, 3}},
                         {{0, 1, 2}, {0, 2, 3}}, "plaster");
        scene.add_object({{x, door_from, 2}, {x, door_to, 2}, {x, door_to, 3}, {x, door_from, 3}},
                         {{0, 1, 2}, {0, 2, 3}}, "plaster");
    }
    scene.sources.emplace_back().name = "voice";
    scene.sources[0].position = {1, 3, 1.5F};
    scene.listener.pose.position = {2, 3, 1.2F};
    CHECK(grid_of(scene).receivers.size() == 480);
}

TEST_CASE("Positions outside that see the room through an opening are left out") {
    Scene scene = room();
    scene.objects.clear();
    // The wall at x = 6 has a window, 1 m wide; a free panel at x = 12 extends the bounds.
    add_box(scene, {0, 0, 0}, {6, 4, 3}, false);
    scene.add_object({{6, 0, 0},
                      {6, 1.5F, 0},
                      {6, 1.5F, 3},
                      {6, 0, 3},
                      {6, 2.5F, 0},
                      {6, 4, 0},
                      {6, 4, 3},
                      {6, 2.5F, 3},
                      {12, 0, 0},
                      {12, 0.2F, 0},
                      {12, 0.2F, 3}},
                     {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}, {8, 9, 10}}, "plaster");
    const ReceiverGrid grid = grid_of(scene);
    CHECK(grid.receivers.size() > 80);
    CHECK(count_in(grid, 6.6F, -1, 13, 5) == 0);
}

TEST_CASE("Heights outside of the room, too many receivers and empty scenes are refused") {
    const Scene scene = room();
    for (const double height_m : {-0.5, 0.0, 3.0, 3.5})
        CHECK_THROWS_WITH(grid_of(scene, height_m),
                          Catch::Contains("--height") && Catch::Contains("below 3"));
    CHECK_THROWS_WITH(grid_of(scene, 1.2, 1e-9),
                      Catch::Contains("--spacing") && Catch::Contains("points"));
    CHECK_THROWS_WITH(grid_of(scene, 1.2, 0.01), Catch::Contains("--spacing"));
    CHECK_THROWS_WITH(grid_of(scene, 2.95), Catch::Contains("no receiver"));
    Scene empty = scene;
    empty.objects.clear();
    CHECK_THROWS_AS(grid_of(empty), InputError);
}

TEST_CASE("Receivers are above raked seats and galleries, not above what is below them") {
    Scene scene = room();
    // The seats rise from 0.2 m at x = 1 to 1 m at x = 5; a gallery at 1.5 m is above their end.
    scene.add_object({{1, 0.5F, 0.2F}, {5, 0.5F, 1}, {5, 3.5F, 1}, {1, 3.5F, 0.2F}},
                     {{0, 1, 2}, {0, 2, 3}}, "audience");
    scene.add_object({{4, 0.5F, 1.5F}, {5, 0.5F, 1.5F}, {5, 3.5F, 1.5F}, {4, 3.5F, 1.5F}},
                     {{0, 1, 2}, {0, 2, 3}}, "audience");
    scene.objects.back().name = "gallery";
    const RayScene rays(scene);
    const ReceiverGrid grid = surface_grid(scene, rays, "audience", 0.4, 0.5);
    CHECK(grid.place == "0.4 m above audience");
    // 8 x 6 cells of the seats and 2 x 6 of the gallery.
    CHECK(grid.receivers.size() == 60);
    std::size_t above_gallery = 0;
    for (const Pose& receiver : grid.receivers) {
        const Vec3& p = receiver.position;
        if (p.z == Approx(1.9)) {
            ++above_gallery;
            continue;
        }
        CHECK(p.z == Approx(0.4 + 0.2 * static_cast<double>(p.x)));
    }
    CHECK(above_gallery == 12);
    CHECK(std::is_sorted(grid.cells.begin(), grid.cells.end()));
    // An object's name; higher, the gallery is in the way of the seats below.
    CHECK(surface_grid(scene, rays, "gallery", 1.2, 0.5).receivers.size() == 12);
    CHECK(surface_grid(scene, rays, "audience", 1.2, 0.5).receivers.size() == 48);
    CHECK_THROWS_WITH(surface_grid(scene, rays, "seats", 1.2, 0.5),
                      Catch::Contains("--surface") && Catch::Contains("seats") &&
                          Catch::Contains("audience, gallery"));
    CHECK_THROWS_WITH(surface_grid(scene, rays, "gallery", 1.45, 0.5),
                      Catch::Contains("--surface") && Catch::Contains("--offset"));
}
