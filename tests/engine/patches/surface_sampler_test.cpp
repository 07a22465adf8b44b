#include "engine/patches/surface_sampler.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <numeric>
#include <set>

#include "engine/base/sampling.h"
#include "tests/support/rooms.h"

namespace surface_sampler_test {

using namespace aula;

namespace {

struct Sampled {
    RayScene rays;
    CellGrid grid;
    PatchIndex index;
    SurfaceSampler sampler{rays, grid, index, 1};

    explicit Sampled(const Object& object)
        : rays(test::grey_room(object, 0.1F, 1, Vec3(1), Vec3(1))), grid(rays, 0.5F) {}

    std::vector<SurfaceSample> all(int per_cell) {
        std::vector<std::uint32_t> triangles(rays.triangle_count());
        std::iota(triangles.begin(), triangles.end(), 0U);
        return sampler.sample(triangles, per_cell, [](std::uint32_t) { return 1.0F; });
    }
};

double area_m2(const std::vector<SurfaceSample>& samples) {
    double sum = 0;
    for (const SurfaceSample& s : samples) sum += double{s.area_m2};
    return sum;
}

/// Every triangle in four, `times` over.
Object tessellated(Object object, int times) {
    const auto middle = [](const Vec3& a, const Vec3& b) { return (a + b) * 0.5F; };
    for (int i = 0; i < times; ++i) object = test::quartered(std::move(object), middle);
    return object;
}

}  // namespace

TEST_CASE("the samples of both sides of a surface have its area and are in their patches") {
    for (const Object& object :
         {test::box(Vec3(5, 4, 3), 0, Vec3(0.123F, -0.077F, 0.31F)), test::icosphere(2, 3)}) {
        Sampled s(object);
        const std::vector<SurfaceSample> samples = s.all(16);
        // Single precision over some thousand sums.
        CHECK(area_m2(samples) == Approx(2 * test::surface_m2(object)).epsilon(1e-4));
        std::size_t elsewhere = 0;
        for (const SurfaceSample& sample : samples) {
            const std::uint64_t key = s.grid.key_at(sample.nudged_off_surface(), sample.normal);
            elsewhere += s.index.find(key) == sample.patch ? 0 : 1;
        }
        // Points at the borders of cells may round to the other side.
        CHECK(elsewhere <= samples.size() / 1000);
    }
}

TEST_CASE("a full cell has as many samples as are asked for, of equal area") {
    Sampled s(test::box(Vec3(4, 2, 1)));
    std::map<std::uint32_t, int> of_patch;
    // Both triangles of a wall share the cells along its diagonal; the others are whole.
    for (const SurfaceSample& sample : s.all(16)) of_patch[sample.patch] += 1;
    const auto whole = std::count_if(of_patch.begin(), of_patch.end(),
                                     [](const auto& patch) { return patch.second == 16; });
    CHECK(of_patch.size() == 2 * 28 * 4);
    CHECK(static_cast<double>(whole) > 0.6 * static_cast<double>(of_patch.size()));
    for (const auto& [patch, count] : of_patch) {
        CHECK(count >= 16);
        CHECK(count <= 18);
    }
}

TEST_CASE("a patch with a share of the samples has as many fewer, of the same area in all") {
    const Object box = test::box(Vec3(4, 2, 1));
    Sampled s(box);
    std::vector<std::uint32_t> triangles(s.rays.triangle_count());
    std::iota(triangles.begin(), triangles.end(), 0U);
    const auto share_of = [](std::uint32_t patch) { return patch % 2 == 0 ? 1 : 0.25F; };
    std::map<std::uint32_t, int> of_patch;
    const std::vector<SurfaceSample> samples = s.sampler.sample(triangles, 16, share_of);
    for (const SurfaceSample& sample : samples) of_patch[sample.patch] += 1;
    CHECK(area_m2(samples) == Approx(2 * test::surface_m2(box)).epsilon(1e-4));
    for (const auto& [patch, count] : of_patch) {
        CHECK(count >= (patch % 2 == 0 ? 16 : 4));
        CHECK(count <= (patch % 2 == 0 ? 18 : 6));
    }
}

TEST_CASE("samples follow area, not triangles, and small parts share one by area") {
    const Object box = test::box(Vec3(2, 2, 2), 0, Vec3(0.1F, 0.2F, 0.3F));
    Sampled coarse(box);
    Sampled fine(tessellated(box, 6));
    const std::vector<SurfaceSample> few = coarse.all(4);
    const std::vector<SurfaceSample> many = fine.all(4);
    CHECK(area_m2(many) == Approx(2 * test::surface_m2(box)).epsilon(1e-4));
    // Slivers at the rims have at least one sample each, whatever the triangles.
    CHECK(static_cast<double>(many.size()) ==
          Approx(static_cast<double>(few.size())).epsilon(0.25));
    // The companion: the parts are many more.
    std::size_t parts = 0;
    for (std::uint32_t t = 0; t < fine.rays.triangle_count(); ++t) {
        fine.sampler.for_each_patch(t, [&](std::uint32_t, const Vec3&, float) { ++parts; });
    }
    CHECK(parts > 20 * many.size());
    // Only patches that are wanted have samples.
    const std::vector<std::uint32_t> first{0};
    CHECK(coarse.sampler.sample(first, 4, [](std::uint32_t) { return 0.0F; }).empty());
}

TEST_CASE("the samples of faces that cross each other are limited by the number of patches") {
    constexpr int kPerCell = 64;
    std::map<int, double> per_patch;
    for (const int faces : {300, 3000}) {
        RandomStream random(1);
        Object soup;
        for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(faces); ++i) {
            for (int corner = 0; corner < 3; ++corner) {
                const auto xy = random.uniform_2d();
                soup.vertices.push_back(Vec3(5, 4, 3) * Vec3(xy[0], xy[1], random.uniform()));
            }
            soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        }
        soup.triangle_materials.assign(soup.triangles.size(), 0);
        Sampled s(soup);
        const std::vector<SurfaceSample> samples = s.all(kPerCell);
        // Single precision over a million sums.
        CHECK(area_m2(samples) == Approx(2 * test::surface_m2(soup)).epsilon(1e-3));
        std::set<std::uint32_t> patches;
        for (const SurfaceSample& sample : samples) patches.insert(sample.patch);
        per_patch[faces] =
            static_cast<double>(samples.size()) / static_cast<double>(patches.size());
        // The number of a part is rounded up.
        CHECK(per_patch[faces] < 1.5 * kPerCell * SurfaceSampler::kFullCells);
    }
    CHECK(per_patch[3000] < 1.2 * per_patch[300]);
}

}  // namespace surface_sampler_test
