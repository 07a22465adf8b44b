#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>
#include <set>
#include <vector>

#include "engine/base/sampling.h"
#include "engine/patches/patch_grid.h"
#include "tests/support/rooms.h"

namespace aula::test {

/// The patches of a scene.
struct Surveyed {
    RayScene rays;
    WorkerPool workers{1};
    PatchGrid grid;

    Surveyed(const Scene& scene, float patch_size_m, const Vec3& inside,
             double max_patches = std::numeric_limits<double>::infinity())
        : rays(scene), grid(rays, patch_size_m, {&inside, 1}, 1, workers, max_patches) {}

    /// Sum of the areas of all patches that rays from a point hit.
    double seen_area_m2(const Vec3& from, int count) {
        std::set<std::uint32_t> seen;
        RandomStream random(1);
        std::vector<Ray> queries(static_cast<std::size_t>(count));
        for (Ray& ray : queries) ray = {from, uniform_direction(random.uniform_2d())};
        std::vector<Hit> hits(queries.size());
        rays.intersect(queries, hits);
        double area = 0;
        for (std::size_t i = 0; i < hits.size(); ++i) {
            if (!hits[i].any()) continue;
            const std::uint32_t patch =
                grid.find(rays.point(hits[i], queries[i].direction),
                          rays.facing_normal(hits[i], queries[i].direction));
            REQUIRE(patch != PatchGrid::kNone);
            if (seen.insert(patch).second) area += double{grid.area_m2(patch)};
        }
        return area;
    }
};

inline Scene room(const Object& object, const Vec3& inside) {
    return grey_room(object, 0.1F, 1, inside, inside);
}

}  // namespace aula::test
