#include "engine/patches/patch_subdivision.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <tuple>

#include "engine/base/sampling.h"
#include "engine/trace/path_identifier.h"
#include "tests/support/rooms.h"

using namespace aula;

namespace {

/// One triangle with a 3 m base on the x axis and its apex 5 m above the base's middle.
Scene one_triangle() {
    Object object;
    object.vertices = {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(1.5F, 5, 0)};
    object.triangles = {{0, 1, 2}};
    object.triangle_materials = {0};
    return test::grey_room(object, 0.1F, 1, Vec3(0, 0, 1), Vec3(0, 0, 2));
}

Hit random_hit(RandomStream& random) {
    auto [u, v] = random.uniform_2d();
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    return {0, 1, u, v};
}

}  // namespace

TEST_CASE("the key vertex faces the shortest edge, rows and columns follow lambda") {
    const Scene scene = one_triangle();
    const RayScene rays(scene);
    const PatchSubdivision::Grid grid = PatchSubdivision(rays, 0.7F).grid(0);
    CHECK(grid.key_vertex == 2);
    CHECK(grid.rows == 8);     // ceil(5 / 0.7)
    CHECK(grid.columns == 5);  // ceil(3 / 0.7)
}

TEST_CASE("every row has the columns of Eq. 3.1, and all of them are hit") {
    const Scene scene = one_triangle();
    const RayScene rays(scene);
    const PatchSubdivision subdivision(rays, 0.7F);
    std::map<std::uint32_t, std::set<std::uint32_t>> met;
    RandomStream random(1);
    // The smallest patch holds about 1/500 of the area: 10^5 points miss it with e^-200.
    for (int i = 0; i < 100000; ++i) {
        const Patch patch = subdivision.patch(random_hit(random), false);
        met[patch.zeta].insert(patch.xi);
    }
    REQUIRE(met.size() == 8);
    for (const auto& [zeta, columns] : met) {
        const std::uint32_t expected = ((8 - zeta) * 5 + 7) / 8;  // ceil((8 - zeta) / 8 * 5)
        CHECK(columns.size() == expected);
        CHECK(*columns.rbegin() == expected - 1);
    }
}

TEST_CASE("no patch is larger than lambda along the base and the altitude") {
    const Scene scene = one_triangle();
    const RayScene rays(scene);
    const PatchSubdivision subdivision(rays, 0.7F);
    std::map<std::tuple<std::uint32_t, std::uint32_t>, std::pair<Vec3, Vec3>> extent;
    RandomStream random(2);
    for (int i = 0; i < 100000; ++i) {
        const Hit hit = random_hit(random);
        const Patch patch = subdivision.patch(hit, false);
        // The patch is skewed along the left edge; undo the skew to measure its width.
        const auto& v = rays.triangle(0).vertices;
        Vec3 p = v[0] + hit.u * (v[1] - v[0]) + hit.v * (v[2] - v[0]);
        p.x += p.y * 1.5F / 5;
        const auto [entry, added] = extent.try_emplace({patch.zeta, patch.xi}, std::pair(p, p));
        entry->second.first = glm::min(entry->second.first, p);
        entry->second.second = glm::max(entry->second.second, p);
    }
    for (const auto& [patch, bounds] : extent) {
        const Vec3 size = bounds.second - bounds.first;
        CHECK(size.x <= 0.7F + 1e-5F);  // rounding
        CHECK(size.y <= 0.7F + 1e-5F);
    }
}

TEST_CASE("the two sides of a triangle are two patches") {
    const Scene scene = one_triangle();
    const RayScene rays(scene);
    const PatchSubdivision subdivision(rays, 0.7F);
    const Hit hit{0, 1, 0.2F, 0.3F};
    CHECK_FALSE(subdivision.patch(hit, false) == subdivision.patch(hit, true));
}

TEST_CASE("path identifiers of all short patch sequences differ in both words") {
    // 24 patches of a box's 12 triangles with both sides: 24 + 24^2 + 24^3 + 24^4 sequences. In
    // each 64-bit word a collision among 3.5e5 has odds of 3e-9.
    std::set<std::uint64_t> low;
    std::set<std::uint64_t> high;
    std::size_t count = 0;
    const auto visit = [&](const auto& self, const PathIdentifier& path, int depth) -> void {
        for (std::uint32_t t = 0; t < 12; ++t) {
            for (const bool back : {false, true}) {
                const PathIdentifier longer = path.extended({t, t % 3, t % 2, back});
                low.insert(longer.low);
                high.insert(longer.high);
                ++count;
                if (depth < 4) self(self, longer, depth + 1);
            }
        }
    };
    visit(visit, PathIdentifier::start(0), 1);
    CHECK(low.size() == count);
    CHECK(high.size() == count);
}

TEST_CASE("a path identifier depends on source, order of patches and listener") {
    const Patch a{1, 2, 3, false};
    const Patch b{3, 2, 1, false};
    const PathIdentifier path = PathIdentifier::start(0).extended(a).extended(b);
    CHECK_FALSE(path == PathIdentifier::start(0).extended(b).extended(a));
    CHECK_FALSE(path == PathIdentifier::start(1).extended(a).extended(b));
    // Rows and columns have 32 bits each.
    const auto at = [&](std::uint32_t zeta, std::uint32_t xi) {
        return PathIdentifier::start(0).extended({1, zeta, xi, false});
    };
    for (std::uint32_t bit = 0; bit < 32; ++bit) {
        CHECK_FALSE(at(0, std::uint32_t{1} << bit) == at(1, 0));
        CHECK_FALSE(at(std::uint32_t{1} << bit, 0) == at(0, 0));
    }
    CHECK_FALSE(path.ended(0) == path.ended(1));
}
