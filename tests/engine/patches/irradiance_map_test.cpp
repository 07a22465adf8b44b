#include "engine/patches/irradiance_map.h"
#include "engine/base/tolerances.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "engine/base/sampling.h"
#include "engine/patches/patch_grid.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

namespace irradiance_map_test {

using namespace aula;

namespace {

const Vec3 kInside(1, 1, 2);
const Vec3 kDown(0, 0, -1);
constexpr float kPatch_m = 0.5F;
constexpr double kPatch_m2 = 0.25;

/// Position of the hollow boxes, in one cell of the grid: the insides of their bottoms and their
/// lids face upwards in it.
const Vec3 kCorner(2.05F, 2.05F, 1.1F);
constexpr float kSide_m = 0.4F;
constexpr float kHeight_m = 0.06F;
constexpr double kLid_m2 = 0.16;
const Vec3 kCell(2, 2, 1);
const Vec3 kOnLid = kCorner + Vec3(0.2F, 0.01F, 1);

/// Up becomes x.
Vec3 turned(const Vec3& v) { return {v.z, v.x, v.y}; }

/// A room and its patches; a turned one is asked as if it stood upright.
struct Surveyed {
    RayScene rays;
    WorkerPool workers{1};
    PatchGrid grid;
    bool is_turned;

    explicit Surveyed(const Scene& scene, const Vec3& inside = kInside, bool turned = false)
        : rays(scene),
          grid(rays, kPatch_m, {&inside, 1}, test::test_seed(), workers),
          is_turned(turned) {}

    struct PatchPoint {
        std::uint32_t patch = PatchGrid::kNone;
        float area_m2 = 0;     // of the patch
        float irradiance = 0;  // in it
    };
    PatchPoint hit_by(const Vec3& given_from, const Vec3& given_direction) const {
        const Vec3 from = is_turned ? turned(given_from) : given_from;
        const Vec3 direction = is_turned ? turned(given_direction) : given_direction;
        const Ray ray{from, direction};
        Hit hit;
        rays.intersect({&ray, 1}, {&hit, 1});
        REQUIRE(hit.any());
        const Vec3 point = rays.point(hit, direction);
        const Vec3 normal = rays.facing_normal(hit, direction);
        const std::uint32_t patch = grid.find(point, normal);
        REQUIRE(patch != PatchGrid::kNone);
        return {patch, grid.area_m2(patch),
                grid.relative_irradiance(patch, hit.triangle, point, normal)};
    }

    /// Share of the energy of the lid's patch that the upward faces of its cell radiate, seen from
    /// above.
    double share_seen() const {
        const std::uint32_t patch = hit_by(kOnLid, kDown).patch;
        RandomStream random(1);
        constexpr int kPoints = 4000;
        double share = 0;
        for (int i = 0; i < kPoints; ++i) {
            const auto [x, y] = random.uniform_2d();
            const PatchPoint patch_point =
                hit_by(kCell + Vec3(kPatch_m * x, kPatch_m * y, 1), kDown);
            if (patch_point.patch != patch) continue;
            share += kPatch_m2 / kPoints * double{patch_point.irradiance / patch_point.area_m2};
        }
        return share;
    }
};

Scene room() { return test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1, kInside, kInside); }

/// A hollow box, or many side by side, with small triangles.
void add_boxes(Scene& scene, int across) {
    const float side_m = kSide_m / static_cast<float>(across);
    for (int i = 0; i < across * across; ++i) {
        const Vec3 at(static_cast<float>(i % across), static_cast<float>(i / across), 0);
        scene.objects.push_back(
            test::box(Vec3(side_m, side_m, kHeight_m), 0, kCorner + side_m * at));
    }
}

}  // namespace

TEST_CASE("under uniform irradiance all parts of a patch are equal") {
    const Surveyed s(room());
    RandomStream random(1);
    int uneven = 0;
    for (int i = 0; i < 2000; ++i) {
        if (s.hit_by(kInside, uniform_direction(random.uniform_2d())).irradiance != 1) ++uneven;
    }
    // At six standard deviations none of 376 patches, except where the random walks are not yet
    // uniform; each is hit by 5 rays.
    CHECK(uneven < 20);
}

TEST_CASE("a lid over a hollow box radiates all energy of its patch") {
    for (const int across : {1, 20}) {
        CAPTURE(across);
        Scene scene = room();
        add_boxes(scene, across);
        const Surveyed s(scene);
        // Some 400 hits of random walks in total, without the noise of single parts: 5 %. The prior
        // of a quarter of a hit beside 16 moves the share by 1 % towards a half.
        CHECK(s.share_seen() == Approx(1).margin(0.15));
        // Companions: by area alone lid and inside would each have half.
        const Surveyed::PatchPoint lid = s.hit_by(kCorner + Vec3(0.2F, 0.21F, 1), kDown);
        CHECK(kLid_m2 / double{lid.area_m2} < 0.6);
        const Surveyed::PatchPoint inside = s.hit_by(kCorner + Vec3(0.005F, 0.004F, 0.03F), kDown);
        CHECK(inside.irradiance < 0.2F);
    }
}

TEST_CASE("triangles of a patch are joined by their edges, whatever their order") {
    Scene scene = room();
    add_boxes(scene, 20);
    // In each box another one, whose lid is hidden. All are one mesh, in random order.
    Object all;
    for (std::size_t i = 1; i < scene.objects.size(); ++i) {
        const Vec3 corner = scene.objects[i].vertices.front();
        const Object inner = test::box(Vec3(0.015F, 0.015F, 0.03F), 0, corner + 0.002F);
        for (const Object& box : {scene.objects[i], inner}) {
            const auto first = static_cast<std::uint32_t>(all.vertices.size());
            all.vertices.insert(all.vertices.end(), box.vertices.begin(), box.vertices.end());
            for (const auto& [a, b, c] : box.triangles)
                all.triangles.push_back({first + a, first + b, first + c});
        }
    }
    std::mt19937 random(1);
    std::shuffle(all.triangles.begin(), all.triangles.end(), random);
    all.triangle_materials.resize(all.triangles.size(), 0);
    scene.objects.resize(1);
    scene.objects.push_back(all);
    CHECK(Surveyed(scene).share_seen() == Approx(1).margin(0.15));
}

TEST_CASE("the lid of a box radiates as much where it is vertical") {
    Scene scene = room();
    add_boxes(scene, 1);
    for (Object& object : scene.objects) {
        for (Vec3& vertex : object.vertices) vertex = turned(vertex);
    }
    CHECK(Surveyed(scene, turned(kInside), true).share_seen() == Approx(1).margin(0.15));
}

TEST_CASE("coincident faces count as one") {
    Scene scene = room();
    add_boxes(scene, 1);
    add_boxes(scene, 1);
    for (auto& [a, b, c] : scene.objects.back().triangles) std::swap(a, b);
    // As above. A ray may hit either of the faces: counted separately each would have half of the
    // hits.
    CHECK(Surveyed(scene).share_seen() == Approx(1).margin(0.15));
}

TEST_CASE("a lid under a beam radiates most of the energy of its patch") {
    Scene scene = room();
    add_boxes(scene, 1);
    // Half of the lid is covered, and the beam ends within pieces of it: the hits of a piece are
    // spread over its whole area, part of which is visible.
    scene.objects.push_back(
        test::box(Vec3(0.8F, 0.2F, 0.2F), 0, kCorner + Vec3(-0.2F, 0.1F, kHeight_m)));
    const Surveyed s(scene);
    // 1 would be exact. The open half of the lid, 0.08 m2, and the top of the beam, 0.1 m2, receive
    // the energy: if all pieces of the lid were half covered, half of its share of 4/9 would be
    // lost. The standard error of the 400 hits is 5 %.
    const double share = s.share_seen();
    CAPTURE(share);
    CHECK(share > (1 - 0.5 * 0.08 / 0.18) / 1.05);
    CHECK(share < 1.05);
    // Companion: by area alone the visible part, half of the lid and 0.5 m of the beam, would have
    // half.
    CHECK((kLid_m2 / 2 + 0.5 * 0.2) / double{s.hit_by(kOnLid, kDown).area_m2} < 0.6);
}

TEST_CASE("a patch is uniform while it contains a moving object, and as before afterwards") {
    Scene scene = room();
    add_boxes(scene, 1);
    // Its top moves into the lid's cell, beside the lid.
    Object block = test::box(Vec3(0.04F, 0.04F, 0.05F));
    block.path = Trajectory{
        {{0, {Vec3(4, 3, 2)}}, {1, {Vec3(2.005F, 2.005F, 1.2F)}}, {2, {Vec3(4, 3, 2)}}}, false};
    scene.objects.push_back(block);
    Surveyed s(scene);
    const auto lid = [&] { return s.hit_by(kCorner + Vec3(0.2F, 0.21F, 1), kDown); };
    const auto inside = [&] { return s.hit_by(kCorner + Vec3(0.005F, 0.004F, 0.03F), kDown); };
    const Surveyed::PatchPoint lid_before = lid();
    const Surveyed::PatchPoint inside_before = inside();
    REQUIRE(lid_before.irradiance > 1.2F);
    REQUIRE(inside_before.irradiance < 0.2F);
    s.rays.move(1);
    s.grid.scene_moved();
    CHECK(lid().area_m2 > lid_before.area_m2);
    CHECK(lid().irradiance == 1);
    CHECK(inside().irradiance == 1);
    s.rays.move(2);
    s.grid.scene_moved();
    CHECK(lid().area_m2 == lid_before.area_m2);
    CHECK(lid().irradiance == lid_before.irradiance);
    CHECK(inside().irradiance == inside_before.irradiance);
}

TEST_CASE("direct sound makes no part of a patch stronger than the others") {
    // A source 3 cm above the floor: its direct sound falls on a small part of one patch.
    const Vec3 low(2.3F, 2.2F, 0.03F);
    const Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1, low, low);
    const Surveyed s(scene, low);
    RandomStream random(1);
    for (int i = 0; i < 200; ++i) {
        const auto [x, y] = random.uniform_2d();
        CHECK(s.hit_by(low + Vec3(0.4F * x - 0.2F, 0.4F * y - 0.2F, 1), kDown).irradiance == 1);
    }
}

TEST_CASE("patches that begin after the count, as by movement, are uniform") {
    const RayScene rays(room());
    IrradianceMap map(rays, kPatch_m);
    constexpr std::uint32_t kCounted = 32;  // fills the memory of its flags, for the sanitizer
    const Vec3 point(0.1F, 0.1F, tolerances::kOffset_m);
    for (int i = 0; i < 100; ++i) map.add_hit(kCounted - 1, 0, point, -kDown);
    const std::vector<float> area_m2(kCounted, static_cast<float>(kPatch_m2));
    map.finish(area_m2, [](const Vec3&, const Vec3&) { return kCounted - 1; });
    CHECK(map.relative(kCounted - 1, 0, point, -kDown) > 1);  // all hits are in one part
    for (const std::uint32_t patch : {kCounted, kCounted + 1, 2 * kCounted}) {
        CHECK(map.relative(patch, 0, point, -kDown) == 1);
    }
}

TEST_CASE(
    "a triangle with one edge longer than a piece is divided, whichever corner is the first") {
    // Pieces of an eighth of a metre; two of the edges are shorter.
    const std::array<Vec3, 3> corners{Vec3(0.01F, 0, 1), Vec3(0.21F, 0, 1), Vec3(0.11F, 0.05F, 1)};
    // The plane is a border of pieces: the two sides of the triangle lie in different ones.
    for (const auto& [first, side] :
         {std::pair{0U, 1.0F}, {1U, 1.0F}, {2U, 1.0F}, {0U, -1.0F}, {1U, -1.0F}, {2U, -1.0F}}) {
        CAPTURE(first, side);
        const Vec3 normal(0, 0, side);
        Object triangle;
        for (std::size_t k = 0; k < 3; ++k) triangle.vertices.push_back(corners[(first + k) % 3]);
        triangle.triangles = {{0, 1, 2}};
        triangle.triangle_materials = {0};
        const RayScene rays(test::grey_room(triangle, 0.1F, 1, kInside, kInside));
        IrradianceMap map(rays, kPatch_m);
        // One patch, 1000 of whose 1010 hits are on the left.
        const Vec3 left(0.09F, 0.01F, 1 + side * tolerances::kOffset_m);
        const Vec3 right(0.17F, 0.01F, 1 + side * tolerances::kOffset_m);
        for (int i = 0; i < 1000; ++i) map.add_hit(0, 0, left, normal);
        for (int i = 0; i < 10; ++i) map.add_hit(0, 0, right, normal);
        const std::array<float, 1> area_m2{0.005F};
        map.finish(area_m2, [](const Vec3&, const Vec3&) { return 0U; });
        // The left piece has 1000 / 1010 of the hits on (0.005 - 0.5 0.085^2 / 2) / 0.005 of the
        // area: the slope of the right edge is 1 in 2. The prior is a quarter of a hit.
        const double left_m2 = 0.005 - 0.25 * 0.085 * 0.085;
        CHECK(map.relative(0, 0, left, normal) ==
              Approx(1000.25 / (left_m2 / 0.005 * 1010 + 0.25)).epsilon(1e-3));
        CHECK(map.relative(0, 0, right, normal) ==
              Approx(10.25 / ((0.005 - left_m2) / 0.005 * 1010 + 0.25)).epsilon(1e-3));
    }
}

TEST_CASE("a group of small triangles has a limited area and no fold") {
    // A strip of small squares along x, rising to a ridge in its middle or flat.
    for (const float slope : {0.0F, 3.0F}) {
        CAPTURE(slope);
        constexpr int kSquares = 64;
        constexpr float kSquare_m = 0.01F;
        Object strip;
        for (int i = 0; i <= kSquares; ++i) {
            const float x = kSquare_m * static_cast<float>(i);
            const float z = 1 + slope * std::min(x, kSquares * kSquare_m - x);
            strip.vertices.push_back(Vec3(x, 0, z));
            strip.vertices.push_back(Vec3(x, kSquare_m, z));
        }
        for (std::uint32_t i = 0; i < kSquares; ++i) {
            strip.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
            strip.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
        }
        strip.triangle_materials.resize(strip.triangles.size(), 0);
        const RayScene rays(test::grey_room(strip, 0.1F, 1, kInside, kInside));
        IrradianceMap map(rays, kPatch_m);
        const auto at = [&](std::uint32_t triangle) {
            const auto& v = rays.triangle(triangle).vertices;
            return (v[0] + v[1] + v[2]) / 3.0F;
        };
        // All in one patch, whose left half is hit. Sixteen hits are expected on 16 / hits of the
        // area of a full patch: flat, that is a sixteenth of the strip, and otherwise more than one
        // slope.
        const int hits = slope == 0 ? 10'000 : 250;
        for (int i = 0; i < hits; ++i) {
            const auto t = static_cast<std::uint32_t>(i % kSquares);
            map.add_hit(0, t, at(t), rays.triangle(t).normal);
        }
        const float area_m2 = 2 * kSquares * rays.triangle(0).area_m2();
        map.finish({&area_m2, 1}, [](const Vec3&, const Vec3&) { return 0U; });
        const auto relative = [&](std::uint32_t t) {
            return map.relative(0, t, at(t), rays.triangle(t).normal);
        };
        CHECK(relative(4) == Approx(2).margin(0.2));
        CHECK(relative(2 * kSquares - 5) < 0.1F);
    }
}

}  // namespace irradiance_map_test
