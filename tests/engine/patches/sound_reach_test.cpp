#include "engine/patches/sound_reach.h"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/rooms.h"

namespace sound_reach_test {

using namespace aula;

namespace {

const Vec3 kInside(1, 1, 2);

Scene room() { return test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1, kInside, kInside); }

/// The scene in a closed box: without it the outer sides of walls would reach the open.
Scene enclosed(Scene scene) {
    scene.objects.push_back(test::box(Vec3(9, 8, 7), 0, Vec3(-2)));
    return scene;
}

/// The surfaces of a scene and the part of them that sound from kInside reaches.
struct Reached {
    RayScene rays;
    WorkerPool workers{1};
    CellGrid grid;
    PatchIndex index;
    SurfaceSampler sampler{rays, grid, index, 1};
    SoundReach reach{rays, grid, index, 1};
    std::vector<SurfaceSample> samples;
    bool marked = false;

    explicit Reached(const Scene& scene,
                     double max_patches = std::numeric_limits<double>::infinity())
        : rays(enclosed(scene)), grid(rays, 0.5F) {
        std::vector<std::uint32_t> triangles;
        for (std::uint32_t t = 0; t < rays.triangle_count(); ++t) {
            if (rays.triangle(t).object < scene.objects.size()) triangles.push_back(t);
        }
        samples = sampler.sample(triangles, 16, [](std::uint32_t) { return 1.0F; });
        IrradianceMap irradiance(rays, grid.size_m());
        ReachWalks walks(rays, {&kInside, 1}, 1);
        marked = reach.mark(walks, max_patches, irradiance);
    }

    /// The area of the samples that sound reaches.
    double area_m2() {
        const std::vector<char> reached = reach.reaches(samples, workers);
        double sum = 0;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            if (reached[i]) sum += double{samples[i].area_m2};
        }
        return sum;
    }
};

}  // namespace

TEST_CASE("sound reaches the inner side of a room's walls and no outer side") {
    Reached s(room());
    CHECK(s.marked);
    CHECK(s.reach.count() == 94 * 4);
    CHECK(s.area_m2() == Approx(94).epsilon(1e-4));
    // The companion: both sides have samples.
    double all = 0;
    for (const SurfaceSample& sample : s.samples) all += double{sample.area_m2};
    CHECK(all == Approx(2 * 94).epsilon(1e-4));
}

TEST_CASE("sound reaches the outside of a closed box in a room, not its inside") {
    Scene scene = room();
    scene.objects.push_back(test::box(Vec3(1), 0, Vec3(3, 2, 1)));
    Reached s(scene);
    CHECK(s.reach.count() == (94 + 6) * 4);
    CHECK(s.area_m2() == Approx(94 + 6).epsilon(1e-4));
    // The companion: without one of its triangles the inside is part of the room. The hole is half
    // of a face, and both of its sides are missing.
    scene.objects.back().triangles.pop_back();
    scene.objects.back().triangle_materials.pop_back();
    CHECK(Reached(scene).area_m2() == Approx(94 + 2 * 5.5).epsilon(0.01));
}

TEST_CASE("of coincident faces sound reaches one") {
    Scene scene = room();
    scene.objects.push_back(scene.objects[0]);
    Reached s(scene);
    CHECK(s.reach.count() == 94 * 4);
    CHECK(s.area_m2() == Approx(94).epsilon(1e-3));
}

TEST_CASE("marking ends where sound reaches more patches than are allowed") {
    CHECK(Reached(room(), 376).marked);
    CHECK_FALSE(Reached(room(), 375).marked);
}

TEST_CASE("grids of several sizes share walks, and mark as with walks of their own") {
    const RayScene rays(room());
    ReachWalks shared(rays, {&kInside, 1}, 1);
    const auto marked = [&](float size_m, ReachWalks& walks) {
        const CellGrid grid(rays, size_m);
        PatchIndex index;
        SurfaceSampler sampler(rays, grid, index, 1);
        for (std::uint32_t t = 0; t < rays.triangle_count(); ++t)
            sampler.for_each_patch(t, [](std::uint32_t, const Vec3&, float) {});
        SoundReach reach(rays, grid, index, 1);
        IrradianceMap irradiance(rays, size_m);
        reach.mark(walks, std::numeric_limits<double>::infinity(), irradiance);
        return reach.count();
    };
    std::size_t traced = 0;
    for (const float size_m : {1.0F, 0.5F, 0.25F}) {
        ReachWalks own(rays, {&kInside, 1}, 1);
        CHECK(marked(size_m, shared) == marked(size_m, own));
        traced += own.traced();
        // Exact: the finest grid so far needs the most rounds.
        CHECK(shared.traced() == own.traced());
    }
    // Companion: alone they trace more.
    CHECK(traced > shared.traced());
}

}  // namespace sound_reach_test
