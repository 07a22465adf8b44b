#include "engine/direct/reflection_groups.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>
#include <vector>

#include "aula/engine/propagation.h"
#include "engine/direct/level_follower.h"
#include "engine/direct/limits.h"
#include "engine/edges/wedge_integral.h"
#include "tests/engine/direct/edge_path_scene.h"
#include "tests/engine/direct/sound_group.h"

namespace reflection_groups_test {

using aula::Bands;
using aula::kBandCount;
using aula::Material;
using aula::Object;
using aula::Scene;
using aula::SoundPath;
using aula::Vec3;
using Levels = std::array<double, kBandCount>;

namespace {

using aula::test::add_quad;
using aula::test::kSpeed_m_s;
using aula::test::level_db;
using aula::test::scene_of;
using Place = aula::test::SoundGroup;

constexpr float kFar_m = 50;  // of the outer edges of walls that stand for infinite ones

void add_wall(Object& object, float y, float x0, float x1, float z0, float z1) {
    add_quad(object, {x0, y, z0}, {x1, y, z0}, {x1, y, z1}, {x0, y, z1});
}

/// A wall of 0.2 m with an opening of 0.9 x 2 m: its two sides, two jambs, lintel and sill.
Object thick_door_wall() {
    Object wall;
    for (const float y : {0.0F, 0.2F}) {
        add_wall(wall, y, -kFar_m, -0.45F, -kFar_m, kFar_m);
        add_wall(wall, y, 0.45F, kFar_m, -kFar_m, kFar_m);
        add_wall(wall, y, -0.45F, 0.45F, -kFar_m, 0);
        add_wall(wall, y, -0.45F, 0.45F, 2, kFar_m);
    }
    for (const float x : {-0.45F, 0.45F}) {
        add_quad(wall, {x, 0, 0}, {x, 0.2F, 0}, {x, 0.2F, 2}, {x, 0, 2});
    }
    for (const float z : {0.0F, 2.0F}) {
        add_quad(wall, {-0.45F, 0, z}, {-0.45F, 0.2F, z}, {0.45F, 0.2F, z}, {0.45F, 0, z});
    }
    return wall;
}

/// A half plane x < 0 in the plane y = 0.
Object half_plane() {
    Object wall;
    add_wall(wall, 0, -kFar_m, 0, -kFar_m, kFar_m);
    return wall;
}

/// Mean energy in an octave of the pressure of a source of amplitude 1 at 1 m over the top of a
/// screen, a half plane, between points at distances and heights below the top, all in a plane
/// across the edge; added up over all pairs.
Levels over_screen_db(double before_m, std::vector<double> below_source_m, double behind_m,
                      std::vector<double> below_listener_m, bool with_first_pair) {
    Levels level{};
    constexpr int kSteps = 200;
    for (int step = 0; step < kSteps; ++step) {
        // WedgeIntegral has the centres of the octaves: other frequencies are other speeds.
        const double scale = std::exp2((step + 0.5) / kSteps - 0.5);
        const aula::WedgeIntegral integral(double{kSpeed_m_s} / scale);
        aula::ComplexBands sum{};
        for (std::size_t i = 0; i < below_source_m.size(); ++i) {
            for (std::size_t j = 0; j < below_listener_m.size(); ++j) {
                if (i + j == 0 && !with_first_pair) continue;
                const auto at = [](double across_m, double below_m, double sign) {
                    return aula::WedgePoint{
                        std::hypot(across_m, below_m),
                        std::numbers::pi +
                            sign * (std::numbers::pi - std::atan2(across_m, below_m)),
                        0};
                };
                const auto field = integral.field({}, at(before_m, below_source_m[i], -1),
                                                  at(behind_m, below_listener_m[j], 1));
                for (std::size_t b = 0; b < kBandCount; ++b) sum[b] += field.total()[b];
            }
        }
        // White noise: the steps are in proportion to the frequency.
        const double weight = scale * std::numbers::ln2 * std::numbers::sqrt2 / kSteps;
        for (std::size_t b = 0; b < kBandCount; ++b) level[b] += weight * std::norm(sum[b]);
    }
    for (double& x : level) x = 10 * std::log10(x);
    return level;
}

/// A screen of 2.5 m in the plane y = 0 on a floor.
Object screen_on_floor() {
    Object object;
    add_wall(object, 0, -kFar_m, kFar_m, 0, 2.5F);
    add_quad(object, {-kFar_m, -kFar_m, 0}, {kFar_m, -kFar_m, 0}, {kFar_m, kFar_m, 0},
             {-kFar_m, kFar_m, 0});
    return object;
}

struct DoorCase {
    const char* name;
    Vec3 source;
    Vec3 listener;
    std::array<double, 5> octave_db;  ///< 63 Hz to 1 kHz
};

// Integral equations for the flow at both ends of the opening, coupled by the modes of a duct of
// 0.2 m: mean energies of seven frequencies in each octave.
const std::vector<DoorCase> kDoors{
    {"D1", {0, -2, 1.5F}, {0, 2, 1.5F}, {-6.78, -5.18, -3.05, 1.08, 3.06}},
    {"D2", {0, -2, 1.5F}, {0.8F, 2, 1.5F}, {-7.31, -5.88, -4.88, -3.98, -3.71}},
    {"D3", {0, -2, 1.5F}, {1, 2, 1.5F}, {-7.56, -6.21, -5.72, -6.06, -5.47}},
    {"D4", {0, -2, 1.5F}, {1.5F, 2, 1.5F}, {-8.29, -7.12, -7.89, -9.97, -9.23}},
    {"D5", {0, -2, 1.5F}, {3, 1, 1.5F}, {-10.79, -10.33, -14.61, -13.66, -15.41}},
    {"D9", {3, -1, 1.5F}, {3, 1, 1.5F}, {-21.96, -24.69, -26.73, -25.25, -21.87}},
};

}  // namespace

TEST_CASE("the jambs of a door in a thick wall reflect what the exact solution says") {
    // Chains over both edges of a jamb err by 2.1 dB (a thick barrier). The direct sound and the
    // reflections are added as energies: two of them that are coherent and differ by 12 dB or more
    // err by 2.2 dB. Only behind the wall on both sides, D9, do both errors add up.
    constexpr double kTolerance_db = 4.3;
    Place place(scene_of(thick_door_wall()));
    for (const DoorCase& c : kDoors) {
        const double distance_m = double{glm::distance(c.source, c.listener)};
        const Levels images = level_db(place.paths(c.source, c.listener, false), distance_m);
        const Levels groups = level_db(place.paths(c.source, c.listener, true), distance_m);
        double error_of_images_db = 0;
        for (std::size_t b = 0; b < c.octave_db.size(); ++b) {
            CAPTURE(c.name, b);
            CHECK(groups[b] == Approx(c.octave_db[b]).margin(c.name[1] == '9' ? kTolerance_db : 3));
            error_of_images_db = std::max(error_of_images_db, std::abs(images[b] - c.octave_db[b]));
        }
        // Image sources of the jambs are as strong as those of infinite walls. D3 to D5 have none.
        const bool has_images = c.name[1] < '3' || c.name[1] > '5';
        if (has_images) CHECK(error_of_images_db > kTolerance_db + 1);
    }
}

TEST_CASE(
    "where the reflection point reaches the end of a wall the reflection has half its pressure") {
    Place place(scene_of(half_plane()));
    const Vec3 source(-1, -2, 0);
    const Vec3 listener(0.75F, -1.5F, 0);  // the image at (-1, 2) is behind the end of the wall
    const double length_m = std::hypot(1.75, 3.5);
    for (const float beside_m : {-2e-3F, 0.0F, 2e-3F}) {
        const auto group = place.reflections(source, listener + Vec3(beside_m, 0, 0), true);
        REQUIRE(!group.empty());
        const Levels level = level_db(group, length_m);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CAPTURE(beside_m, b);
            // 2 mm beside the boundary the Fresnel parameter is 0.01 at 8 kHz, or 0.1 dB.
            CHECK(level[b] == Approx(-20 * std::log10(2)).margin(0.15));
        }
    }
}

TEST_CASE("at the end of a wall rounding does not decide whether its reflection is audible") {
    // On both sides of the boundary rays miss the image source by the rounding of a float; the
    // coordinates of the edge decide that it is audible on one of them.
    Place place(scene_of(half_plane()));
    const Vec3 source(-1.03F, -2.17F, 0.3F);
    for (int y = 0; y < 20; ++y) {
        // On the line from the image through the end of the wall at the origin.
        const float y_m = -0.9F - 0.07F * static_cast<float>(y);
        float x_m = -source.x / source.y * y_m;
        for (int k = 0; k < 8; ++k) x_m = std::nextafter(x_m, 0.0F);
        for (int k = 0; k < 16; ++k) {
            const Vec3 listener(x_m, y_m, 0.2F);
            const Vec3 image(source.x, -source.y, source.z);
            const Levels level = level_db(place.reflections(source, listener, true),
                                          double{glm::distance(image, listener)});
            for (std::size_t b = 0; b < kBandCount; ++b) {
                CAPTURE(y_m, k, b);
                CHECK(level[b] == Approx(-20 * std::log10(2)).margin(0.15));
            }
            x_m = std::nextafter(x_m, 10.0F);
        }
    }
}

TEST_CASE("along a walk past the end of a reflecting wall no octave jumps") {
    constexpr Levels kStep_db{0.2, 0.2, 0.2, 0.3, 0.4, 0.5, 0.8, 1.2};  // per centimetre
    Place place(scene_of(half_plane()));
    const Vec3 source(-1, -2, 0);
    double largest_of_images_db = 0;
    for (const bool grouped : {true, false}) {
        Levels last{};
        for (int cm = 0; cm < 150; ++cm) {
            const Vec3 listener(0.01F * static_cast<float>(cm), -1.5F, 0);
            const Levels level = level_db(place.paths(source, listener, grouped),
                                          double{glm::distance(source, listener)});
            for (std::size_t b = 0; b < kBandCount && cm > 0; ++b) {
                const double step_db = std::abs(level[b] - last[b]);
                CAPTURE(cm, b);
                if (grouped) {
                    CHECK(step_db < kStep_db[b]);
                } else {
                    largest_of_images_db = std::max(largest_of_images_db, step_db);
                }
            }
            last = level;
        }
    }
    CHECK(largest_of_images_db > 0.5);
}

TEST_CASE("an edge decides whether an image source is audible only between its ends") {
    // The line from the image source passes the extension of the edge, 1 m beyond its end, where
    // there is no wall; the edge alone would leave the image source in sight.
    Place place(scene_of(half_plane()));
    for (const float end : {-1.0F, 1.0F}) {
        const Vec3 source(-0.15F, -0.26F, end * (kFar_m + 10));
        const Vec3 listener(1.3495F, -2.34F, end * (kFar_m - 80));
        CHECK(place.reflections(source, listener, false).empty());
        const Vec3 image(source.x, -source.y, source.z);
        const Levels level = level_db(place.reflections(source, listener, true),
                                      double{glm::distance(image, listener)});
        // At the corner of a wall a reflection has a quarter of its pressure, beyond it less.
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CAPTURE(end, b);
            CHECK(level[b] < -9);
        }
    }
}

TEST_CASE(
    "at the end of a wall the path of the reflection keeps its identity, delay and direction") {
    Place place(scene_of(half_plane()));
    const Vec3 source(-1, -2, 0);
    const auto strongest = [&](float x) {
        const auto group = place.reflections(source, {x, -1.5F, 0}, true);
        REQUIRE(!group.empty());
        return *std::max_element(
            group.begin(), group.end(),
            [](const SoundPath& a, const SoundPath& b) { return a.energy.sum() < b.energy.sum(); });
    };
    const SoundPath mirrored = strongest(0.74F);
    const SoundPath bent = strongest(0.76F);
    CHECK(mirrored.edges == 0);
    CHECK(bent.edges == 1);
    CHECK(mirrored.order == 1);
    CHECK(bent.order == 1);
    CHECK(bent.key == mirrored.key);
    CHECK(std::abs(bent.length_m - mirrored.length_m) < 0.02F);
    CHECK(glm::distance(bent.direction, mirrored.direction) < 0.02F);
}

TEST_CASE(
    "a reflection that is found after a walk fades in, after a jump it is heard immediately") {
    const Vec3 source(-1, -2, 0);
    const Vec3 listener(3.75F, -2, 0);
    Place place(scene_of(half_plane()));
    const auto energy_after = [&](const Vec3& before) {
        place.memory = {};
        double sum = 0;
        for (const Vec3& at : {before, listener}) {
            place.sound.begin_frame(false);
            place.sound.search(source, at, place.memory);
            std::vector<SoundPath> paths = place.sound.find(source, at, {}, Bands{}, place.memory);
            place.sound.complete_reflections(
                paths, source, at,
                {place.images.planes(), place.images.first_order_ids(), place.images.order()}, {},
                Bands{}, place.memory);
            sum = 0;
            for (const SoundPath& path : paths) {
                if (path.order > 0) sum += double{path.energy[0]};
            }
            if (at == before && before != listener) REQUIRE(sum == 0);
        }
        return sum;
    };
    const double model = energy_after(listener);
    REQUIRE(model > 0);
    // A step of limits::kJump_m is none. Exact: the energies of the model.
    CHECK(energy_after(listener + Vec3(aula::limits::kJump_m, 0, 0)) < 0.5 * model);
    CHECK(energy_after(listener + Vec3(0.26F, 0, 0)) == model);
}

TEST_CASE("the diffraction of reflections is the same from both ends") {
    Place place(scene_of(thick_door_wall()));
    for (const DoorCase& c : kDoors) {
        const Levels there = level_db(place.reflections(c.source, c.listener, true), 1);
        const Levels back = level_db(place.reflections(c.listener, c.source, true), 1);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CAPTURE(c.name, b);
            CHECK(there[b] == Approx(back[b]).margin(0.01));
        }
    }
}

TEST_CASE("behind a screen on a floor the reflections are those of the image sources") {
    // Exact by image sources of source and listener: four paths over the edge. The taps of the
    // floor have three of them; within an octave the phases of the fields vary by 0.8 dB.
    Place place(scene_of(screen_on_floor()), 3);
    const Vec3 source(0, -4, 0.4F);
    const Vec3 listener(0, 5, 0.5F);
    CHECK(place.reflections(source, listener, false).empty());
    const auto reflections = place.reflections(source, listener, true);
    const auto lies_on_floor = [](const Vec3& apex) { return std::abs(apex.z) < 1e-3F; };
    for (const SoundPath& path : reflections) {
        CHECK(path.edges == 1);
        CHECK(std::count_if(path.apexes.begin(), path.apexes.end(), lies_on_floor) == path.order);
        CHECK(path.apexes.size() == static_cast<std::size_t>(1 + path.order));
    }
    const Levels level = level_db(reflections, 1);
    const Levels expected = over_screen_db(4, {2.1, 2.9}, 5, {2.0, 3.0}, false);
    const Levels sum = level_db(place.paths(source, listener, true), 1);
    const Levels direct = level_db(place.direct(source, listener), 1);
    const Levels exact = over_screen_db(4, {2.1, 2.9}, 5, {2.0, 3.0}, true);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        CAPTURE(b);
        CHECK(level[b] == Approx(expected[b]).margin(0.8));
    }
    // Direct sound and reflections add up as energies. The exact sum at 63 Hz is coherent: 16 times
    // the energy of one of four equal paths instead of 1 + 9.
    CHECK(sum[0] > exact[0] - 10 * std::log10(16.0 / 10) - 0.8);
    CHECK(direct[0] < exact[0] - 9);
}

TEST_CASE("reflections before and after an edge need a specular order of two") {
    Place first(scene_of(screen_on_floor()), 1);
    Place second(scene_of(screen_on_floor()), 2);
    const auto largest_order = [](const std::vector<SoundPath>& paths) {
        int order = 0;
        for (const SoundPath& path : paths) order = std::max(order, path.order);
        return order;
    };
    CHECK(largest_order(first.reflections({0, -3, 1.2F}, {0, 2, 1}, true)) == 1);
    CHECK(largest_order(second.reflections({0, -3, 1.2F}, {0, 2, 1}, true)) == 2);
}

TEST_CASE("along a walk out of the shadow of a screen no octave of its floor's reflection jumps") {
    constexpr Levels kStep_db{0.2, 0.2, 0.2, 0.3, 0.4, 0.5, 0.8, 1.2};  // per centimetre
    Place place(scene_of(screen_on_floor()), 2);
    const Vec3 source(0, -3, 2.6F);
    double largest_of_images_db = 0;
    for (const bool grouped : {true, false}) {
        Levels last{};
        for (int cm = 0; cm < 150; ++cm) {
            // The image source at -2.6 m comes into sight over the screen at about 6 m.
            const Vec3 listener(0, 3, 6.9F + 0.01F * static_cast<float>(cm));
            const Levels level = level_db(place.paths(source, listener, grouped),
                                          double{glm::distance(source, listener)});
            for (std::size_t b = 0; b < kBandCount && cm > 0; ++b) {
                const double step_db = std::abs(level[b] - last[b]);
                CAPTURE(cm, b);
                if (grouped) {
                    CHECK(step_db < kStep_db[b]);
                } else {
                    largest_of_images_db = std::max(largest_of_images_db, step_db);
                }
            }
            last = level;
        }
    }
    CHECK(largest_of_images_db > 1);
}

TEST_CASE("paths that the floor reflects are the same from both ends") {
    Place place(scene_of(screen_on_floor()), 2);
    for (const Vec3& listener : {Vec3(1, 4, 1.5F), Vec3(-2, 2, 3), Vec3(0.5F, 6, 4)}) {
        const Vec3 source(0.3F, -3, 1.2F);
        const Levels there = level_db(place.reflections(source, listener, true), 1);
        const Levels back = level_db(place.reflections(listener, source, true), 1);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CAPTURE(b);
            CHECK(there[b] == Approx(back[b]).margin(0.01));
        }
    }
}

TEST_CASE("walls that absorb or scatter all sound have no group") {
    const Vec3 source(-1, -2, 0);
    const Vec3 listener(0.8F, -1.5F, 0);
    Place rigid(scene_of(half_plane()));
    CHECK(!rigid.reflections(source, listener, true).empty());
    for (const Material& material : {Material{"absorber", Bands::filled(1), Bands{}},
                                     Material{"diffusor", Bands{}, Bands::filled(1)}}) {
        Place place(scene_of(half_plane(), material));
        CHECK(place.reflections(source, listener, true).empty());
    }
}

TEST_CASE(
    "reflections have their diffraction in the first frame unless image sources are left out") {
    Scene scene = scene_of(half_plane());
    scene.medium.air_absorption = false;
    scene.sources.emplace_back();
    scene.sources[0].position = Vec3(-1, -2, 0);
    scene.simulation.rays = 1;
    scene.simulation.ir_length_s = 0.1F;
    const auto bent_reflections = [&] {
        aula::Propagation propagation(scene, scene.simulation);
        propagation.step({.sources = {scene.sources[0].position}, .listeners = {{0.8F, -1.5F, 0}}});
        const auto& paths = propagation.response(0).paths;
        return std::count_if(paths.begin(), paths.end(), [](const SoundPath& path) {
            return path.order == 1 && path.edges == 1;
        });
    };
    for (const auto estimator : {aula::Estimator::pt, aula::Estimator::dpc_published,
                                 aula::Estimator::dpc, aula::Estimator::patch}) {
        scene.simulation.estimator = estimator;
        CHECK(bent_reflections() > 0);
    }
    const aula::Simulation simulation = scene.simulation;
    scene.simulation.specular_order = 0;
    CHECK(bent_reflections() == 0);
    scene.simulation = simulation;
    scene.simulation.specular = false;
    CHECK(bent_reflections() == 0);
    scene.simulation = simulation;
    scene.simulation.direct = false;
    CHECK(bent_reflections() == 0);
    scene.simulation = simulation;
    scene.simulation.diffraction_order = 0;
    CHECK(bent_reflections() == 0);
}

}  // namespace reflection_groups_test
