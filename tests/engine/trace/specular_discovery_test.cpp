#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <utility>
#include <vector>

#include "engine/base/sampling.h"
#include "engine/trace/specular_paths.h"
#include "engine/trace/specular_sum.h"
#include "tests/engine/trace/mirror_rooms.h"
#include "tests/support/rooms.h"

using namespace aula;
using namespace aula::test;

TEST_CASE("discovery finds the same paths as the full list") {
    const Scene plain = scene_of({mirror_box(kSize)});
    const RayScene plain_rays(plain);
    auto listed =
        SpecularPaths(plain_rays, 3, kRadius_m, 1).find(kSource, kListener, true, Bands{}).paths;

    // 100 mirrors far away, no two coplanar: too many sequences to list beyond order 1.
    Scene cluttered = plain;
    cluttered.objects.push_back(far_mirrors(100));
    const RayScene rays(cluttered);
    SpecularPaths specular(rays, 3, kRadius_m, 1);
    CHECK(specular.find(kSource, kListener, true, Bands{}).paths.size() < listed.size());
    // Each of the 62 paths covers at least some per mille of the sphere; 20 frames of 512 rays.
    std::vector<SoundPath> found;
    for (std::uint64_t frame = 0; frame < 20; ++frame) {
        specular.discover(kListener, frame);
        found = specular.find(kSource, kListener, true, Bands{}).paths;
    }
    REQUIRE(found.size() == listed.size());
    // Paths of equal length are ordered by their keys, which depend on the scene.
    const auto by_energy = [](const SoundPath& p, const SoundPath& q) {
        return std::pair(p.length_m, p.energy[0]) < std::pair(q.length_m, q.energy[0]);
    };
    std::sort(listed.begin(), listed.end(), by_energy);
    std::sort(found.begin(), found.end(), by_energy);
    for (std::size_t i = 0; i < found.size(); ++i) {
        CHECK(found[i].length_m == listed[i].length_m);
        CHECK(found[i].energy == listed[i].energy);
    }
}

TEST_CASE("the same calls find the same paths, with any number of threads") {
    Scene scene = scene_of({mirror_box(kSize)});
    Object clutter;
    RandomStream random(7);
    for (int i = 0; i < 150; ++i) {
        const auto xy = random.uniform_2d();
        const Vec3 at = Vec3(xy[0], xy[1], random.uniform()) * (kSize - 0.3F);
        add_quad(clutter, {at, at + 0.2F * uniform_direction(random.uniform_2d()),
                           at + 0.2F * uniform_direction(random.uniform_2d()), at});
    }
    scene.objects.push_back(clutter);
    const RayScene rays(scene);
    SpecularPaths a(rays, 3, kRadius_m, 1);
    SpecularPaths b(rays, 3, kRadius_m, 1);
    WorkerPool workers(3);
    for (std::uint64_t frame = 0; frame < 10; ++frame) {
        const Vec3 listener = kListener - Vec3(0.1F * static_cast<float>(frame), 0, 0);
        a.discover(listener, frame);
        b.discover(listener, frame, &workers);
        const SpecularSound sound = a.find(kSource, listener, true, Bands{});
        const SpecularSound of_threads = b.find(kSource, listener, true, Bands{}, &workers);
        const std::vector<SoundPath>& from_a = sound.paths;
        CHECK(ids(from_a) == ids(of_threads.paths));
        CHECK(sound.tried.size() > 50);
        CHECK(sound.tried == of_threads.tried);
        CHECK(ids(from_a).size() == from_a.size());
        CHECK(std::is_sorted(from_a.begin(), from_a.end(),
                             [](const auto& x, const auto& y) { return x.length_m < y.length_m; }));
    }
}

TEST_CASE("valid paths are kept while rays discover others") {
    // Many small mirrors in a room: more sequences than are kept.
    Scene scene = scene_of({mirror_box(kSize)});
    Object clutter;
    RandomStream random(9);
    for (int i = 0; i < 300; ++i) {
        const auto xy = random.uniform_2d();
        const Vec3 at = Vec3(xy[0], xy[1], random.uniform()) * (kSize - 0.4F);
        const Vec3 u = 0.3F * uniform_direction(random.uniform_2d());
        const Vec3 v = 0.3F * uniform_direction(random.uniform_2d());
        add_quad(clutter, {at, at + u, at + u + v, at + v});
    }
    scene.objects.push_back(clutter);
    const RayScene rays(scene);
    SpecularPaths specular(rays, 3, kRadius_m, 1);
    std::set<std::uint64_t> before;
    for (std::uint64_t frame = 0; frame < 40; ++frame) {
        specular.discover(kListener, frame);
        const auto now = ids(specular.find(kSource, kListener, true, Bands{}).paths);
        CHECK(std::includes(now.begin(), now.end(), before.begin(), before.end()));
        before = now;
    }
    CHECK(before.size() > 10);
}

TEST_CASE("energy of a ray counts if its image is not tried") {
    // 100 mirrors far away: sequences above order 1 are not listed.
    Scene scene = scene_of({mirror_box(kSize)});
    scene.objects.push_back(far_mirrors(100));
    const RayScene rays(scene);
    SpecularPaths specular(rays, 3, kRadius_m, 1);
    CHECK(specular.listed_order() == 1);
    specular.discover(kListener, 0);
    const SpecularSound tried = specular.find(kSource, kListener, false, Bands{});
    const auto& paths = tried.paths;
    const auto found =
        std::find_if(paths.begin(), paths.end(), [](const SoundPath& p) { return p.order > 1; });
    REQUIRE(found != paths.end());
    CHECK(tried.has_tried(found->key));
    CHECK_FALSE(tried.has_tried(0));

    const auto silent = EnergyResponse::silent(TimeBins(0.1));
    SpecularSum sum(silent);
    sum.add_rays(4);
    sum.add({Bands{}, Vec3(1, 0, 0), 0}, Bands::filled(1), 10);
    sum.add({Bands{}, Vec3(0, 1, 0), found->key}, Bands::filled(2), 10);
    sum.add({Bands{}, Vec3(0, 1, 0), found->key}, Bands::filled(2), 10.2F);
    const auto read = [&](const SpecularSound& images) {
        EnergyResponse response = silent;
        sum.add_to(images, response);
        return response;
    };
    CHECK(read(tried).total(0) == Approx(0.25));
    specular.restart(1);  // removes all discovered sequences
    const SpecularSound none = specular.find(kSource, kListener, false, Bands{});
    CHECK_FALSE(none.has_tried(found->key));
    const EnergyResponse response = read(none);
    CHECK(response.total(0) == Approx(1.25));
    // Both hits of the sequence count at their mean length.
    const std::size_t bin = response.bins.index(10.1 / double{response.speed_of_sound_m_s});
    CHECK(response.energy[bin][0] == Approx(bin == response.bins.index(10 / 343.2) ? 1.25 : 1));
    CHECK(response.directions[bin].intensity.y == Approx(8.0));
    sum.clear();
    sum.add_rays(4);
    CHECK(read(none).total(0) == 0);
}

TEST_CASE("candidates that rays along them may still reach are kept, whether valid or not") {
    // If only valid ones were kept, rays beside the paths of the sphere's centre would count in
    // addition.
    const RayScene rays(scene_of({bumpy_box(Vec3(12, 9, 5), 0.5F, 0.005F)}));
    SpecularPaths specular(rays, 3, kRadius_m, 1);
    std::set<std::uint64_t> before;
    for (std::uint64_t frame = 0; frame < 12; ++frame) {
        specular.discover(kListener, frame);
        const auto now = ids(specular.find(kSource, kListener, true, Bands{}).paths);
        CHECK(std::includes(now.begin(), now.end(), before.begin(), before.end()));
        before = now;
    }
    // Listeners 0.3 m away find paths that were not valid here, without a chain from there.
    SpecularPaths other(rays, 3, kRadius_m, 1);
    for (std::uint64_t frame = 0; frame < 12; ++frame) {
        other.discover(kListener, frame);
        other.find(kSource, kListener, true, Bands{});
    }
    std::size_t more = 0;
    for (const Vec3& offset : {Vec3(0.3F, 0, 0.1F), Vec3(-0.3F, 0.1F, 0), Vec3(0, 0.3F, 0.1F),
                               Vec3(0.1F, -0.3F, 0), Vec3(0.1F, 0, 0.3F), Vec3(0, 0.1F, -0.3F)}) {
        const auto beside = ids(other.find(kSource, kListener + offset, true, Bands{}).paths);
        more += static_cast<std::size_t>(std::count_if(
            beside.begin(), beside.end(), [&](std::uint64_t id) { return before.count(id) == 0; }));
    }
    CAPTURE(more, before.size());
    // 38; if only valid candidates were kept, those discovered in the last frame would give 24.
    CHECK(more >= 31);
}
