#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "aula/engine/propagation.h"
#include "aula/engine/room_acoustics.h"
#include "aula/engine/scene_file.h"
#include "engine/direct/direct_sound.h"
#include "engine/trace/specular_paths.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"

using namespace aula;

namespace {

const Vec3 kSource(1, 1, 1.5F);
const Vec3 kBehindWall(5, 1.2F, 1.5F);
const Vec3 kInSight(2, 3, 1.5F);

/// A closed box of 6 x 4 x 3 m, and a thin wall at x = 3 m from y = 0 to y = 2.6 m.
Scene divided_room() {
    Scene scene;
    Object box;
    for (int i = 0; i < 8; ++i) {
        box.vertices.emplace_back((i & 1) != 0 ? 6 : 0, (i & 2) != 0 ? 4 : 0, (i & 4) != 0 ? 3 : 0);
    }
    const auto add_quad = [](Object& object, std::uint32_t a, std::uint32_t b, std::uint32_t c,
                             std::uint32_t d) {
        object.triangles.push_back({a, b, c});
        object.triangles.push_back({a, c, d});
        object.triangle_materials.insert(object.triangle_materials.end(), 2, 0);
    };
    add_quad(box, 0, 1, 3, 2);
    add_quad(box, 4, 6, 7, 5);
    add_quad(box, 0, 4, 5, 1);
    add_quad(box, 2, 3, 7, 6);
    add_quad(box, 0, 2, 6, 4);
    add_quad(box, 1, 5, 7, 3);
    Object wall;
    wall.vertices = {{3, 0, 0}, {3, 2.6F, 0}, {3, 2.6F, 3}, {3, 0, 3}};
    add_quad(wall, 0, 1, 2, 3);
    scene.objects = {box, wall};
    scene.materials = {{"wall", Bands::filled(0.3F), Bands::filled(0.5F)}};
    scene.sources.emplace_back();
    scene.sources[0].position = kSource;
    scene.listener.pose.position = kBehindWall;
    scene.simulation.ir_length_s = 0.2F;
    scene.simulation.rays = 1;
    scene.simulation.threads = 2;
    return scene;
}

std::vector<SpecularPath> direct_of(const EnergyResponse& response) {
    std::vector<SpecularPath> direct;
    std::copy_if(response.paths.begin(), response.paths.end(), std::back_inserter(direct),
                 [](const SpecularPath& path) { return path.order == 0; });
    return direct;
}

Bands energy_of(const std::vector<SpecularPath>& paths) {
    Bands sum;
    for (const SpecularPath& path : paths) sum += path.energy;
    return sum;
}

std::vector<SpecularPath> direct_of_frame_1(const Scene& scene, const Vec3& listener) {
    Propagation propagation(scene, scene.simulation);
    propagation.step({.sources = {kSource}, .listeners = {listener}});
    return direct_of(propagation.response(0));
}

bool same(const SpecularPath& a, const SpecularPath& b) {
    return a.length_m == b.length_m && a.direction == b.direction && a.energy == b.energy &&
           a.id == b.id && a.edges == b.edges;
}

constexpr Estimator kEstimators[] = {Estimator::pt, Estimator::dpc_published, Estimator::dpc,
                                     Estimator::patch};

}  // namespace

TEST_CASE("all estimators have the diffracted direct sound in the first frame, with any rays") {
    const Scene room = divided_room();
    const RayScene rays(room);
    DirectSound direct_sound(rays, room.medium.speed_of_sound_m_s(),
                             room.simulation.diffraction_order);
    for (const Vec3& listener : {kBehindWall, kInSight}) {
        PairMemory memory;
        direct_sound.begin_frame(false);
        direct_sound.search(std::span(&kSource, 1), std::span(&listener, 1), std::span(&memory, 1));
        const std::vector<SpecularPath> expected =
            direct_sound.find(kSource, listener, {}, room.medium.attenuation_per_m(), memory);
        REQUIRE(!expected.empty());
        CHECK((expected[0].edges == 1) == (listener == kBehindWall));
        for (const Estimator estimator : kEstimators) {
            for (const bool specular : {true, false}) {
                for (const int ray_count : {1, 100}) {
                    Scene scene = room;
                    scene.simulation.estimator = estimator;
                    scene.simulation.specular = specular;
                    scene.simulation.rays = ray_count;
                    const auto direct = direct_of_frame_1(scene, listener);
                    CAPTURE(estimator_name(estimator), specular, ray_count);
                    REQUIRE(direct.size() == expected.size());
                    CHECK(std::equal(direct.begin(), direct.end(), expected.begin(), same));
                    CHECK(std::count_if(direct.begin(), direct.end(),
                                        [](const SpecularPath& p) { return p.id == 0; }) == 1);
                }
            }
        }
    }
}

TEST_CASE("without direct sound there is no diffraction") {
    Scene scene = divided_room();
    REQUIRE(!direct_of_frame_1(scene, kBehindWall).empty());
    scene.simulation.direct = false;
    CHECK(direct_of_frame_1(scene, kBehindWall).empty());
    CHECK(direct_of_frame_1(scene, kInSight).empty());
}

TEST_CASE("diffraction order 0 gives the straight path alone, to the bit") {
    Scene scene = divided_room();
    scene.simulation.diffraction_order = 0;
    const RayScene rays(scene);
    const SpecularPaths straight(rays, 0, 0.5F, 1);
    const auto expected =
        straight.find(kSource, kInSight, true, scene.medium.attenuation_per_m()).paths;
    REQUIRE(expected.size() == 1);
    const auto found = direct_of_frame_1(scene, kInSight);
    REQUIRE(found.size() == 1);
    CHECK(same(found[0], expected[0]));
    CHECK(direct_of_frame_1(scene, kBehindWall).empty());

    // With diffraction, the edge changes the level beside it as well.
    scene.simulation.diffraction_order = 1;
    const auto bent = direct_of_frame_1(scene, kInSight);
    REQUIRE(!bent.empty());
    CHECK(bent[0].edges == 0);
    CHECK_FALSE(same(bent[0], expected[0]));
}

TEST_CASE(
    "a straight path that no edge changes is the same with and without diffraction, to the bit") {
    // The edges of a closed box are outside.
    Scene scene = divided_room();
    scene.objects.pop_back();
    const auto with_diffraction = direct_of_frame_1(scene, kInSight);
    scene.simulation.diffraction_order = 0;
    const auto without = direct_of_frame_1(scene, kInSight);
    REQUIRE(with_diffraction.size() == 1);
    REQUIRE(without.size() == 1);
    CHECK(same(with_diffraction[0], without[0]));
}

TEST_CASE("diffracted direct sound is the same with any number of threads") {
    Scene scene = divided_room();
    for (const float x : {1.5F, 2.2F, 4.1F}) {
        scene.sources.push_back(scene.sources[0]);
        scene.sources.back().position = Vec3(x, 0.7F, 1.2F);
    }
    std::vector<EnergyResponse> results[2];
    for (const int threads : {1, 3}) {
        scene.simulation.threads = threads;
        Propagation propagation(scene, scene.simulation);
        for (int frame = 0; frame < 3; ++frame) {
            FrameInput input = test::static_input(scene);
            input.listeners[0].y += 0.1F * static_cast<float>(frame);
            propagation.step(input);
        }
        for (std::size_t s = 0; s < scene.sources.size(); ++s)
            results[threads / 2].push_back(propagation.response(s));
    }
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        CHECK(!direct_of(results[0][s]).empty());
        CHECK(test::same_bits(results[0][s], results[1][s]));
    }
}

TEST_CASE("direct sound that edges diffract defines the time zero of parameters") {
    // In a room without reflections all energy is direct sound: D50 is 1 behind the wall, too.
    Scene scene = divided_room();
    scene.materials[0].absorption = Bands::filled(1);
    Propagation propagation(scene, scene.simulation);
    propagation.step({.sources = {kSource}, .listeners = {kBehindWall}});
    const EnergyResponse& response = propagation.response(0);
    const auto direct = direct_of(response);
    REQUIRE(!direct.empty());
    const double detour_s = double{direct[0].length_m - glm::distance(kSource, kBehindWall)} / 343;
    CHECK(detour_s > 1e-4);
    for (const BandParameters& band : room_parameters(response)) {
        REQUIRE(band.d50);
        CHECK(*band.d50 == Approx(1));
        REQUIRE(band.ts_s);
        CHECK(*band.ts_s == Approx(0).margin(1e-6));  // re the bent path, not the straight one
    }
}

TEST_CASE("through the doorways of the shipped scenes no octave of the direct sound jumps") {
    // The whole walk of each scene in steps of 1 cm, and across the study past the open door.
    constexpr std::array kBound_db{0.2, 0.2, 0.2, 0.3, 0.4, 0.5, 0.8, 1.2};  // per centimetre
    struct Walk {
        const char* file;
        std::vector<Vec3> places;
    };
    const auto scene_of = [](const char* file) {
        Scene scene = load_scene(std::string(AULA_SOURCE_DIR "/scenes/") + file).scene;
        scene.simulation.transmission = false;
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
    std::vector<Walk> walks;
    for (const char* file : {"two_rooms.json", "door.json"}) {
        walks.push_back({file, path_of(scene_of(file))});
    }
    walks.push_back({"door.json", {}});
    for (int cm = 0; cm < 460; ++cm) {
        walks.back().places.emplace_back(6.2F, -0.3F + 0.01F * static_cast<float>(cm), 1.6F);
    }
    for (const Walk& walk : walks) {
        const Scene scene = scene_of(walk.file);
        const Vec3 source = scene.sources[0].position_at(0);
        // Companion: without what the walk remembers, each frame is a first one.
        const RayScene rays(scene);
        DirectSound fresh(rays, scene.medium.speed_of_sound_m_s(),
                          scene.simulation.diffraction_order);
        double largest_fresh = 0;
        Propagation propagation(scene, scene.simulation);
        double largest = 0;
        Bands last;
        Bands last_fresh;
        for (std::size_t i = 0; i < walk.places.size(); ++i) {
            propagation.step({.sources = {source}, .listeners = {walk.places[i]}});
            PairMemory memory;
            fresh.begin_frame(false);
            fresh.search(std::span(&source, 1), std::span(&walk.places[i], 1),
                         std::span(&memory, 1));
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
        CAPTURE(walk.file, walk.places.size());
        CHECK(largest < 1);
        CHECK(largest_fresh > 2);
    }
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
            direct.search(std::span(&source, 1), std::span(&listener, 1), std::span(&memory, 1));
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

TEST_CASE("chains of several sources are the same with any number of threads") {
    Scene scene = load_scene(AULA_SOURCE_DIR "/scenes/two_rooms.json").scene;
    scene.simulation.rays = 1;
    scene.simulation.ir_length_s = 0.1F;
    scene.sources.resize(1);
    for (const float y : {1.5F, 2.6F, 3.4F, 4.1F, 4.6F}) {
        scene.sources.push_back(scene.sources[0]);
        scene.sources.back().position.y = y;
    }
    std::vector<std::unique_ptr<Propagation>> runs;
    for (const int threads : {1, 3}) {
        scene.simulation.threads = threads;
        runs.push_back(std::make_unique<Propagation>(scene, scene.simulation));
    }
    bool has_chain = false;
    for (int i = 0; i < 30; ++i) {
        FrameInput input = test::static_input(scene);
        input.listeners[0] = Vec3(9 - 0.04F * static_cast<float>(i), 0.5F, 1.6F);
        for (const auto& run : runs) run->step(input);
        for (std::size_t s = 0; s < scene.sources.size(); ++s) {
            CHECK(test::same_bits(runs[0]->response(s), runs[1]->response(s)));
            for (const SpecularPath& path : direct_of(runs[0]->response(s)))
                has_chain |= path.edges > 1;
        }
    }
    CHECK(has_chain);
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
        for (const SpecularPath& path : direct_of(propagation.response(0)))
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
            for (const SpecularPath& path : direct_of(propagation.response(s)))
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

namespace {

/// A box of a given width in the middle of a straight path.
Object cube(float width_m, const Vec3& centre) {
    return aula::test::box(Vec3(width_m), 0, centre - Vec3(width_m / 2));
}

/// Energy of the direct sound over 4 m relative to free field.
std::vector<float> shares_of_free_field(const std::vector<Object>& objects) {
    Scene scene;
    scene.objects = objects;
    scene.materials = {{"rigid", Bands{}, Bands{}}};
    scene.sources.emplace_back();
    scene.sources[0].position = Vec3(-2, 0, 0);
    scene.simulation.ir_length_s = 0.2F;
    scene.simulation.rays = 1;
    scene.simulation.threads = 1;
    Bands sum;
    Propagation propagation(scene, scene.simulation);
    propagation.step({.sources = {Vec3(-2, 0, 0)}, .listeners = {Vec3(2, 0, 0)}});
    for (const SpecularPath& path : direct_of(propagation.response(0))) sum += path.energy;
    const Bands air = scene.medium.attenuation_per_m();
    std::vector<float> shares;
    for (std::size_t b = 0; b < kBandCount; ++b)
        shares.push_back(sum[b] * 4 * std::numbers::pi_v<float> * 16 * std::exp(4 * air[b]));
    return shares;
}

}  // namespace

TEST_CASE("an object below 0.3 m leaves the direct sound free, the bricks of a wall do not") {
    for (const float width_m : {0.02F, 0.09F, 0.169F}) {
        for (const float share : shares_of_free_field({cube(width_m, Vec3(0))}))
            CHECK(share == Approx(1));
    }
    std::vector<Object> wall;
    for (int y = -10; y <= 10; ++y) {
        for (int z = -10; z <= 10; ++z) {
            wall.push_back(
                cube(0.16F, 0.16F * Vec3(0, static_cast<float>(y), static_cast<float>(z))));
        }
    }
    const std::vector<float> behind_wall = shares_of_free_field(wall);
    CHECK(behind_wall.back() < 0.25F);
}
