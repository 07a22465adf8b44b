// Direct sound while a listener, an object or a material changes.

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "aula/engine/propagation.h"
#include "aula/engine/scene_file.h"
#include "engine/direct/direct_sound.h"
#include "tests/engine/direct/divided_room.h"
#include "tests/support/measure.h"

using namespace aula;
using aula::test::direct_of;
using aula::test::direct_of_frame_1;
using aula::test::divided_room;
using aula::test::energy_of;
using aula::test::kBehindWall;
using aula::test::kSource;
using aula::test::same;

TEST_CASE("through the doorways of the shipped scenes no octave of the direct sound jumps") {
    // The whole walk of each scene in steps of 1 cm, and across the study past the door; with the
    // sound through the door, too, while it is shut and while it is open.
    constexpr std::array kBound_db{0.2, 0.2, 0.2, 0.3, 0.4, 0.5, 0.8, 1.2};  // per centimetre
    struct Walk {
        const char* file;
        bool transmission = false;
        double time_s = 0;
        std::vector<Vec3> places;
    };
    const auto scene_of = [](const char* file, bool transmission) {
        Scene scene = load_scene(std::string(AULA_SOURCE_DIR "/scenes/") + file).scene;
        scene.simulation.transmission = transmission;
        scene.simulation.rays = 1;
        scene.simulation.specular = false;
        scene.simulation.ir_length_s = 0.1F;
        return scene;
    };
    const auto path_of = [](const Scene& scene) {
        const Trajectory& path = *scene.listener.path;
        std::vector<Vec3> places{path.at(0).position};
        const double end_s = path.points.back().time_s;
        for (double t = 0; t < end_s; t += 1e-4) {
            const Vec3 place = path.at(t).position;
            if (glm::distance(place, places.back()) >= 0.01F) places.push_back(place);
        }
        return places;
    };
    std::vector<Vec3> across;
    for (int cm = 0; cm < 460; ++cm)
        across.emplace_back(6.2F, -0.3F + 0.01F * static_cast<float>(cm), 1.6F);
    const auto along = [&](const char* file) { return path_of(scene_of(file, false)); };
    constexpr double kShut_s = 0;
    constexpr double kOpen_s = 5;
    for (const Walk& walk : {Walk{"two_rooms.json", false, 0, along("two_rooms.json")},
                             {"door.json", false, kShut_s, along("door.json")},
                             {"door.json", false, kShut_s, across},
                             {"door.json", true, kShut_s, along("door.json")},
                             {"door.json", true, kShut_s, across},
                             {"door.json", true, kOpen_s, along("door.json")}}) {
        const Scene scene = scene_of(walk.file, walk.transmission);
        const Vec3 source = scene.sources[0].position_at(0);
        // Companion: without what the walk remembers, each frame is a first one.
        const RayScene rays(scene, walk.time_s);
        DirectSound fresh(rays, scene.medium.speed_of_sound_m_s(),
                          scene.simulation.diffraction_order);
        double largest_fresh = 0;
        Propagation propagation(scene, scene.simulation);
        double largest = 0;
        Bands last;
        Bands last_fresh;
        for (std::size_t i = 0; i < walk.places.size(); ++i) {
            propagation.step(
                {.time_s = walk.time_s, .sources = {source}, .listeners = {walk.places[i]}});
            PairMemory memory;
            fresh.begin_frame(false);
            fresh.search(source, walk.places[i], memory);
            const Bands now = energy_of(direct_of(propagation.response(0)));
            const Bands now_fresh = energy_of(
                fresh.find(source, walk.places[i], {}, scene.medium.attenuation_per_m(), memory));
            const auto change = [&](const Bands& from, const Bands& to) {
                double most = 0;
                for (std::size_t b = 0; b < kBandCount; ++b) {
                    const double change_db =
                        std::abs(10 * std::log10(double{to[b]} / double{from[b]}));
                    most = std::max(most, change_db / kBound_db[b]);
                }
                return most;
            };
            if (i > 0) {
                largest = std::max(largest, change(last, now));
                largest_fresh = std::max(largest_fresh, change(last_fresh, now_fresh));
            }
            last = now;
            last_fresh = now_fresh;
        }
        CAPTURE(walk.file, walk.transmission, walk.time_s, walk.places.size());
        // 0.21 dB at 63 Hz where a row of a jamb and the open leaf ends.
        CHECK(largest < 1.05);
        CHECK(largest_fresh > 2);
    }
}

TEST_CASE("in the planes of a door's jambs the first frame's direct sound has no step") {
    // There the path over the near edge of a jamb begins to bend at the far one.
    constexpr std::array kBound_db{0.2, 0.2, 0.2, 0.3, 0.4, 0.5, 0.8, 1.2};  // per centimetre
    const Scene scene = load_scene(AULA_SOURCE_DIR "/scenes/two_rooms.json").scene;
    const RayScene rays(scene);
    const float speed_m_s = scene.medium.speed_of_sound_m_s();
    const SceneEdges edges(rays);
    const EdgePaths single_edges(rays, edges, double{speed_m_s});
    DirectSound direct_sound(rays, speed_m_s, scene.simulation.diffraction_order);
    const Vec3 source = scene.sources[0].position_at(0);
    const auto with_chains = [&](const Vec3& listener) {
        PairMemory memory;
        direct_sound.begin_frame(false);
        direct_sound.search(source, listener, memory);
        return energy_of(direct_sound.find(source, listener, {}, Bands{}, memory));
    };
    const auto over_single_edges = [&](const Vec3& listener) {
        PairMemory memory;
        return single_edges.energy(single_edges.find(source, listener, Bands{}, memory));
    };
    const auto step = [&](const auto& energy_at, const Vec3& from, const Vec3& to) {
        const Bands first = energy_at(from);
        const Bands second = energy_at(to);
        double most = 0;
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double step_db = 10 * std::log10(double{second[b]} / double{first[b]});
            most = std::max(most, std::abs(step_db) / kBound_db[b]);
        }
        return most;
    };
    const auto steps = [&](const auto& energy_at, float below_m, float above_m) {
        double most = 0;
        for (const float x_m : {6.75F, 7.5F, 8.5F, 9.F, 10.F, 11.5F, 13.F}) {
            for (const float z_m : {1.2F, 1.65F}) {
                most = std::max(most, step(energy_at, {x_m, below_m, z_m}, {x_m, above_m, z_m}));
            }
        }
        return most;
    };
    for (const float jamb_m : {2.F, 3.F}) {
        const float above_m = std::nextafter(jamb_m, 9.F);
        const float below_m = std::nextafter(jamb_m, 0.F);
        CAPTURE(jamb_m);
        CHECK(steps(with_chains, jamb_m, above_m) < 1);
        CHECK(steps(with_chains, below_m, jamb_m) < 1);
        // Beside a jamb the level at 63 Hz changes by up to 0.3 dB per centimetre.
        CHECK(steps(with_chains, jamb_m - 0.005F, jamb_m + 0.005F) < 1.5);
        CHECK(steps(over_single_edges, below_m, above_m) > 10);
    }
    // At 250 Hz the two products of a chain round a corner of the opening have opposite phases
    // here.
    CHECK(step(with_chains, {10.25F, 2.49F, 1.65F}, {10.25F, 2.5F, 1.65F}) < 1);
}

TEST_CASE("after a walk and a rest the direct sound is that of a first frame, to the bit") {
    const Scene scene = divided_room();
    Propagation walked(scene, scene.simulation);
    for (int frame = 0; frame < 60; ++frame) {
        const Vec3 listener =
            kBehindWall + Vec3(-0.05F, 0.04F, 0) * static_cast<float>(std::min(frame, 50));
        walked.step({.sources = {kSource}, .listeners = {listener}});
    }
    const auto expected = direct_of_frame_1(scene, kBehindWall + Vec3(-0.05F, 0.04F, 0) * 50.0F);
    const auto found = direct_of(walked.response(0));
    REQUIRE(!expected.empty());
    REQUIRE(found.size() == expected.size());
    CHECK(std::equal(found.begin(), found.end(), expected.begin(), same));
}

TEST_CASE("the direct sound between resting ends is that of a computation, to the bit") {
    // Two equal walks with rests. Changes of materials, to the same values, prevent that the second
    // one keeps its paths.
    const Scene scene = load_scene(AULA_SOURCE_DIR "/scenes/two_rooms.json").scene;
    const RayScene rays(scene);
    const Vec3 source = scene.sources[0].position_at(0);
    DirectSound kept(rays, 343.2F, 2);
    DirectSound computed(rays, 343.2F, 2);
    PairMemory memory_of_kept;
    PairMemory memory_of_computed;
    std::uint64_t most_equal = 0;
    for (int frame = 0; frame < 120; ++frame) {
        const int walked = frame < 60 ? std::min(frame, 20) : std::min(frame - 40, 45);
        const Vec3 listener =
            Vec3(8.6F, 1.9F, 1.65F) + static_cast<float>(walked) * Vec3(-0.009F, 0.005F, 0);
        const auto find = [&](DirectSound& direct, PairMemory& memory) {
            direct.begin_frame(false);
            direct.search(source, listener, memory);
            return direct.find(source, listener, {}, Bands{}, memory);
        };
        computed.materials_changed();
        const auto a = find(kept, memory_of_kept);
        const auto b = find(computed, memory_of_computed);
        CAPTURE(frame);
        REQUIRE(!a.empty());
        CHECK(std::equal(a.begin(), a.end(), b.begin(), b.end(), same));
        CHECK(memory_of_computed.equal_frames == 0);
        most_equal = std::max(most_equal, memory_of_kept.equal_frames);
    }
    CHECK(most_equal == NearEdges::kTurns);  // kept from then on
}

TEST_CASE("a resting listener hears a change of a material, a turn of the source and a door") {
    Scene scene = divided_room();
    scene.sources[0].directivity = Directivity::first_order(0.5F);
    Propagation propagation(scene, scene.simulation);
    FrameInput input = test::static_input(scene);
    const auto frame = [&] {
        propagation.step(input);
        return energy_of(direct_of(propagation.response(0)));
    };
    for (int i = 0; i < 30; ++i) frame();
    const Bands before = frame();
    CHECK(frame() == before);
    propagation.set_object_material(1, {"absorbing", Bands::filled(1), Bands{}});
    const Bands absorbing = frame();
    CHECK(absorbing != before);
    for (int i = 0; i < 30; ++i) frame();
    input.source_rotations = {glm::mat3(-1, 0, 0, 0, -1, 0, 0, 0, 1)};
    CHECK(frame() != absorbing);
}

TEST_CASE("a standing listener hears within two frames that a door has opened or shut") {
    // A leaf in the plane of the wall covers the opening, and 10 cm of the wall.
    Scene scene = divided_room();
    Object leaf;
    leaf.vertices = {{3, 2.5F, -0.1F}, {3, 4.1F, -0.1F}, {3, 4.1F, 3.1F}, {3, 2.5F, 3.1F}};
    leaf.triangles = {{0, 1, 2}, {0, 2, 3}};
    leaf.triangle_materials = {0, 0};
    leaf.movable = true;
    scene.objects.push_back(leaf);
    const auto input = [](const Vec3& listener, float open_m) {
        FrameInput frame{.sources = {kSource}, .listeners = {listener}};
        frame.objects.resize(3);
        frame.objects[2].translation = Vec3(0, -open_m, 0);
        return frame;
    };
    const auto level_db = [](const Propagation& propagation) {
        double energy = 1e-30;
        for (const SoundPath& path : direct_of(propagation.response(0)))
            energy += double{path.energy[4]};
        return 10 * std::log10(energy);
    };
    for (const Vec3& listener : {kBehindWall, Vec3(4, 3.8F, 1.5F)}) {
        Propagation open(scene, scene.simulation);
        open.step(input(listener, 2));
        const double open_db = level_db(open);
        Propagation propagation(scene, scene.simulation);
        for (int frame = 0; frame < 5; ++frame) propagation.step(input(listener, 0));
        CHECK(level_db(propagation) < open_db - 60);  // shut: companion
        propagation.step(input(listener, 2));
        CHECK(level_db(propagation) > open_db - 6.1);
        propagation.step(input(listener, 2));
        CHECK(level_db(propagation) > open_db - 3);
        for (int frame = 0; frame < 10; ++frame) propagation.step(input(listener, 2));
        CHECK(level_db(propagation) == Approx(open_db).margin(1e-6));
        propagation.step(input(listener, 0));
        propagation.step(input(listener, 0));
        CHECK(level_db(propagation) < open_db - 11.9);
        for (int frame = 0; frame < 10; ++frame) propagation.step(input(listener, 0));
        CHECK(direct_of(propagation.response(0)).empty());
    }
}

TEST_CASE("a standing listener hears within two frames of 32 sources that a door has opened") {
    // Round two edges of the doorway, from sources that the listener has never heard.
    Scene scene = load_scene(AULA_SOURCE_DIR "/scenes/two_rooms.json").scene;
    scene.simulation.rays = 1;
    scene.simulation.specular = false;
    scene.simulation.ir_length_s = 0.1F;
    Object leaf;
    leaf.vertices = {
        {6.1F, 1.9F, -0.1F}, {6.1F, 3.1F, -0.1F}, {6.1F, 3.1F, 2.2F}, {6.1F, 1.9F, 2.2F}};
    leaf.triangles = {{0, 1, 2}, {0, 2, 3}};
    leaf.triangle_materials = {0, 0};
    leaf.movable = true;
    scene.objects.push_back(leaf);
    scene.sources.resize(1);
    scene.sources[0].path.reset();
    for (int i = 0; i < 32; ++i) {
        if (i > 0) scene.sources.push_back(scene.sources[0]);
        scene.sources.back().position = Vec3(1.2F + 0.05F * static_cast<float>(i), 0.9F, 1.5F);
    }
    FrameInput input = test::static_input(scene);
    input.listeners[0] = Vec3(8.6F, 0.4F, 1.65F);
    input.objects.resize(scene.objects.size());
    const auto chains_db = [&](const Propagation& propagation) {
        std::vector<double> levels;
        for (std::size_t s = 0; s < scene.sources.size(); ++s) {
            Bands energy;
            for (const SoundPath& path : direct_of(propagation.response(s)))
                if (path.edges > 1) energy += path.energy;
            levels.push_back(10 * std::log10(double{energy[3]} + 1e-30));
        }
        return levels;
    };
    Propagation propagation(scene, scene.simulation);
    for (int frame = 0; frame < 3; ++frame) propagation.step(input);
    for (const double level : chains_db(propagation)) CHECK(level == -300);
    input.objects.back().translation = Vec3(0, 0, 10);
    propagation.step(input);
    propagation.step(input);
    Propagation open(scene, scene.simulation);
    open.step(input);
    const auto expected = chains_db(open);
    const auto heard = chains_db(propagation);
    for (std::size_t s = 0; s < heard.size(); ++s) {
        CAPTURE(s, expected[s], heard[s]);
        CHECK(expected[s] > -80);
        CHECK(heard[s] > expected[s] - 3);  // half of the pressure after each frame
    }
}
