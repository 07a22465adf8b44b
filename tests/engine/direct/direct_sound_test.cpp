#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "aula/engine/propagation.h"
#include "aula/engine/room_acoustics.h"
#include "aula/engine/scene_file.h"
#include "engine/direct/direct_sound.h"
#include "engine/trace/specular_paths.h"
#include "tests/engine/direct/divided_room.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"

using namespace aula;
using aula::test::direct_of;
using aula::test::direct_of_frame_1;
using aula::test::divided_room;
using aula::test::kBehindWall;
using aula::test::kInSight;
using aula::test::kSource;
using aula::test::same;

namespace {

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
        direct_sound.search(kSource, listener, memory);
        const std::vector<SoundPath> expected =
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
                    // One ray: the first frame is where the scene's listener is, 100: elsewhere.
                    scene.listener.pose.position = ray_count == 1 ? listener : kSource;
                    const auto direct = direct_of_frame_1(scene, listener);
                    CAPTURE(estimator_name(estimator), specular, ray_count);
                    REQUIRE(direct.size() == expected.size());
                    CHECK(std::equal(direct.begin(), direct.end(), expected.begin(), same));
                    CHECK(std::count_if(direct.begin(), direct.end(),
                                        [](const SoundPath& p) { return p.is_main; }) == 1);
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
            for (const SoundPath& path : direct_of(runs[0]->response(s)))
                has_chain |= path.edges > 1;
        }
    }
    CHECK(has_chain);
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
    for (const SoundPath& path : direct_of(propagation.response(0))) sum += path.energy;
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
