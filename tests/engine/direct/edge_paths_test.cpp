#include "engine/direct/edge_paths.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <vector>

#include "engine/base/sampling.h"
#include "tests/engine/direct/edge_path_scene.h"
#include "tests/support/rooms.h"

namespace edge_paths_test {

using aula::Bands;
using aula::EdgePath;
using aula::EdgePaths;
using aula::kBandCount;
using aula::Object;
using aula::RayScene;
using aula::Scene;
using aula::SceneEdges;
using aula::SoundPath;
using aula::Vec3;
using aula::test::add_quad;
using aula::test::add_wall;
using aula::test::door_wall;
using aula::test::EdgePathScene;
using aula::test::half_plane;
using aula::test::kWallEnd_m;
using aula::test::Levels;

namespace {

struct DoorCase {
    const char* name;
    Vec3 source;
    Vec3 listener;
    Levels centre_db;
    Levels octave_db;
    std::array<double, 6> exact_db;  ///< 63 Hz to 2 kHz
};

// Direct sound and the four finite edges by Svensson's line integral: at the centres of the bands,
// and as mean energies in the octaves. The exact solution, at the centres, is that of an integral
// equation for the flow in the opening, which includes what passes from jamb to jamb.
const std::vector<DoorCase> kDoors{
    {"D1",
     {0, -2, 1.5F},
     {0, 2, 1.5F},
     {-6.747, -5.580, -3.890, 0.034, 2.545, 0.425, 0.846, 0.515},
     {-6.7, -5.5, -3.5, 0.1, 2.6, 0.4, 0.1, -0.1},
     {-6.7, -5.6, -4.0, -0.1, 2.5, 0.5}},
    {"D2",
     {0, -2, 1.5F},
     {0.8F, 2, 1.5F},
     {-7.175, -6.172, -5.083, -3.147, -4.609, -5.359, -3.625, -3.735},
     {-7.1, -6.1, -4.9, -3.6, -3.8, -4.4, -3.8, -3.0},
     {-7.1, -6.2, -5.2, -3.2, -4.7, -5.4}},
    {"D3",
     {0, -2, 1.5F},
     {1, 2, 1.5F},
     {-7.388, -6.460, -5.649, -4.643, -5.531, -6.560, -6.685, -8.703},
     {-7.3, -6.4, -5.5, -5.2, -5.3, -7.2, -7.5, -8.5},
     {-7.3, -6.5, -5.7, -4.7, -5.6, -6.6}},
    {"D4",
     {0, -2, 1.5F},
     {1.5F, 2, 1.5F},
     {-8.007, -7.282, -7.198, -8.476, -8.350, -12.807, -14.127, -16.665},
     {-8.0, -7.3, -7.3, -8.8, -9.2, -12.2, -14.6, -17.3},
     {-7.9, -7.2, -7.3, -8.5, -8.3, -12.8}},
    {"D5",
     {0, -2, 1.5F},
     {3, 1, 1.5F},
     {-10.268, -10.590, -12.925, -14.451, -15.959, -21.070, -23.714, -26.493},
     {-10.3, -10.7, -13.1, -14.8, -16.8, -20.5, -23.7, -26.8},
     {-10.0, -10.1, -13.0, -14.3, -16.1, -20.9}},
    {"D6",
     {-1.5F, -2, 1.2F},
     {3, 1, 1.6F},
     {-8.016, -7.998, -8.219, -8.915, -12.828, -16.406, -17.199, -20.149},
     {-8.0, -8.0, -8.3, -8.9, -12.0, -15.0, -18.0, -20.8},
     {-8.9, -7.7, -7.5, -8.9, -12.7, -16.3}},
    {"D7",
     {0, -2, 1.5F},
     {0, 2, 3.5F},
     {-10.740, -11.803, -10.871, -10.814, -10.656, -13.056, -18.814, -21.262},
     {-10.8, -11.7, -11.1, -10.6, -10.8, -13.6, -18.0, -20.7},
     {-10.4, -11.8, -11.0, -10.9, -10.7, -13.0}},
    {"D8",
     {0, -2, 1.5F},
     {1, 0.3F, 1.5F},
     {-6.198, -6.909, -8.005, -9.542, -12.702, -15.556, -19.203, -21.771},
     {-6.2, -7.0, -8.1, -9.7, -13.2, -15.8, -18.8, -21.8},
     {-6.1, -6.7, -8.2, -9.5, -12.7, -15.5}},
    {"D9",
     {3, -1, 1.5F},
     {3, 1, 1.5F},
     {-22.066, -22.959, -25.718, -27.548, -29.208, -32.423, -37.152, -39.690},
     {-22.1, -23.1, -25.9, -27.8, -29.6, -32.8, -36.7, -39.6},
     {-21.3, -23.2, -25.5, -27.8, -29.4, -32.5}},
};

double largest_step(const Levels& a, const Levels& b, const Levels& bound) {
    double largest = 0;
    for (std::size_t i = 0; i < kBandCount; ++i)
        largest = std::max(largest, std::abs(a[i] - b[i]) / bound[i]);
    return largest;
}

// Bounds of the change per centimetre walked, dB.
constexpr Levels kStep_db{0.2, 0.2, 0.2, 0.3, 0.4, 0.5, 0.8, 1.2};

}  // namespace

TEST_CASE("in free field the only tap is the direct sound") {
    const EdgePathScene place({});
    const auto taps = place.taps({0, 0, 0}, {3, 4, 0});
    REQUIRE(taps.size() == 1);
    CHECK(taps[0].is_main);
    CHECK(taps[0].edges == 0);
    CHECK(taps[0].length_m == Approx(5));
    CHECK(taps[0].direction.x == Approx(-0.6));
    for (const float energy : taps[0].energy.value)
        CHECK(energy == Approx(1 / (4 * std::numbers::pi * 25)));
}

TEST_CASE("behind a half plane the pressure is exact, in the shadow and in the lit zone") {
    // H3, H2, H1 and H8: source at 2 m and 90 degrees, listener at 2 m. The angles are measured
    // from the side of the wall that faces the source.
    struct Case {
        double degrees;
        Levels level_db;
    };
    const std::vector<Case> cases{
        {340, {-8.483, -10.617, -13.175, -15.998, -18.947, -21.940, -24.945, -27.955}},
        {300, {-5.731, -7.222, -8.998, -11.099, -13.547, -16.283, -19.191, -22.170}},
        {280, {-4.369, -5.314, -6.289, -7.343, -8.578, -10.104, -12.007, -14.319}},
        {250, {-2.439, -2.485, -2.066, -1.146, 0.134, 1.099, -0.320, 0.628}}};
    const EdgePathScene place({half_plane()});
    for (const Case& c : cases) {
        const double angle = (180 - c.degrees) * std::numbers::pi / 180;
        const Levels level =
            place.coherent_db({0, -2, 0}, {2 * std::cos(angle), -2 * std::sin(angle), 0});
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CAPTURE(c.degrees, b);
            // The ends of the edge, 50 m away, bring -45 dB at 63 Hz.
            CHECK(level[b] == Approx(c.level_db[b]).margin(0.05));
        }
    }
}

TEST_CASE("behind a thin door the pressure is that of the finite edges") {
    const EdgePathScene place({door_wall()});
    for (const DoorCase& c : kDoors) {
        const auto paths = place.find(c.source, c.listener);
        const bool is_lit = paths.front().edges.empty();
        CHECK(paths.size() == (is_lit ? 5 : 4));
        const Levels level = place.coherent_db(c.source, c.listener);
        const Levels beside = place.coherent_db(c.source, c.listener + Vec3(0.05F, 0, 0));
        double error_db = 0;
        double error_beside_db = 0;
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CAPTURE(c.name, b);
            CHECK(level[b] == Approx(c.centre_db[b]).margin(0.02));
            error_db = std::max(error_db, std::abs(level[b] - c.centre_db[b]));
            error_beside_db = std::max(error_beside_db, std::abs(beside[b] - c.centre_db[b]));
        }
        CHECK(error_beside_db > error_db + 0.02);
    }
}

TEST_CASE("behind a thin door the finite edges are near to the exact solution") {
    const EdgePathScene place({door_wall()});
    for (const DoorCase& c : kDoors) {
        const Levels level = place.coherent_db(c.source, c.listener);
        // Companion: of all edges the strongest one alone, with the direct sound.
        const auto paths = place.find(c.source, c.listener);
        const auto strength = [](const EdgePath& path) {
            return path.edges.empty() ? 0 : std::norm(path.field[4]);
        };
        const EdgePath& strongest = *std::max_element(
            paths.begin(), paths.end(),
            [&](const EdgePath& a, const EdgePath& b) { return strength(a) < strength(b); });
        const double free_m = double{glm::distance(c.source, c.listener)};
        double one_edge_error = 0;  // re the tolerance
        for (std::size_t b = 0; b < c.exact_db.size(); ++b) {
            CAPTURE(c.name, b);
            // Edges of the first order alone: 0.9 dB, 0.3 dB from 500 Hz on.
            const double tolerance_db = b < 3 ? 0.9 : 0.3;
            CHECK(level[b] == Approx(c.exact_db[b]).margin(tolerance_db));
            std::complex<double> one_edge = strongest.field[b];
            if (paths.front().edges.empty()) one_edge += paths.front().field[b];
            const double error_db = 20 * std::log10(std::abs(one_edge) * free_m) - c.exact_db[b];
            one_edge_error = std::max(one_edge_error, std::abs(error_db) / tolerance_db);
        }
        CHECK(one_edge_error > 1);
    }
}

TEST_CASE("the energy of the taps is that of the octaves") {
    // A path has one length, but the field of its edge is the sum of waves from the apex and from
    // the ends, whose phases vary within an octave: 0.8 dB in the deep shadow.
    const EdgePathScene place({door_wall()});
    double without_phases_db = 0;
    for (const DoorCase& c : kDoors) {
        const Levels level = place.energy_db(c.source, c.listener);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CAPTURE(c.name, b);
            CHECK(level[b] == Approx(c.octave_db[b]).margin(0.8));
        }
        Levels energies{};
        for (const EdgePath& path : place.find(c.source, c.listener)) {
            const double d = double{glm::distance(c.source, c.listener)};
            for (std::size_t b = 0; b < kBandCount; ++b)
                energies[b] += std::norm(path.field[b]) * d * d;
        }
        without_phases_db =
            std::max(without_phases_db, std::abs(10 * std::log10(energies[0]) - c.octave_db[0]));
    }
    CHECK(without_phases_db > 5);  // energies of the same paths added
}

TEST_CASE("along walks past a door and a wall's end no octave jumps") {
    struct Walk {
        EdgePathScene place;
        Vec3 source;
        Vec3 from;
    };
    const std::array<Walk, 3> walks{
        Walk{EdgePathScene({door_wall()}), {0, -2, 1.5F}, {-0.5F, 2, 1.5F}},
        Walk{EdgePathScene({door_wall()}), {-1.5F, -2, 1.2F}, {-0.5F, 1, 1.6F}},
        Walk{EdgePathScene({half_plane()}), {-1, -2, 0}, {-2, 2, 0}}};
    for (const Walk& walk : walks) {
        bool was_lit = false;
        bool was_in_shadow = false;
        double step = 0;
        double step_of_direct = 0;
        const auto direct_db = [&](const Vec3& listener) {
            Levels level;
            level.fill(walk.place.rays.visible(walk.source, listener) ? 0 : -30);
            return level;
        };
        Levels before = walk.place.energy_db(walk.source, walk.from);
        Levels direct_before = direct_db(walk.from);
        for (int i = 1; i <= 450; ++i) {
            const Vec3 listener = walk.from + Vec3(0.01F * static_cast<float>(i) + 3e-5F, 0, 0);
            const Levels now = walk.place.energy_db(walk.source, listener);
            const Levels direct = direct_db(listener);
            (direct[0] < 0 ? was_in_shadow : was_lit) = true;
            step = std::max(step, largest_step(before, now, kStep_db));
            step_of_direct =
                std::max(step_of_direct, largest_step(direct_before, direct, kStep_db));
            before = now;
            direct_before = direct;
        }
        CHECK(was_lit);
        CHECK(was_in_shadow);
        CHECK(step < 1);
        CHECK(step_of_direct > 1);
    }
}

TEST_CASE("at the shadow boundary neither level, delay nor direction jumps") {
    const EdgePathScene place({half_plane()});
    const Vec3 source(-1, -2, 0);
    const auto primary = [&](float x) { return place.taps(source, {x, 2, 0}).front(); };
    bool was_lit = false;
    bool was_in_shadow = false;
    for (int i = -40; i <= 40; ++i) {
        // The boundary is at x = 1. Floats of some metres are 1e-7 m apart.
        const float x = 1 + 1e-6F * static_cast<float>(i);
        const SoundPath a = primary(x);
        const SoundPath b = primary(x + 1e-6F);
        (a.edges == 0 ? was_lit : was_in_shadow) = true;
        CHECK(b.length_m == Approx(a.length_m).margin(2e-6));
        CHECK(glm::distance(a.direction, b.direction) < 2e-6F);
        const Levels from = place.energy_db(source, {x, 2, 0});
        const Levels to = place.energy_db(source, {x + 1e-6F, 2, 0});
        // The field changes by sqrt(k d) of its half over a detour d of some 1e-8 m.
        for (std::size_t band = 0; band < kBandCount; ++band)
            CHECK(from[band] == Approx(to[band]).margin(0.05));
    }
    CHECK(was_lit);
    CHECK(was_in_shadow);
}

TEST_CASE("of very many edges those with the smallest detours count") {
    // 200 squares far from the end of a wall: 800 edges with detours of some metres.
    Object object = half_plane();
    for (int i = 0; i < 200; ++i) {
        const auto x = 4 + 0.4F * static_cast<float>(i % 5);
        const auto y = -1.5F + static_cast<float>(i / 5 % 4);
        const auto z = -2 + 0.4F * static_cast<float>(i / 20);
        add_quad(object, {x, y, z}, {x + 0.3F, y, z}, {x + 0.3F, y, z + 0.3F}, {x, y, z + 0.3F});
    }
    const EdgePathScene many({object});
    const EdgePathScene wall({half_plane()});
    REQUIRE(many.edges.count() > 800);
    const Vec3 source(-1, -2, 0);
    const Vec3 listener(-1, 2, 0);
    const auto paths = wall.find(source, listener);
    REQUIRE(paths.size() == 1);
    const auto found = many.find(source, listener);
    // At most 32, less those of the level of the next one.
    CHECK(found.size() <= 32);
    CHECK(found.size() > 28);
    CHECK(std::count_if(found.begin(), found.end(), [&](const EdgePath& path) {
              return path.length_m == paths[0].length_m && path.field == paths[0].field;
          }) == 1);
}

TEST_CASE("the paths are the same from both ends") {
    const EdgePathScene place(
        {door_wall(), aula::test::box({0.5F, 0.4F, 0.8F}, 0, {0.6F, 0.5F, 0.2F})});
    aula::RandomStream random(3);
    std::size_t count = 0;
    for (int trial = 0; trial < 60; ++trial) {
        const auto between = [&](float low, float high) {
            return low + (high - low) * random.uniform();
        };
        const Vec3 source(between(-3, 3), between(-3, -0.1F), between(0, 3));
        const Vec3 listener(between(-3, 3), between(-3, 3), between(0, 3));
        const auto there = place.find(source, listener);
        const auto back = place.find(listener, source);
        REQUIRE(there.size() == back.size());
        count += there.size();
        for (std::size_t i = 0; i < there.size(); ++i) {
            CHECK(there[i].edges == back[i].edges);
            CHECK(there[i].length_m == Approx(back[i].length_m));
            for (std::size_t b = 0; b < kBandCount; ++b)
                CHECK(std::abs(there[i].field[b] - back[i].field[b]) < 1e-9);
        }
    }
    CHECK(count > 200);
}

TEST_CASE("in the shadow of a door the primary tap comes from the opening") {
    const EdgePathScene place({door_wall()});
    const Vec3 source(0, -2, 1.5F);
    const Vec3 listener(3, 1, 1.5F);
    const auto taps = place.taps(source, listener);
    REQUIRE(taps.size() > 1);
    CHECK(taps[0].is_main);
    CHECK(taps[0].edges == 1);
    // Over the near jamb at x = 0.45 m.
    const Vec3 jamb = glm::normalize(Vec3(0.45F, 0, 1.5F) - listener);
    CHECK(glm::distance(taps[0].direction, jamb) < 1e-3F);
    const double length_m = std::hypot(2, 0.45) + std::hypot(2.55, 1);
    CHECK(taps[0].length_m == Approx(length_m));
    CHECK(taps.size() <= EdgePaths::kMaxTaps);
}

TEST_CASE("a screen before an edge blocks its path and no other") {
    Object screen;
    // Between the source and the left jamb.
    add_quad(screen, {-0.5F, -1, 0.5F}, {-0.2F, -1, 0.5F}, {-0.2F, -1, 2.5F}, {-0.5F, -1, 2.5F});
    screen.movable = true;
    const EdgePathScene open({door_wall()});
    const EdgePathScene screened({door_wall(), screen});
    const Vec3 source(0, -2, 1.5F);
    const Vec3 listener(3, 1, 1.5F);
    const auto uses_jamb = [&](const EdgePathScene& place) {
        const auto paths = place.find(source, listener);
        return std::any_of(paths.begin(), paths.end(), [&](const EdgePath& path) {
            const auto& edge = place.edges[path.edges[0]];
            return std::abs(edge.start.x + 0.45) < 1e-3 && std::abs(edge.axis.z) > 0.9;
        });
    };
    CHECK(uses_jamb(open));
    CHECK_FALSE(uses_jamb(screened));
    CHECK(open.find(source, listener).size() == 4);
    CHECK(screened.find(source, listener).size() >= 3);
}

TEST_CASE("a door that shuts fades its room out") {
    // A sliding door: a leaf over the whole opening, moved aside by the width of the gap.
    Object leaf;
    add_wall(leaf, -0.45F, 0.45F, 0, 2);
    leaf.path = aula::Trajectory{};
    leaf.path->points = {{0, {.position = {0, 0, 0}}}, {1, {.position = {0.9F, 0, 0}}}};
    EdgePathScene place({door_wall(), leaf});
    const Vec3 source(0, -2, 1);
    const Vec3 listener(0.5F, 2, 1.2F);
    double last_db = 10;
    for (const double gap_m : {0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002}) {
        place.rays.move(gap_m / 0.9);
        place.edges.scene_moved();
        const double level_db = place.energy_db(source, listener)[1];
        CAPTURE(gap_m);
        CHECK(level_db < last_db);
        last_db = level_db;
    }
    CHECK(last_db < -35);
    place.rays.move(0.0);
    place.edges.scene_moved();
    CHECK(place.find(source, listener).empty());
}

TEST_CASE("absorbing faces reflect none of the terms that belong to their reflections") {
    Scene scene = EdgePathScene::scene_of({half_plane()});
    const auto field = [&](float absorption) {
        scene.materials[0].absorption = Bands::filled(absorption);
        const RayScene rays(scene);
        const SceneEdges edges(rays);
        const EdgePaths paths(rays, edges, 343.2);
        aula::PairMemory memory;
        const auto found = paths.find({0, -2, 0}, {-1, 1.5F, 0}, Bands{}, memory);
        REQUIRE(found.size() == 1);
        return found[0].field[4];
    };
    const auto incident = field(1);
    const auto sums = field(0) - incident;
    CHECK(std::abs(sums) > 0.01);
    CHECK(std::abs(field(0.75F) - (incident + 0.5 * sums)) < 1e-6);  // pressure: sqrt(0.25)
}

TEST_CASE("air attenuates each path by its length") {
    const EdgePathScene place({door_wall()});
    const Bands attenuation = Bands::filled(0.1F);
    const Vec3 source(0, -2, 1.5F);
    const Vec3 listener(0.2F, 2, 1.5F);
    const auto dry = place.find(source, listener);
    aula::PairMemory memory;
    const auto damped = place.paths.find(source, listener, attenuation, memory);
    REQUIRE(dry.size() == damped.size());
    for (std::size_t i = 0; i < dry.size(); ++i)
        CHECK(std::abs(damped[i].field[3] / dry[i].field[3]) ==
              Approx(std::exp(-0.05 * dry[i].length_m)));
}

TEST_CASE("where the primary tap changes to a distant path it gets a new key") {
    // Behind a screen 1 m wide, from the shadow of one side to that of the other.
    Object screen;
    add_wall(screen, -0.5F, 0.5F, -kWallEnd_m, kWallEnd_m);
    const EdgePathScene place({screen});
    const Vec3 source(0, -1, 0);
    const auto place_of = [](int i) { return Vec3(-0.3F + 0.02F * static_cast<float>(i), 1, 0); };
    aula::PairMemory memory;
    std::vector<SoundPath> before;
    int jumps = 0;
    float largest_turn = 0;
    float largest_at_jumps = 0;
    for (int i = 0; i <= 30; ++i) {
        const Vec3 listener = place_of(i);
        const auto taps =
            place.paths.taps(place.paths.find(source, listener, Bands{}, memory), memory.primary);
        REQUIRE(!taps.empty());
        CHECK(taps[0].is_main);
        std::set<std::uint64_t> keys;
        for (const SoundPath& tap : taps) keys.insert(tap.key);
        CHECK(keys.size() == taps.size());
        if (i > 0) {
            const bool jumps_here = taps[0].key != before[0].key;
            jumps += jumps_here ? 1 : 0;
            float& largest = jumps_here ? largest_at_jumps : largest_turn;
            largest = std::max(largest, glm::distance(taps[0].direction, before[0].direction));
        }
        before = taps;
    }
    CHECK(jumps == 1);
    CHECK(largest_turn < 0.05F);  // the listener moves 2 cm, 1.1 m behind the edges
    // The directions to the edges differ by 0.5 m / 1.12 m on both sides.
    CHECK(largest_at_jumps > 0.8F);
}

}  // namespace edge_paths_test
