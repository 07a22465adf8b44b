#include "engine/patches/patch_grid.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "engine/base/sampling.h"
#include "tests/engine/patches/surveyed.h"
#include "tests/support/rooms.h"

using namespace aula;
using aula::test::room;
using aula::test::Surveyed;

TEST_CASE("the patches of a box have its surface, also where walls lie on cell borders") {
    // A corner at the origin and sides that are multiples of the patch size; and one off the grid.
    for (const Vec3& corner : {Vec3(0), Vec3(0.123F, -0.077F, 0.31F)}) {
        const Object object = test::box(Vec3(5, 4, 3), 0, corner);
        const Vec3 inside = corner + Vec3(2, 2, 1.4F);
        Surveyed s(room(object, inside), 0.5F, inside);
        // Areas are exact by clipping; single precision over a few hundred sums. 10^5 rays hit all
        // cells of 0.25 m2; slivers at the border of an unaligned box may be missed.
        CHECK(s.seen_area_m2(inside, 100000) ==
              Approx(test::surface_m2(object)).epsilon(corner == Vec3(0) ? 1e-4 : 5e-3));
    }
}

TEST_CASE(
    "points near a wall have the same patch for any position of the wall within a millimetre") {
    // A box outside determines the origin of the grid, so that no wall of the room is there.
    for (int k = 0; k < 20; ++k) {
        const float corner_m = 1 + 5e-5F * static_cast<float>(k);
        const Vec3 inside(3, 3, 2.4F);
        Scene scene = room(test::box(Vec3(5, 4, 3), 0, Vec3(corner_m)), inside);
        scene.objects.push_back(test::box(Vec3(8, 8, 8)));
        Surveyed s(scene, 0.5F, inside);
        for (const bool high : {false, true}) {
            const Vec3 normal(high ? -1.0F : 1.0F, 0, 0);
            const Vec3 wall(corner_m + (high ? 5.0F : 0.0F), 2.2F, 2.2F);
            const std::uint32_t near =
                s.grid.find(wall + RayScene::offset_after(0) * normal, normal);
            CAPTURE(k, high);
            REQUIRE(near != PatchGrid::kNone);
            CHECK(s.grid.area_m2(near) == Approx(0.25).epsilon(1e-3));
            // Exact: after longer rays points are off the wall by a few micrometres more.
            for (const float distance_m : {1.0F, 3.0F, 8.0F}) {
                CHECK(s.grid.find(wall + RayScene::offset_after(distance_m) * normal, normal) ==
                      near);
            }
        }
    }
}

TEST_CASE("a duplicate wall counts once") {
    const Vec3 inside(2, 2, 1.4F);
    Scene scene = room(test::box(Vec3(5, 4, 3)), inside);
    scene.objects.push_back(test::box(Vec3(5, 4, 3)));
    Surveyed s(scene, 0.5F, inside);
    CHECK(s.seen_area_m2(inside, 100000) == Approx(94).epsilon(1e-3));
}

TEST_CASE("a floor under a solid does not count") {
    const Vec3 inside(1, 1, 2);
    Scene scene = room(test::box(Vec3(5, 4, 3)), inside);
    scene.objects.push_back(test::box(Vec3(2, 2, 1), 0, Vec3(2.13F, 1.13F, 0)));
    Surveyed s(scene, 0.5F, inside);
    // The floor loses the 4 m2 under the block. Not all of its sides are visible from one point:
    // patches are counted from several points.
    std::set<std::uint32_t> seen;
    double area = 0;
    for (const Vec3& from : {Vec3(1, 1, 2), Vec3(4.8F, 3.8F, 2), Vec3(1, 3.6F, 0.5F),
                             Vec3(4.6F, 0.5F, 0.5F), Vec3(2.5F, 2, 2.5F)}) {
        RandomStream random(1);
        std::vector<Ray> queries(100000);
        for (Ray& ray : queries) ray = {from, uniform_direction(random.uniform_2d())};
        std::vector<Hit> hits(queries.size());
        s.rays.intersect(queries, hits);
        for (std::size_t i = 0; i < hits.size(); ++i) {
            const std::uint32_t patch =
                s.grid.find(s.rays.point(hits[i], queries[i].direction),
                            s.rays.facing_normal(hits[i], queries[i].direction));
            if (seen.insert(patch).second) area += double{s.grid.area_m2(patch)};
        }
    }
    // 94 m2 of the room, less 4 under the block, plus 4 + 8 of the block. Cells that the block cuts
    // are sampled with 16 points: 28 such cells of 0.25 m2 with a spread of 0.12 m2 / 4 each.
    CHECK(area == Approx(94 - 4 + 12).margin(1));
    CHECK(area < 94 + 12 - 2);  // companion: the hidden floor is not in it
}

TEST_CASE("outdoors the patches that no walk hits have their area, also beside a solid") {
    // A field of 160 m with a block far away, of which a walk over the field meets little.
    const Vec3 inside(0, 0, 1.5F);
    Scene scene = room(test::box(Vec3(160, 160, 1), 0, Vec3(-80, -80, -1)), inside);
    scene.objects.push_back(test::box(Vec3(10, 10, 5), 0, Vec3(60.3F, 60.3F, 0)));
    Surveyed s(scene, 1, inside);
    double top_m2 = 0;
    std::size_t tops = 0;
    for (std::uint32_t patch = 0; patch < s.grid.size(); ++patch) {
        const PatchCell cell = s.grid.cell(patch);
        if (cell.direction.z <= 0 || cell.low.z > 1) continue;
        top_m2 += double{s.grid.area_m2(patch)};
        ++tops;
    }
    // The 100 m2 under the block are not reached. Of the 40 cells that its sides cut, of 1 m2, each
    // has four samples with a spread of at most 0.5 m2 / 2.
    CHECK(top_m2 == Approx(160 * 160 - 100).margin(3 * 0.25 * std::sqrt(40)));
    CHECK(s.grid.reached() < tops / 2);  // companion: most patches are not hit
}

TEST_CASE("outdoors panels divide the patches that walks hit, and no area is lost") {
    // A field with a fence beside the source and one far away.
    const Vec3 inside(0, 0, 1.5F);
    const auto fence = [](float x_m) {
        Object object;
        object.vertices = {{x_m, -5, 0}, {x_m + 1, 5, 0}, {x_m + 1, 5, 2}, {x_m, -5, 2}};
        object.triangles = {{0, 1, 2}, {0, 2, 3}};
        object.triangle_materials = {0, 0};
        return object;
    };
    Scene scene = room(test::box(Vec3(160, 160, 1), 0, Vec3(-80, -80, -1)), inside);
    scene.objects.push_back(fence(3.3F));
    scene.objects.push_back(fence(70.3F));
    for (const double max_rows : {std::numeric_limits<double>::infinity(), 5000.0}) {
        Surveyed s(scene, 1, inside, max_rows);
        CHECK(static_cast<double>(s.grid.reached_rows()) <= max_rows);
        // Each of the ten cells along the fence at least has patches with two sides.
        CHECK(s.grid.reached_rows() > s.grid.reached() + 5);
        double top_m2 = 0;
        for (std::uint32_t patch = 0; patch < s.grid.size(); ++patch) {
            const PatchCell cell = s.grid.cell(patch);
            if (cell.direction.z > 0 && cell.low.z < 0.1F) top_m2 += double{s.grid.area_m2(patch)};
        }
        CHECK(top_m2 == Approx(160 * 160).epsilon(1e-3));
    }
}

TEST_CASE("the number of patches depends on area, not on triangles") {
    const Vec3 inside(0.1F, 0.2F, 0);
    Surveyed coarse(room(test::icosphere(3, 3), inside), 0.5F, inside);
    Surveyed fine(room(test::icosphere(3, 5), inside), 0.5F, inside);
    CHECK(static_cast<double>(fine.grid.reached()) ==
          Approx(static_cast<double>(coarse.grid.reached())).epsilon(0.1));
}

namespace {

/// Every triangle divided into four, `times` times.
Object tessellated(Object object, int times) {
    const auto middle = [](const Vec3& a, const Vec3& b) { return (a + b) * 0.5F; };
    for (int i = 0; i < times; ++i) object = test::quartered(std::move(object), middle);
    return object;
}

}  // namespace

TEST_CASE("a box of 12 triangles and one of 200 000 have the same patches") {
    const Vec3 inside(2, 2, 1.4F);
    const Object box = test::box(Vec3(5, 4, 3), 0, Vec3(0.123F, -0.077F, 0.31F));
    const Object fine = tessellated(box, 7);
    REQUIRE(fine.triangles.size() == 12 * 16384);
    Surveyed few(room(box, inside), 0.5F, inside);
    Surveyed many(room(fine, inside), 0.5F, inside);
    // Random walks find the patches; they may miss slivers at the rims.
    CHECK(static_cast<double>(many.grid.reached()) ==
          Approx(static_cast<double>(few.grid.reached())).epsilon(0.03));
    // Companion: there are four times as many patches of half the width.
    Surveyed narrow(room(box, inside), 0.25F, inside);
    CHECK(static_cast<double>(narrow.grid.reached()) > 3 * static_cast<double>(few.grid.reached()));
}

TEST_CASE("patches are as large as their maximum number requires, with the same total area") {
    const Vec3 inside(2, 2, 1.4F);
    const Scene scene = room(test::box(Vec3(5, 4, 3)), inside);
    Surveyed few(scene, 0.25F, inside, 400);
    CHECK(few.grid.reached() <= 400);
    // Exact: sizes increase in steps of a quarter, which reduces the number by 1.6; walls have at
    // most one more row at their ends.
    CHECK(static_cast<double>(few.grid.reached()) > 400 / 1.6 / 1.2);
    CHECK(few.seen_area_m2(inside, 100000) == Approx(94).epsilon(1e-3));
    // Companion: at the requested size there are 94 / 0.0625.
    Surveyed all(scene, 0.25F, inside);
    CHECK(all.grid.patch_size_m() == 0.25F);
    CHECK(all.grid.reached() == 1504);
}

TEST_CASE("the extent of a grid is that of the complete grid") {
    const Vec3 inside(2, 2, 1.4F);
    const Scene scene = room(test::box(Vec3(5, 4, 3), 0, Vec3(0)), inside);
    for (const double max : {100.0, 1e5}) {
        const Surveyed s(scene, 0.25F, inside, max);
        const PatchGrid::Extent extent = PatchGrid::extent(s.rays, 0.25F, {&inside, 1}, 1, max);
        CHECK(extent.reached == s.grid.reached());
        CHECK(extent.patch_size_m == s.grid.patch_size_m());
    }
}
