// Patches of scenes with moving objects.

#include <catch2/catch.hpp>
#include <glm/vector_relational.hpp>
#include <set>
#include <vector>

#include "engine/base/sampling.h"
#include "engine/rays/room_survey.h"
#include "tests/engine/patches/surveyed.h"
#include "tests/support/rooms.h"

namespace patch_grid_motion_test {

using namespace aula;
using aula::test::room;
using aula::test::Surveyed;

namespace {

const Vec3 kBesideBlock(1, 1, 2);

/// A room of 10 x 4 x 3 m with a block that slides along x from `begin` to `end` in that many
/// seconds.
Scene room_with_sliding_block(const Vec3& size, const Vec3& begin, const Vec3& end,
                              double duration_s) {
    Scene scene = room(test::box(Vec3(10, 4, 3)), kBesideBlock);
    Object block = test::box(size);
    block.path = Trajectory{{{0, {begin}}, {duration_s, {end}}}, false};
    scene.objects.push_back(block);
    return scene;
}

}  // namespace

TEST_CASE("moving objects have a share of the maximum number of patches") {
    constexpr double kMax = 400;
    constexpr double kBlock_m2 = 48;
    Scene scene = room_with_sliding_block(Vec3(3, 3, 2.5F), Vec3(3, 0.5F, 0), Vec3(4, 0.5F, 0), 1);
    const auto with_block = [&](const PatchGrid& grid) {
        const auto size_m = double{grid.patch_size_m()};
        return static_cast<double>(grid.reached()) + 4 * kBlock_m2 / (size_m * size_m);
    };
    CHECK(with_block(Surveyed(scene, 0.25F, kBesideBlock, kMax).grid) <= kMax);
    // Companion: of a static block only the patches that sound reaches count.
    scene.objects.back().path.reset();
    for (Vec3& v : scene.objects.back().vertices) v += Vec3(3, 0.5F, 0);
    CHECK(with_block(Surveyed(scene, 0.25F, kBesideBlock, kMax).grid) > kMax);
}

TEST_CASE("patches that an object has left are released") {
    const Scene scene = room_with_sliding_block(Vec3(1), Vec3(0, 1, 1), Vec3(1000, 1, 1), 1000);
    Surveyed s(scene, 0.5F, kBesideBlock);
    const auto on_top = [&](float x_m) {
        return s.grid.find(Vec3(x_m, 1.3F, 2 + 1e-4F), Vec3(0, 0, 1));
    };
    std::size_t early = 0;
    std::set<std::uint32_t> numbers;
    std::set<float> cells;
    for (int k = 8; k <= 400; ++k) {
        s.rays.move(0.25 * k);
        s.grid.scene_moved();
        const float x_m = 0.25F * static_cast<float>(k);
        CAPTURE(x_m);
        const std::uint32_t here = on_top(x_m + 0.3F);
        REQUIRE(here != PatchGrid::kNone);
        CHECK(s.grid.area_m2(here) > 0.1F);
        // The next cell that it does not intersect.
        CHECK(on_top(x_m - 0.6F) == PatchGrid::kNone);
        numbers.insert(here);
        cells.insert(s.grid.cell(here).low.x);
        if (k == 40) early = s.grid.size();
    }
    // The block has moved by 100 m.
    CHECK(s.grid.size() == early);
    // Companion: it has crossed many more cells than there are numbers.
    CHECK(cells.size() >= 190);
    CHECK(numbers.size() < 60);
}

TEST_CASE("sound that has passed through a moving object is direct until a wall reflects it") {
    const RayScene rays(
        room_with_sliding_block(Vec3(1, 2, 2), Vec3(1.5F, 0.5F, 0.5F), Vec3(5, 0.5F, 0.5F), 1));
    constexpr int kPaths = 500;
    int direct = 0;
    int later = 0;
    trace_random_walks(rays, {&kBesideBlock, 1}, {.paths = kPaths, .bounces = 8, .seed = 1},
                       [&](float farthest_m, const Ray&, const Hit& hit) {
                           CHECK(hit.any());
                           ++(farthest_m < 0 ? direct : later);
                       });
    // Exact: each path has one first wall, in many cases behind the block.
    CHECK(direct == kPaths);
    // Companion: segments after reflections are counted separately.
    CHECK(later > kPaths);
}

TEST_CASE("a survey measures segments from wall to wall, through moving objects") {
    const RayScene rays(
        room_with_sliding_block(Vec3(3, 3, 2), Vec3(3, 0.5F, 0.5F), Vec3(5, 0.5F, 0.5F), 1));
    const double empty_m =
        survey_room(RayScene(room(test::box(Vec3(10, 4, 3)), kBesideBlock)), {&kBesideBlock, 1}, 1)
            .mean_free_path_m;
    // 4 V / S of the room without the block. The standard error of 65536 segments with a spread of
    // 0.6 of their mean is 0.25 %. One segment of 32 is not diffuse and differs by at most a third.
    CHECK(empty_m == Approx(4 * 120 / 164.0).epsilon(0.02));
    // With the block the paths are the same up to rounding.
    const double mean_m = survey_room(rays, {&kBesideBlock, 1}, 1).mean_free_path_m;
    CHECK(mean_m == Approx(empty_m).epsilon(0.005));
    // Companion: segments that begin at the block are shorter.
    double pieces_m = 0;
    int hits = 0;
    trace_random_walks(
        rays, {&kBesideBlock, 1}, {.paths = 500, .bounces = 32, .seed = 1},
        [&](float, const Ray& ray, const Hit& hit) {
            const Ray back{ray.origin + hit.distance_m * ray.direction, -ray.direction};
            Hit first;
            rays.intersect({&back, 1}, {&first, 1});
            pieces_m +=
                double{first.any() ? std::min(first.distance_m, hit.distance_m) : hit.distance_m};
            ++hits;
        });
    CHECK(pieces_m / hits < 0.9 * mean_m);
}

TEST_CASE("no ray is lost through the floor under a moving object") {
    const auto lost = [](const Scene& scene) {
        int count = 0;
        trace_random_walks(RayScene(scene), {&kBesideBlock, 1},
                           {.paths = 2000, .bounces = 32, .seed = 1},
                           [&](float, const Ray&, const Hit& hit) { count += hit.any() ? 0 : 1; });
        return count;
    };
    Scene scene = room_with_sliding_block(Vec3(3, 3, 2), Vec3(3, 0.5F, 0), Vec3(5, 0.5F, 0), 1);
    CHECK(lost(scene) == 0);
    // Companion: through a hole in the floor beside it.
    scene.objects.front().triangles.erase(scene.objects.front().triangles.begin());
    CHECK(lost(scene) > 0);
    // Rays are not caught in an object either: without walls all of them escape.
    scene.objects.front().triangles.clear();
    scene.objects.front().triangle_materials.clear();
    CHECK(lost(scene) == 2000);
}

TEST_CASE("a moving object's patches follow it") {
    const Vec3 begin(4.02F, 1.02F, 1.02F);
    const Scene scene = room_with_sliding_block(Vec3(1), begin, Vec3(7.02F, 1.02F, 1.02F), 1);
    Surveyed s(scene, 0.5F, kBesideBlock);
    const auto top_area = [&](float x) {
        const std::uint32_t patch = s.grid.find(Vec3(x, 1.3F, 2.02F + 1e-4F), Vec3(0, 0, 1));
        return patch == PatchGrid::kNone ? 0.0F : s.grid.area_m2(patch);
    };
    CHECK(top_area(4.3F) > 0.1F);
    CHECK(top_area(7.3F) == 0);
    s.rays.move(1);
    s.grid.scene_moved();
    CHECK(top_area(4.3F) == 0);
    CHECK(top_area(7.3F) > 0.1F);
}

TEST_CASE(
    "a moving object's patches have its area, and every cell a unique number, in every move") {
    const Vec3 step(0.37F, 0.21F, 0.013F);
    constexpr int kMoves = 12;
    Scene scene = room_with_sliding_block(Vec3(1), Vec3(1.9F, 0.3F, 0.8F),
                                          Vec3(1.9F, 0.3F, 0.8F) + step * float{kMoves}, kMoves);
    Surveyed s(scene, 0.5F, kBesideBlock);
    const std::uint32_t floor = s.grid.find(Vec3(9.8F, 3.8F, 1e-4F), Vec3(0, 0, 1));
    REQUIRE(floor != PatchGrid::kNone);
    const float floor_m2 = s.grid.area_m2(floor);
    CHECK(floor_m2 == Approx(0.25F).epsilon(1e-4));
    for (int k = 1; k <= kMoves; ++k) {
        s.rays.move(k);
        s.grid.scene_moved();
        const Vec3 corner = Vec3(1.9F, 0.3F, 0.8F) + step * static_cast<float>(k);
        std::set<std::uint32_t> met;
        double area_m2 = 0;
        RandomStream random(static_cast<std::uint64_t>(k));
        for (int i = 0; i < 3000; ++i) {
            // A point on one of its faces, a little outside.
            const auto [u, v] = random.uniform_2d();
            const int axis = i % 3;
            const bool far = i % 6 >= 3;
            Vec3 at(0);
            at[axis] = far ? 1 + 1e-4F : -1e-4F;
            at[(axis + 1) % 3] = u;
            at[(axis + 2) % 3] = v;
            Vec3 normal(0);
            normal[axis] = far ? 1.0F : -1.0F;
            const std::uint32_t patch = s.grid.find(corner + at, normal);
            REQUIRE(patch != PatchGrid::kNone);
            if (met.insert(patch).second) area_m2 += double{s.grid.area_m2(patch)};
            // The cell contains the point.
            const PatchCell cell = s.grid.cell(patch);
            for (int a = 0; a < 3; ++a) {
                CHECK(corner[a] + at[a] > cell.low[a] - 1e-3F);
                CHECK(corner[a] + at[a] < cell.high[a] + 1e-3F);
            }
            CHECK(cell.direction == normal);
        }
        CAPTURE(k, met.size());
        // Exact by clipping, as nothing covers it; slivers at its rims may be missed.
        CHECK(area_m2 == Approx(6).epsilon(0.01));
        CHECK(met.size() >= 24);
        // The patches of the room remain.
        CHECK(s.grid.find(Vec3(9.8F, 3.8F, 1e-4F), Vec3(0, 0, 1)) == floor);
        CHECK(s.grid.area_m2(floor) == floor_m2);
        CHECK_FALSE(met.contains(floor));
    }
}

TEST_CASE("an object that oscillates within its cells keeps its patches") {
    Scene scene = room_with_sliding_block(Vec3(1), Vec3(2.02F, 1.02F, 1.02F), Vec3(7, 2, 0), 21);
    auto& points = scene.objects.back().path->points;
    points.insert(points.begin() + 1,
                  {{1, {Vec3(4.02F, 1.02F, 1.02F)}}, {20, {Vec3(4.12F, 1.02F, 1.02F)}}});
    Surveyed s(scene, 0.5F, kBesideBlock);
    const auto top = [&] { return s.grid.find(Vec3(4.6F, 1.3F, 2.0201F), Vec3(0, 0, 1)); };
    CHECK(top() == PatchGrid::kNone);
    s.rays.move(1);
    s.grid.scene_moved();
    const std::uint32_t before = top();
    REQUIRE(before != PatchGrid::kNone);
    for (int k = 2; k <= 20; ++k) {
        s.rays.move(k);
        s.grid.scene_moved();
        CHECK(top() == before);
    }
    // Companion: after a move elsewhere they are released.
    s.rays.move(21);
    s.grid.scene_moved();
    CHECK(top() == PatchGrid::kNone);
    // After its return it has new ones and keeps these as well.
    std::uint32_t after = PatchGrid::kNone;
    for (int k = 1; k <= 12; ++k) {
        s.rays.move(5 + k);
        s.grid.scene_moved();
        if (k == 1) after = top();
        CHECK(top() == after);
    }
    CHECK(after != PatchGrid::kNone);
}

TEST_CASE("a released number is reused by one patch") {
    // A block leaves its patches and oscillates for many moves where it intersects two cells in
    // each direction. It then intersects three, for which it needs released numbers.
    constexpr float kSide_m = 0.98F;
    Scene scene = room_with_sliding_block(Vec3(kSide_m), Vec3(0), Vec3(0), 1);
    Trajectory path{{{0, {Vec3(1.9F, 0.3F, 0.8F)}}}, false};
    for (int k = 1; k <= 6; ++k)
        path.points.push_back({1.0 * k, {Vec3(1.9F + 1.2F * static_cast<float>(k), 20.3F, 0.8F)}});
    for (int k = 7; k <= 20; ++k) {
        path.points.push_back(
            {1.0 * k, {Vec3(9.005F + 0.01F * static_cast<float>(k % 2), 20.01F, 1.01F)}});
    }
    for (int k = 21; k <= 40; ++k) {
        path.points.push_back(
            {1.0 * k, {Vec3(9.1F, 20.3F + 1.1F * static_cast<float>(k - 20), 0.8F)}});
    }
    scene.objects.back().path = path;
    Surveyed s(scene, 0.5F, kBesideBlock);
    std::set<std::uint32_t> met;
    std::size_t few = 0;
    std::size_t most = 0;
    for (int k = 1; k <= 40; ++k) {
        s.rays.move(k);
        s.grid.scene_moved();
        met.clear();
        for (int i = 0; i < 600; ++i) {
            // A point on one of its faces, a little outside.
            const int axis = i / 100 % 3;
            const bool far = i / 300 == 1;
            Vec3 at(far ? kSide_m + 1e-4F : -1e-4F);
            at[(axis + 1) % 3] = kSide_m * (static_cast<float>(i % 10) + 0.5F) / 10;
            at[(axis + 2) % 3] = kSide_m * (static_cast<float>(i / 10 % 10) + 0.5F) / 10;
            Vec3 normal(0);
            normal[axis] = far ? 1.0F : -1.0F;
            const Vec3 point = path.at(k).position + at;
            CAPTURE(k, axis, far, point.x, point.y, point.z);
            const std::uint32_t patch = s.grid.find(point, normal);
            REQUIRE(patch != PatchGrid::kNone);
            // Exact: the number is that of the point's cell.
            const PatchCell cell = s.grid.cell(patch);
            CHECK(glm::all(glm::lessThanEqual(cell.low, point)));
            CHECK(glm::all(glm::lessThanEqual(point, cell.high)));
            CHECK(cell.direction == normal);
            met.insert(patch);
        }
        if (k == 20) few = met.size();
        most = std::max(most, met.size());
    }
    // Companion: it needs more numbers than while it oscillated.
    CHECK(few == 24);
    CHECK(most == 54);
}

TEST_CASE(
    "moving objects do not count as reached and do not hide surfaces that they cover at the "
    "start") {
    const Vec3 inside = kBesideBlock;
    Surveyed empty(room(test::box(Vec3(10, 4, 3)), inside), 0.5F, inside);
    Scene scene = room_with_sliding_block(Vec3(2), Vec3(4, 1, 0.3F), Vec3(7, 1, 0.3F), 1);
    Surveyed with_block(scene, 0.5F, inside);
    // Exact: the patches of the room, for any movement in it.
    CHECK(with_block.grid.reached() == empty.grid.reached());
    // A static block inside the moving one, from which no patch of the room is visible.
    scene.objects.push_back(test::box(Vec3(1), 0, Vec3(4.5F, 1.5F, 0.9F)));
    Surveyed s(scene, 0.5F, inside);
    const auto top_m2 = [&] {
        return double{s.grid.area_m2(s.grid.find(Vec3(4.75F, 1.75F, 1.9001F), Vec3(0, 0, 1)))};
    };
    CHECK(top_m2() == Approx(0.25).epsilon(0.01));
    s.rays.move(1);
    s.grid.scene_moved();
    CHECK(top_m2() == Approx(0.25).epsilon(0.01));
}

}  // namespace patch_grid_motion_test
