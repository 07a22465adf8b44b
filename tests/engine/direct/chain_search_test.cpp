#include "engine/direct/chain_search.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <optional>
#include <set>
#include <vector>

#include "tests/engine/edges/obstacles.h"

using aula::Bands;
using aula::Bounds;
using aula::ChainSearch;
using aula::DiffractionEdge;
using aula::EdgePath;
using aula::kBandCount;
using aula::Object;
using aula::PairChains;
using aula::Vec3;
using aula::test::bar;
using aula::test::kFar_m;
using aula::test::Place;
using aula::test::prism;

namespace {

/// Chains of one pair in a scene.
struct Search {
    Search(const Place& place, int order) : chains(place.rays, place.edges, 343.2, order) {}

    std::vector<EdgePath> frame(const Vec3& source, const Vec3& listener,
                                const std::vector<Bounds>& changed = {}) {
        chains.begin_frame(changed);
        chains.search(source, listener, pair);
        std::vector<EdgePath> paths = chains.find(source, listener, pair, Bands{}, {});
        chains.join_rows(source, listener, pair, Bands{}, paths);
        return paths;
    }

    ChainSearch chains;
    PairChains pair;
};

const aula::WedgeIntegral kIntegral(343.2);

/// A thin wall at x from y0 to y1.
Object screen(float x, float y0, float y1) {
    Object object;
    object.vertices = {{x, y0, -kFar_m}, {x, y1, -kFar_m}, {x, y1, kFar_m}, {x, y0, kFar_m}};
    object.triangles = {{0, 1, 2}, {0, 2, 3}};
    object.triangle_materials = {0, 0};
    return object;
}

double energy(const std::vector<EdgePath>& paths, std::size_t band) {
    double sum = 0;
    for (const EdgePath& path : paths) sum += std::norm(path.field[band]);
    return sum;
}

}  // namespace

TEST_CASE("a search finds both ways round a pillar in its first frame") {
    const Place place({bar(0.3F, 0.3F)});
    Search search(place, 2);
    const Vec3 source(-3, 0, 0);
    const Vec3 listener(2, 0, 0);
    const auto paths = search.frame(source, listener);
    REQUIRE(paths.size() == 2);
    CHECK(paths[0].direction.y == Approx(-paths[1].direction.y));
    for (const EdgePath& path : paths) {
        CHECK(path.edges.size() == 2);
        // The last edge, as the listener sees it.
        CHECK(std::abs(path.direction.y / path.direction.x) == Approx(0.3 / 1.7));
        CHECK(path.length_m == Approx(std::hypot(2.7, 0.3) + 0.6 + std::hypot(1.7, 0.3)));
    }
    // By boundary elements; each way alone is up to 6 dB below.
    const std::vector<double> level_db{0.0, -0.1, -1.1, -4.0, -5.7, -7.7};
    for (std::size_t b = 0; b < level_db.size(); ++b) {
        const auto level = [&](std::complex<double> field) {
            return 20 * std::log10(5 * std::abs(field));
        };
        CHECK(level(paths[0].field[b] + paths[1].field[b]) == Approx(level_db[b]).margin(2));
        CHECK(level(paths[0].field[b]) < level_db[b] - 3);
    }
}

TEST_CASE("a bend below those of edges does not block a path along its face") {
    // Either face bulges by 4 mm, with bends of 0.23 and 0.46 degrees.
    const Place flat({bar(1, 0.3F)});
    const Place bulged(
        {prism({{-1, -0.3F}, {0, -0.304F}, {1, -0.3F}, {1, 0.3F}, {0, 0.304F}, {-1, 0.3F}})});
    const Vec3 source(-3, 0.1F, 0);
    const Vec3 listener(3, 0, 0);
    const auto expected = Search(flat, 2).frame(source, listener);
    const auto paths = Search(bulged, 2).frame(source, listener);
    REQUIRE(expected.size() == 2);
    REQUIRE(paths.size() == 2);
    for (std::size_t i = 0; i < 2; ++i) {
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CHECK(20 * std::log10(std::abs(paths[i].field[b] / expected[i].field[b])) ==
                  Approx(0).margin(0.5));
        }
    }
    // A bar on the face blocks it.
    const Place barred({bar(1, 0.3F), prism({{-0.1F, 0.2F}, {0.1F, 0.2F}, {0.1F, 1}, {-0.1F, 1}})});
    for (const EdgePath& path : Search(barred, 2).frame(source, listener)) {
        CHECK(path.length_m != Approx(expected[0].length_m).margin(1e-3));
    }
}

TEST_CASE("the order limits the number of edges") {
    // Staggered screens: the only path bends at all of their edges.
    const std::vector<Object> screens{screen(0, -kFar_m, 1), screen(1, -1, kFar_m),
                                      screen(2, -kFar_m, 1), screen(3, -1, kFar_m)};
    for (std::size_t count = 2; count <= 4; ++count) {
        const Place place({screens.begin(), screens.begin() + static_cast<std::ptrdiff_t>(count)});
        const float end = static_cast<float>(count);
        const Vec3 source(-1, -2, 0);
        const Vec3 listener(end, count % 2 == 0 ? 2.0F : -2.0F, 0);
        for (int order = 2; order <= 4; ++order) {
            const auto paths = Search(place, order).frame(source, listener);
            CAPTURE(count, order);
            const bool reaches = std::any_of(paths.begin(), paths.end(), [&](const auto& path) {
                return path.edges.size() == count;
            });
            CHECK(reaches == (static_cast<std::size_t>(order) >= count));
            CHECK(paths.empty() == (static_cast<std::size_t>(order) < count));
            for (const EdgePath& path : paths)
                CHECK(path.edges.size() <= static_cast<std::size_t>(order));
        }
    }
}

TEST_CASE("all edges of a curved surface count as one") {
    std::vector<std::array<float, 2>> base;
    for (int i = 0; i < 32; ++i) {
        const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / 32;
        base.push_back({0.3F * std::cos(angle), 0.3F * std::sin(angle)});
    }
    const Place place({prism(base)});
    const auto paths = Search(place, 2).frame({-1, 0, 0}, {1, 0, 0});
    REQUIRE(paths.size() == 2);
    for (const EdgePath& path : paths) CHECK(path.edges.size() > 2);
}

TEST_CASE("chains are the same from both ends") {
    const Place place({bar(0.3F, 0.3F), prism({{1, 0.5F}, {1.6F, 0.5F}, {1.6F, 0.9F}, {1, 0.9F}}),
                       screen(-1, 0.2F, 1)});
    std::size_t count = 0;
    for (int i = 0; i < 12; ++i) {
        const float angle = 0.5F * static_cast<float>(i);
        const Vec3 source(2.5F * std::cos(angle), 2.5F * std::sin(angle), 0.3F);
        const Vec3 listener(-2 * std::cos(angle), -1.5F * std::sin(angle), -0.2F);
        const auto there = Search(place, 3).frame(source, listener);
        const auto back = Search(place, 3).frame(listener, source);
        count += there.size();
        for (std::size_t b = 0; b < kBandCount; ++b)
            CHECK(energy(there, b) == Approx(energy(back, b)).epsilon(0.05));
    }
    CHECK(count > 12);
}

TEST_CASE("a chain that a moving object blocks or clears is found in the same frame") {
    // A screen that slides between the corners of a pillar on one side, or between a corner and an
    // end.
    const float side = GENERATE(1.0F, -1.0F);
    const float x = GENERATE(-1.5F, 0.0F, 1.2F);
    const float edge_y = x == 0 ? 0.25F : 0.1F;
    Object slide = side > 0 ? screen(x, edge_y, 2) : screen(x, -2, -edge_y);
    slide.path = aula::Trajectory{};
    slide.path->points = {{0, {.position = {0, 0, 0}}}, {1, {.position = {0, 5 * side, 0}}}};
    Place place({bar(0.3F, 0.3F), slide});
    Search search(place, 2);
    const Vec3 source(-3, 0, 0);
    const Vec3 listener(2, 0, 0);
    Bounds swept;
    swept.add(Vec3(x, side * edge_y, -kFar_m));
    swept.add(Vec3(x, side * 7, kFar_m));
    const auto beside = [&](const std::vector<EdgePath>& paths) {
        return std::count_if(paths.begin(), paths.end(), [&](const EdgePath& path) {
            return path.edges.size() == 2 && path.direction.y * side > 0 &&
                   path.length_m < std::hypot(2.7, 0.3) + 0.6 + std::hypot(1.7, 0.3) + 1e-3;
        });
    };
    CAPTURE(side, x);
    CHECK(beside(search.frame(source, listener)) == 0);
    place.rays.move(1.0);
    place.edges.scene_moved();
    Search unaware = search;
    CHECK(beside(unaware.frame(source, listener)) == 0);
    CHECK(beside(search.frame(source, listener, {swept})) == 1);
    place.rays.move(0.0);
    place.edges.scene_moved();
    CHECK(beside(search.frame(source, listener, {swept})) == 0);
}

TEST_CASE("a movement is noticed that concerns the first edge of a scene alone") {
    // Edges are sorted by their starts, then by length: the first one is below the front of a block
    // that sound passes below. A screen hides it from the source.
    const Object block = prism({{-2, -3}, {2, -3}, {2, 3}, {-2, 3}}, -0.3F);
    Object slide = prism({{-1.9F, -4.5F}, {1.9F, -4.5F}, {1.9F, -4.4F}, {-1.9F, -4.4F}}, -0.2F, 2);
    slide.path = aula::Trajectory{};
    slide.path->points = {{0, {.position = {0, 0, 0}}}, {1, {.position = {0, 0, 5}}}};
    Place place({block, slide});
    const DiffractionEdge& first = place.edges[0];
    REQUIRE(std::abs(first.axis.x) > 0.99);
    REQUIRE(first.start.y == Approx(-3));
    REQUIRE(first.start.z == Approx(-0.3));
    Search search(place, 2);
    const Vec3 source(0, -6, 0.3F);
    const Vec3 listener(0, 5, 0.3F);
    Bounds swept;
    swept.add(Vec3(-1.9F, -4.5F, -0.2F));
    swept.add(Vec3(1.9F, -4.4F, 7));
    const auto over_first = [&](const std::vector<EdgePath>& paths) {
        return std::count_if(paths.begin(), paths.end(), [](const EdgePath& path) {
            return path.edges.size() == 2 && (path.edges[0] == 0 || path.edges[1] == 0);
        });
    };
    CHECK(over_first(search.frame(source, listener)) == 0);
    place.rays.move(1.0);
    place.edges.scene_moved();
    CHECK(over_first(search.frame(source, listener, {swept})) == 1);
    place.rays.move(0.0);
    place.edges.scene_moved();
    CHECK(over_first(search.frame(source, listener, {swept})) == 0);
}

TEST_CASE("on a walk past the end of a thick wall no octave jumps") {
    // A wall of 20 cm. On the way out of its shadow the listener first sees the far edge, then the
    // near one, then the source. The bounds per centimetre are those of a thin wall.
    constexpr std::array<double, kBandCount> kStep_db{0.2, 0.2, 0.2, 0.3, 0.4, 0.5, 0.8, 1.2};
    const Place place({prism({{-0.1F, -kFar_m}, {0.1F, -kFar_m}, {0.1F, 0}, {-0.1F, 0}})});
    const Vec3 source(2, -1, 0);
    Search search(place, 2);
    double largest = 0;
    double largest_of_single = 0;
    std::array<double, kBandCount> before{};
    std::array<double, kBandCount> single_before{};
    for (int i = 0; i <= 400; ++i) {
        const Vec3 listener(-2, -1 + 0.01F * static_cast<float>(i), 0);
        std::vector<EdgePath> paths = place.single_paths(source, listener);
        const auto level_db = [&](std::size_t band) {
            double energy = 1e-9;
            aula::PairMemory memory;
            for (const auto& tap : place.paths.taps(paths, memory.primary))
                energy += double{tap.energy[band]};
            return 10 * std::log10(energy) +
                   20 * std::log10(double{glm::distance(source, listener)});
        };
        std::array<double, kBandCount> single{};
        for (std::size_t b = 0; b < kBandCount; ++b) single[b] = level_db(b);
        search.chains.begin_frame({});
        search.chains.search(source, listener, search.pair);
        const auto chains = search.chains.find(source, listener, search.pair, Bands{}, paths);
        paths.insert(paths.end(), chains.begin(), chains.end());
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double now = level_db(b);
            if (i > 0) {
                largest = std::max(largest, std::abs(now - before[b]) / kStep_db[b]);
                largest_of_single = std::max(largest_of_single,
                                             std::abs(single[b] - single_before[b]) / kStep_db[b]);
            }
            before[b] = now;
        }
        single_before = single;
    }
    CHECK(largest < 1);
    CHECK(largest_of_single > 5);
}

TEST_CASE("a thin screen that is seen end-on changes nothing, on either side of its plane") {
    // In its plane by symmetry; at 1 mm from it by less than 0.1 dB up to 8 kHz. The reflection is
    // part of the sum where both ends lie on one side.
    for (const float turn_rad : {0.0F, 0.7F}) {
        const auto turned = [&](float x, float y, float z) {
            return Vec3(std::cos(turn_rad) * x - std::sin(turn_rad) * y,
                        std::sin(turn_rad) * x + std::cos(turn_rad) * y, z);
        };
        Object object;
        for (const float x : {-1.0F, 1.0F}) {
            for (const float z : {-kFar_m, kFar_m}) object.vertices.push_back(turned(x, 0, z));
        }
        object.triangles = {{0, 2, 3}, {0, 3, 1}};
        object.triangle_materials = {0, 0};
        const Place place({object});
        for (const auto& [source_y, listener_y] :
             {std::array{0.0F, 0.0F}, std::array{0.0F, 0.2F}, std::array{0.0F, -0.2F},
              std::array{1e-3F, 0.0F}, std::array{1e-3F, 1e-3F}, std::array{1e-3F, -1e-3F},
              std::array{1e-3F, -2e-4F}, std::array{-1e-3F, -1e-3F}, std::array{1e-6F, 1e-6F},
              std::array{1e-6F, -1e-6F}, std::array{0.0F, 1e-7F}, std::array{1e-4F, 0.0F}}) {
            const Vec3 source = turned(-3, source_y, 0);
            const Vec3 listener = turned(3, listener_y, 0);
            CAPTURE(turn_rad, source_y, listener_y);
            const std::vector<EdgePath> single = place.single_paths(source, listener);
            Search search(place, 2);
            search.chains.begin_frame({});
            search.chains.search(source, listener, search.pair);
            const auto chains = search.chains.find(source, listener, search.pair, Bands{}, single);
            REQUIRE(chains.size() == 1);
            const double distance_m = double{glm::distance(source, listener)};
            const bool is_reflected = std::abs(source_y) > 1e-5F && source_y == listener_y;
            double single_error_db = 0;
            for (std::size_t b = 0; b < kBandCount; ++b) {
                const double k = kIntegral.wave_number_per_m(b);
                std::complex<double> sum;
                for (const EdgePath& path : single) {
                    sum += path.field[b] + path.reflected[0][b] + path.reflected[1][b];
                }
                if (is_reflected) sum += std::polar(1 / distance_m, -k * distance_m);
                const auto level_db = [&] {
                    return 20 * std::log10(std::abs(sum) * distance_m + 1e-9);
                };
                single_error_db = std::max(single_error_db, std::abs(level_db()));
                sum += chains[0].field[b];
                CHECK(std::abs(level_db()) < (listener_y * listener_y > 0.01F ? 0.5 : 0.1));
            }
            // Companion: without the second order.
            CHECK(single_error_db > 3);
        }
    }
}

TEST_CASE("both edges of a narrow face count as one") {
    // Round the end of a leaf 0.9 m wide, and from there round the corner of a box behind it.
    const Vec3 source(-2, -0.5F, 0);
    const Vec3 listener(2.6F, 0, 0);
    const auto longest = [&](float thickness_m, int order) {
        const Place place({prism({{0, -5}, {thickness_m, -5}, {thickness_m, 0.4F}, {0, 0.4F}}),
                           prism({{1.5F, -5}, {2.2F, -5}, {2.2F, 0.5F}, {1.5F, 0.5F}})});
        std::size_t edges = 0;
        for (const EdgePath& path : Search(place, order).frame(source, listener))
            edges = std::max(edges, path.edges.size());
        return edges;
    };
    CHECK(longest(0.04F, 3) == 4);
    CHECK(longest(0.04F, 2) < 4);
    // Companion: the end of a wall has two bends.
    CHECK(longest(0.06F, 4) == 4);
    CHECK(longest(0.06F, 3) < 4);
}

TEST_CASE("a search that takes several frames finds what one without a limit finds") {
    // Sixty pillars: the work of a frame is less than that of a search.
    std::vector<Object> pillars;
    for (int i = 0; i < 60; ++i) {
        const float x = 1.5F * static_cast<float>(i % 10);
        const float y = 1.4F * static_cast<float>(i / 10);
        pillars.push_back(prism({{x, y}, {x + 0.4F, y}, {x + 0.4F, y + 0.5F}, {x, y + 0.5F}}));
    }
    const Place place(pillars);
    const Vec3 source(-2, 3.1F, 0.1F);
    const Vec3 listener(16, 3.2F, 0);
    const Vec3 moved = listener + Vec3(0, 0.15F, 0);
    Search search(place, 2);
    while (!search.pair.is_complete()) search.frame(source, listener);
    search.frame(source, moved);
    CHECK_FALSE(search.pair.is_complete());
    CHECK_FALSE(search.pair.chains.empty());
    int frames = 1;
    for (; frames < 20 && !search.pair.is_complete(); ++frames) search.frame(source, moved);
    REQUIRE(search.pair.is_complete());
    CHECK(frames > 1);
    Search other(place, 2);
    while (!other.pair.is_complete()) other.frame(source, moved);
    CHECK(search.pair.chains == other.pair.chains);
}

TEST_CASE("chains follow a walk, and equal walks have equal chains") {
    const Place place({bar(0.3F, 0.3F), prism({{1, 0.5F}, {1.6F, 0.5F}, {1.6F, 0.9F}, {1, 0.9F}})});
    Search first(place, 2);
    Search second(place, 2);
    for (int i = 0; i < 60; ++i) {
        const Vec3 listener(2, -1 + 0.03F * static_cast<float>(i), 0);
        const auto paths = first.frame({-3, 0, 0}, listener);
        const auto again = second.frame({-3, 0, 0}, listener);
        REQUIRE(paths.size() == again.size());
        CHECK(paths.size() <= ChainSearch::kMaxChains + 1);  // and a row
        for (std::size_t k = 0; k < paths.size(); ++k) {
            CHECK(paths[k].edges == again[k].edges);
            CHECK(paths[k].field == again[k].field);
        }
        // A search that starts at this place finds as much.
        const auto fresh = Search(place, 2).frame({-3, 0, 0}, listener);
        CHECK(energy(paths, 3) == Approx(energy(fresh, 3)).epsilon(0.02));
        std::set<std::uint32_t> edges;
        for (const auto& chain : first.pair.chains) edges.insert(chain.begin(), chain.end());
        CHECK(std::equal(edges.begin(), edges.end(), first.pair.edges.begin(),
                         first.pair.edges.end()));
    }
}
