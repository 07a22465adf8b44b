#include "engine/direct/near_edges.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <vector>

#include "engine/base/sampling.h"
#include "engine/direct/edge_paths.h"
#include "engine/direct/limits.h"
#include "tests/support/rooms.h"

namespace near_edges_test {

using namespace aula;

namespace {

const Vec3 kSource(-4, 0, 1.5F);
const Vec3 kListener(4, 0, 1.5F);

/// 300 small squares in random places and directions: 1200 edges.
Scene clutter() {
    Scene scene;
    scene.materials = {{"wall", Bands{}, Bands{}}};
    Object object;
    RandomStream random(5);
    for (int i = 0; i < 300; ++i) {
        const Vec3 at(-5 + 10 * random.uniform(), -5 + 10 * random.uniform(), 3 * random.uniform());
        const Vec3 x = 0.2F * uniform_direction(random.uniform_2d());
        const Vec3 y = 0.2F * glm::normalize(glm::cross(x, uniform_direction(random.uniform_2d())));
        const auto first = static_cast<std::uint32_t>(object.vertices.size());
        object.vertices.insert(object.vertices.end(),
                               {at - x - y, at + x - y, at + x + y, at - x + y});
        object.triangles.push_back({first, first + 1, first + 2});
        object.triangles.push_back({first, first + 2, first + 3});
        object.triangle_materials.insert(object.triangle_materials.end(), 2, 0);
    }
    scene.objects.push_back(object);
    return scene;
}

struct Search {
    RayScene rays;
    SceneEdges edges{rays};
    NearEdges near;

    explicit Search(const Scene& scene = clutter()) : rays(scene) {}

    /// The edges to test in a frame, of which none is in use then.
    std::vector<std::uint32_t> frame(const Vec3& source, const Vec3& listener,
                                     std::span<const Bounds> changed = {}) {
        std::vector<std::uint32_t> due;
        for (const std::size_t place : near.begin_frame(edges, source, listener, changed)) {
            near.set(place, {.index = near[place].index, .is_new = false});
            due.push_back(near[place].index);
        }
        return due;
    }

    double detour_m(std::uint32_t index) const {
        double shortest_m = 1e9;
        for (int i = 0; i <= 1000; ++i) {
            const glm::dvec3 point = edges[index].point(1e-3 * i * edges[index].length_m);
            shortest_m = std::min(shortest_m, glm::distance(point, glm::dvec3(kSource)) +
                                                  glm::distance(point, glm::dvec3(kListener)));
        }
        return shortest_m - double{glm::distance(kSource, kListener)};
    }
};

}  // namespace

TEST_CASE("the first frame tests the nearest edges, later ones an eighth of them by turns") {
    Search search;
    REQUIRE(search.edges.count() > 1000);
    const std::vector<std::uint32_t> first = search.frame(kSource, kListener);
    REQUIRE(first.size() == NearEdges::kMax);
    CHECK(std::is_sorted(first.begin(), first.end()));
    // Those of the smallest detours.
    const std::set<std::uint32_t> chosen(first.begin(), first.end());
    double farthest_m = 0;
    double nearest_other_m = 1e9;
    for (std::uint32_t e = 0; e < search.edges.count(); ++e) {
        double& bound_m = chosen.contains(e) ? farthest_m : nearest_other_m;
        const double detour_m = search.detour_m(e);
        bound_m = chosen.contains(e) ? std::max(bound_m, detour_m) : std::min(bound_m, detour_m);
    }
    CHECK(farthest_m < nearest_other_m + 1e-4);  // 1000 points per edge

    std::set<std::uint32_t> tested;
    for (int frame = 0; frame < 8; ++frame) {
        const auto due = search.frame(kSource, kListener);
        // Indices are distributed over the turns nearly evenly.
        CHECK(due.size() < NearEdges::kMax / 4);
        for (const std::uint32_t e : due) CHECK(tested.insert(e).second);
    }
    CHECK(tested == chosen);
}

TEST_CASE("edges that a movement may bring into reach before the next selection are selected") {
    const auto selected = [](float y) {
        Scene scene;
        scene.materials = {{"wall", Bands{}, Bands{}}};
        Object object;
        object.vertices = {{0, y, 0}, {0, y + 9, 0}, {0, y + 9, 3}, {0, y, 3}};
        object.triangles = {{0, 1, 2}, {0, 2, 3}};
        object.triangle_materials = {0, 0};
        scene.objects = {object};
        return !Search(scene).frame(kSource, kListener).empty();
    };
    // At the height h above the middle of two ends that are 2 a m apart.
    const auto detour_m = [](double a, double h) { return 2 * std::hypot(a, h) - 2 * a; };
    int reached = 0;
    int never = 0;
    for (float y = 9; y < 14; y += 0.05F) {
        // Both ends move apart and up, as far as the first selection holds.
        const double moved_m = limits::kSelectAnew_m / std::numbers::sqrt2;
        const bool comes = detour_m(4 + moved_m, double{y} - moved_m) < limits::kLongestDetour_m;
        const bool is_there = detour_m(4, double{y}) < limits::kLongestDetour_m;
        if (comes || is_there) CHECK(selected(y));
        reached += comes && !is_there ? 1 : 0;
        never += selected(y) ? 0 : 1;
    }
    CHECK(reached > 0);
    CHECK(never > 0);
}

TEST_CASE("edges in use are tested in every frame") {
    Search search;
    const auto due = search.near.begin_frame(search.edges, kSource, kListener, {});
    REQUIRE(due.size() == NearEdges::kMax);
    for (const std::size_t place : due)
        search.near.set(place, {.index = search.near[place].index, .is_new = false});
    const auto set_level = [&](std::size_t place, double level_db) {
        search.near.set(place, {.index = search.near[place].index,
                                .is_new = false,
                                .is_free = true,
                                .level_db = level_db});
    };
    set_level(17, 3);
    set_level(18, -20);  // inaudible
    int with_17 = 0;
    int with_18 = 0;
    for (int frame = 0; frame < 8; ++frame) {
        const auto now = search.near.begin_frame(search.edges, kSource, kListener, {});
        with_17 += static_cast<int>(std::count(now.begin(), now.end(), 17U));
        with_18 += static_cast<int>(std::count(now.begin(), now.end(), 18U));
    }
    CHECK(with_17 == 8);
    CHECK(with_18 == 1);
}

TEST_CASE("all edges are tested after a jump, and those near an object that has moved") {
    Search search;
    search.frame(kSource, kListener);
    const std::size_t turn = search.frame(kSource, kListener).size();
    CHECK(search.frame(kSource + Vec3(0.02F, 0, 0), kListener).size() < 2 * turn);
    CHECK(search.frame(kSource + Vec3(1, 0, 0), kListener).size() == NearEdges::kMax);
    search.frame(kSource, kListener);

    // Beyond the listener as seen from the source: only paths over edges there are concerned.
    const Bounds beyond{Vec3(4.2F, -5, 0), Vec3(5, 5, 3)};
    const auto due = search.frame(kSource, kListener, {&beyond, 1});
    CHECK(due.size() < NearEdges::kMax);
    const Bounds between{Vec3(-1, -1, 1), Vec3(1, 1, 2)};
    CHECK(search.frame(kSource, kListener, {&between, 1}).size() == NearEdges::kMax);
}

TEST_CASE("edges around which every path is too long are not tested") {
    // The ends are 8 m apart. Detours are at most 15 m; until the next selection each end moves by
    // less than 0.25 m, which changes a detour by less than 1 m in all.
    const auto tested = [](double detour_m) {
        Scene scene;
        scene.materials = {{"wall", Bands{}, Bands{}}};
        Object triangle;
        const float aside_m = static_cast<float>(std::sqrt(std::pow(4 + detour_m / 2, 2) - 16));
        triangle.vertices = {Vec3(0, aside_m, 1.5F), Vec3(0, aside_m + 0.2F, 1.3F),
                             Vec3(0, aside_m + 0.2F, 1.7F)};
        triangle.triangles = {{0, 1, 2}};
        triangle.triangle_materials = {0};
        scene.objects.push_back(triangle);
        return Search(scene).frame(kSource, kListener).size();
    };
    CHECK(tested(14.5) == 3);
    CHECK(tested(16.1) == 0);
}

}  // namespace near_edges_test
