#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "aula/engine/scene.h"
#include "tests/engine/direct/edge_path_scene.h"
#include "tests/engine/direct/sound_group.h"
#include "tests/support/rooms.h"

namespace door_leaf_test {

using aula::kBandCount;
using aula::Object;
using aula::Scene;
using aula::SoundPath;
using aula::Vec3;
using aula::test::add_quad;
using aula::test::add_wall;
using aula::test::EdgePathScene;
using aula::test::kSpeed_m_s;
using aula::test::kWallEnd_m;
using aula::test::SoundGroup;

namespace {

constexpr double kLeaf_m = 0.9;
constexpr double kThickness_m = 0.03;
using Places = std::array<Vec3, 5>;
constexpr Places kAround{Vec3(1.2F, 1.2F, 0), Vec3(-0.9F, 1.3F, 0), Vec3(-1.5F, 0.6F, 0),
                         Vec3(0.2F, 1.5F, 0), Vec3(1.8F, 0.6F, 0)};
// The straight paths graze the jamb and the leaf.
constexpr Places kGrazing{Vec3(-0.5F, 2.5F, 0), Vec3(-0.7F, 2, 0), Vec3(-0.3F, 2.5F, 0),
                          Vec3(-1, 1.5F, 0), Vec3(0.1F, 2, 0)};
constexpr std::size_t kFirstBand = 1;  // 125 Hz

struct LeafCase {
    double angle_deg;
    Vec3 source;
    Places listeners;
    std::array<std::vector<double>, 5> octave_db;  ///< [listener][octave], from 125 Hz
};

// Boundary elements in 2.5 dimensions: the flow through the slit |x| < 0.45 m of an infinite thin
// wall y = 0, and the pressure on a leaf of 0.9 x 0.03 m that touches the jamb x = -0.45 m with a
// corner and is turned into y > 0. Mean energies of 8 (125 Hz) to 40 (4 kHz) frequencies in each
// octave, relative to free field. Elements of half and a quarter of the length change them by 0.1
// dB.
const std::vector<LeafCase> kCases{
    {12,
     {0.2F, -1.4F, 0},
     kAround,
     {{{-9.3, -9.7, -13.2, -11.3, -11.8, -9.8},
       {-14.4, -17.1, -21.4, -22.8, -25.4, -27.3},
       {-16.1, -18.9, -24.3, -27.1, -28.6, -31.4},
       {-11.3, -12.9, -17.4, -17.0, -18.3, -18.0},
       {-9.3, -8.8, -10.5, -14.2, -12.7, -17.4}}}},
    {12,
     {-0.9F, -1, 0},
     kAround,
     {{{-8.8, -7.4, -7.7, -9.9, -7.4, -8.5},
       {-17.2, -18.1, -21.0, -23.6, -27.3, -32.1},
       {-20.4, -21.6, -25.7, -29.4, -31.7, -37.2},
       {-12.2, -12.4, -15.1, -16.7, -19.4, -24.0},
       {-7.8, -5.4, -3.1, -7.1, -4.8, -5.6}}}},
    {12,
     {-0.2F, 1.3F, 0},
     kAround,
     {{{-2.0, 0.8, 0.2, 0.3, 0.3, 0.3},
       {-0.1, 0.6, 0.5, 0.3, 0.1, 0.8},
       {0.5, -0.3, 1.4, 1.8, 1.2, 1.5},
       {0.2, 0.0, 0.2, 0.0, 0.2, 0.2},
       {2.1, -4.1, 3.5, 1.2, 2.2, 1.8}}}},
    {45,
     {0.2F, -1.4F, 0},
     kAround,
     {{{-3.6, -6.2, -9.4, -9.7, -12.5, -14.7},
       {-13.7, -13.3, -16.2, -17.7, -20.3, -25.2},
       {-14.8, -18.2, -23.1, -22.0, -24.8, -30.4},
       {-6.9, -6.8, -7.4, -5.5, -3.5, -3.5},
       {-3.7, -8.0, -6.2, -9.0, -8.3, -8.8}}}},
    {45,
     {-0.9F, -1, 0},
     kAround,
     {{{-2.5, -2.3, 0.3, 1.9, -0.7, 2.6},
       {-16.6, -17.1, -20.2, -22.8, -25.1, -27.6},
       {-19.3, -23.2, -28.7, -28.1, -30.3, -33.5},
       {-7.8, -8.3, -9.2, -11.6, -13.8, -14.1},
       {-1.0, -0.8, -6.5, -4.2, -8.1, -9.0}}}},
    {45,
     {-0.2F, 1.3F, 0},
     kAround,
     {{{-0.9, 0.6, 0.1, 0.2, 0.2, 0.2},
       {-0.8, 0.6, 0.0, 0.4, 0.2, 0.2},
       {2.7, 1.0, 4.0, 4.8, 3.5, 1.8},
       {0.1, 0.0, 0.1, -0.0, 0.0, 0.0},
       {1.2, -4.0, 3.5, 0.6, 2.7, 1.9}}}},
    {90,
     {0.2F, -1.4F, 0},
     kAround,
     {{{-3.8, -9.5, -7.2, -10.2, -12.4, -15.2},
       {-8.7, -7.9, -8.0, -10.4, -12.2, -14.1},
       {-16.0, -19.3, -16.8, -20.4, -23.0, -27.5},
       {-1.2, 0.3, -2.7, 1.8, 1.2, 0.9},
       {-7.6, -9.9, -12.7, -15.4, -17.9, -21.1}}}},
    {90,
     {-0.9F, -1, 0},
     kAround,
     {{{-1.5, -2.3, -2.0, -0.2, 0.7, -0.3},
       {-12.6, -14.7, -18.1, -22.8, -27.7, -31.7},
       {-21.0, -28.5, -27.6, -33.5, -39.9, -45.5},
       {-2.6, -1.9, -2.4, -3.4, -5.0, -5.3},
       {-2.5, -5.8, -7.0, -8.0, -10.0, -12.1}}}},
    {90,
     {-0.2F, 1.3F, 0},
     kAround,
     {{{-1.4, 0.3, 0.2, 0.4, 0.4, 0.5},
       {0.2, 0.3, 0.1, 0.1, -0.1, 0.1},
       {-2.4, -1.5, 0.1, 1.4, 0.7, 0.5},
       {0.0, -0.1, -0.0, -0.0, 0.0, 0.0},
       {3.7, -4.6, 4.1, 1.8, 2.7, 2.1}}}},
    {97,
     {-0.42F, -1.4F, 0},
     kGrazing,
     {{{-4.8, -3.8, -4.6, -4.3, -4.1},
       {-5.7, -5.4, -7.3, -7.4, -8.2},
       {-4.1, -2.7, -2.5, -2.2, -1.4},
       {-8.9, -9.6, -12.5, -14.3, -17.9},
       {-2.2, -0.4, 1.1, 0.1, -0.2}}}},
    {97,
     {-0.7F, -1.2F, 0},
     kGrazing,
     {{{-5.6, -5.8, -7.8, -8.1, -9.4},
       {-6.7, -7.6, -9.7, -11.1, -13.0},
       {-4.8, -4.6, -6.0, -5.9, -6.5},
       {-10.1, -11.7, -14.6, -17.9, -22.3},
       {-2.8, -1.7, -1.7, -2.1, -3.5}}}},
};

struct Bound {
    double rms_db;
    double most_db;
};

Bound bound_of(double angle_deg) {
    // Nearly shut, leaf and wall reflect more than once to each other.
    if (angle_deg < 45) return {2.8, 6};
    return angle_deg > 90 ? Bound{0.6, 1.6} : Bound{1.8, 5.5};
}

/// The wall and the leaf, both endless along z, with a gap between the jamb and the leaf's corner.
Scene door(double angle_deg, double gap_m = 0) {
    const double angle_rad = angle_deg * std::numbers::pi / 180;
    const glm::dvec2 along(std::cos(angle_rad), std::sin(angle_rad));
    const glm::dvec2 across(-along.y, along.x);
    const glm::dvec2 hinge(-0.45 + gap_m, 0);
    const std::array corners{hinge, hinge + kLeaf_m * along,
                             hinge + kLeaf_m * along + kThickness_m * across,
                             hinge + kThickness_m * across};
    const auto at = [](const glm::dvec2& p, float z) { return Vec3(p.x, p.y, z); };
    Object wall;
    add_wall(wall, -kWallEnd_m, -0.45F, -kWallEnd_m, kWallEnd_m);
    add_wall(wall, 0.45F, kWallEnd_m, -kWallEnd_m, kWallEnd_m);
    Object leaf;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec2& p = corners[i];
        const glm::dvec2& q = corners[(i + 1) % corners.size()];
        add_quad(leaf, at(p, -kWallEnd_m), at(q, -kWallEnd_m), at(q, kWallEnd_m),
                 at(p, kWallEnd_m));
    }
    for (const float z : {-kWallEnd_m, kWallEnd_m})
        add_quad(leaf, at(corners[0], z), at(corners[1], z), at(corners[2], z), at(corners[3], z));
    Scene scene;
    scene.objects = {wall, leaf};
    scene.materials = {{"rigid", aula::Bands{}, aula::Bands{}}};
    return scene;
}

/// Mean energy in an octave of the sum of the paths at their delays, relative to free field, dB.
double heard_db(const std::vector<SoundPath>& paths, std::size_t band, double distance_m) {
    constexpr int kFrequencies = 200;
    const double centre_hz = 62.5 * std::exp2(band);
    double energy = 0;
    for (int i = 0; i < kFrequencies; ++i) {
        const double share = (i + 0.5) / kFrequencies;
        const double frequency_hz = centre_hz * std::numbers::sqrt2 * 0.5 * (1 + share);
        std::complex<double> sum;
        for (const SoundPath& path : paths) {
            sum += std::polar(
                std::sqrt(4 * std::numbers::pi * double{path.energy[band]}),
                -2 * std::numbers::pi * frequency_hz / double{kSpeed_m_s} * double{path.length_m});
        }
        energy += std::norm(sum) * distance_m * distance_m / kFrequencies;
    }
    return 10 * std::log10(std::max(1e-30, energy));
}

}  // namespace

TEST_CASE("beside a door leaf levels are those of boundary elements") {
    for (const LeafCase& c : kCases) {
        const Bound bound = bound_of(c.angle_deg);
        SoundGroup place(door(c.angle_deg));
        double square_sum = 0;
        std::size_t count = 0;
        for (std::size_t l = 0; l < c.listeners.size(); ++l) {
            const auto paths = place.paths(c.source, c.listeners[l], true);
            const double distance_m = double{glm::distance(c.source, c.listeners[l])};
            for (std::size_t i = 0; i < c.octave_db[l].size(); ++i) {
                const double level_db = heard_db(paths, kFirstBand + i, distance_m);
                const double error_db = level_db - c.octave_db[l][i];
                CAPTURE(c.angle_deg, c.source.x, l, i, level_db, c.octave_db[l][i]);
                CHECK(std::abs(error_db) < bound.most_db);
                square_sum += error_db * error_db;
                ++count;
            }
        }
        const double rms_db = std::sqrt(square_sum / static_cast<double>(count));
        CAPTURE(c.angle_deg, c.source.x, rms_db);
        CHECK(rms_db < bound.rms_db);
    }
}

TEST_CASE("how a door leaf is hung changes little") {
    struct Pair {
        double angle_deg;
        Vec3 source;
        Vec3 listener;
    };
    const std::array pairs{Pair{45, {0.2F, -1.4F, 0}, {1.2F, 1.2F, 0}},
                           Pair{45, {-0.9F, -1, 0}, {-0.9F, 1.3F, 0}},
                           Pair{60, {-0.5F, -1.5F, 0}, {1.5F, 0.8F, 0}},
                           Pair{90, {-1, -1.2F, 0}, {0.8F, 1.6F, 0}},
                           Pair{30, {0.3F, -1, 0}, {-1.2F, 1.5F, 0}},
                           Pair{40, {-1.93F, -1.59F, 0}, {1.44F, 1.65F, 0}}};
    for (const Pair& pair : pairs) {
        const double distance_m = double{glm::distance(pair.source, pair.listener)};
        const auto levels_db = [&](double gap_m, bool moves) {
            Scene scene = door(pair.angle_deg, gap_m);
            scene.objects[1].movable = moves;
            SoundGroup place(scene);
            return aula::test::level_db(place.paths(pair.source, pair.listener, true), distance_m);
        };
        const auto fixed = levels_db(0, false);
        for (const double gap_m : {0.0, 0.005, 0.011}) {
            for (const bool moves : {false, true}) {
                const auto levels = levels_db(gap_m, moves);
                for (std::size_t b = 0; b < kBandCount; ++b) {
                    CAPTURE(pair.angle_deg, pair.source.x, gap_m, moves, b);
                    CHECK(levels[b] == Approx(fixed[b]).margin(3));
                }
            }
        }
    }
}

TEST_CASE("a door that is shut at the beginning has the edges of its frame when it opens") {
    for (const float gap_m : {0.0F, 0.002F, 0.01F}) {
        const auto opened_from = [&](float yaw_rad) {
            Object wall;
            add_wall(wall, -kWallEnd_m, -0.45F, -kWallEnd_m, kWallEnd_m);
            add_wall(wall, 0.45F, kWallEnd_m, -kWallEnd_m, kWallEnd_m);
            Object leaf = aula::test::box({static_cast<float>(kLeaf_m) - 2 * gap_m,
                                           static_cast<float>(kThickness_m), 2 * kWallEnd_m},
                                          0, {gap_m, 0, -kWallEnd_m});
            aula::Pose from;
            from.position = {-0.45F, 0, 0};
            from.yaw_rad = yaw_rad;
            aula::Pose to = from;
            to.yaw_rad = std::numbers::pi_v<float> / 4;
            leaf.path = aula::Trajectory{};
            leaf.path->points = {{0, from}, {1, to}};
            EdgePathScene place({wall, leaf});
            place.rays.move(1.0);
            place.edges.scene_moved();
            return place.energy_db({0.2F, -1.4F, 0}, {1.2F, 1.2F, 0});
        };
        const auto from_shut = opened_from(0);
        const auto from_open = opened_from(std::numbers::pi_v<float> / 4);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CAPTURE(gap_m, b);
            CHECK(from_shut[b] == Approx(from_open[b]).margin(0.01));
        }
    }
}

}  // namespace door_leaf_test
