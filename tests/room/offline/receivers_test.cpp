#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "apps/room/offline/static_propagation.h"
#include "aula/engine/room_acoustics.h"
#include "aula/exception.h"
#include "aula/measurement.h"
#include "tests/support/test_scenes.h"

namespace receivers_test {

namespace {

using namespace aula;
using test::small_room;

std::vector<Pose> poses(std::initializer_list<Vec3> positions) {
    std::vector<Pose> all;
    for (const Vec3& position : positions) all.push_back({.position = position});
    return all;
}

/// The small room with a second source, and an object that diffracts if `screen`.
Scene room_of_two(bool screen = false) {
    Scene scene = small_room();
    scene.sources.push_back(scene.sources[0]);
    scene.sources[1].name = "second";
    scene.sources[1].position = {4.4F, 3.3F, 2.2F};
    scene.sources[1].directivity = Directivity::first_order(0.5F);
    if (!screen) return scene;
    Object wall;
    wall.vertices = {{2.5F, 0.5F, 0.1F}, {2.5F, 0.5F, 2}, {2.5F, 2.5F, 2}, {2.5F, 2.5F, 0.1F}};
    wall.triangles = {{0, 1, 2}, {0, 2, 3}};
    wall.triangle_materials.assign(2, 0);
    scene.objects.push_back(wall);
    return scene;
}

double level_db(const EnergyResponse& response, std::size_t band) {
    return 10 * std::log10(response.total(band));
}

}  // namespace

TEST_CASE("The first of several receivers has to the bit the response that it has alone") {
    Scene scene = room_of_two(true);
    scene.simulation.rays = 100;
    const auto receivers = poses({{3.7F, 2.9F, 1.2F}, {1, 3, 1}, {3, 0.6F, 2}});
    const auto all = measure(scene, scene.sources, receivers, {.frames = 10});
    const auto alone = measure(scene, {.frames = 10});
    REQUIRE(all);
    REQUIRE(all->responses.size() == 6);
    for (std::size_t s = 0; s < 2; ++s) {
        CHECK(all->response(s, 0).energy == alone->response(s).energy);
        CHECK(all->response(s, 0).directions == alone->response(s).directions);
        REQUIRE(all->response(s, 0).paths.size() == alone->response(s).paths.size());
        // Companion: the other receivers hear something else.
        CHECK(all->response(s, 1).energy != alone->response(s).energy);
    }
}

TEST_CASE("Each receiver has the response that it has alone, within the standard errors") {
    for (const float scattering : {0.5F, 0.1F}) {
        Scene scene = room_of_two();
        scene.simulation.rays = 100;
        scene.materials[0].scattering = Bands::filled(scattering);
        const auto receivers = poses({{3.7F, 2.9F, 1.2F}, {1, 3, 1}, {4.5F, 0.5F, 2.7F}});
        const MeasurementOptions options{
            .limits = {.level_db = 0.1, .c80_db = 0.2, .t30 = 0.02, .edt = 0.02}};
        const auto all = measure(scene, scene.sources, receivers, options);
        REQUIRE(all);
        CHECK(all->warnings.empty());
        for (std::size_t r = 1; r < receivers.size(); ++r) {
            const auto alone = measure(scene, scene.sources, std::span(&receivers[r], 1), options);
            for (std::size_t s = 0; s < 2; ++s) {
                for (std::size_t band = 1; band < 7; ++band) {
                    INFO("scattering " << scattering << ", source " << s << ", receiver " << r
                                       << ", band " << band);
                    // Statistical: errors of at most 0.1 dB, 0.2 dB and 2 % each, 1.41 times these
                    // in the difference; four of them.
                    CHECK(level_db(all->response(s, r), band) ==
                          Approx(level_db(alone->response(s), band)).margin(0.57));
                    const auto value = [&](const Measurement& m, AcousticParameter parameter,
                                           std::size_t receiver) {
                        return *m.parameters[m.pair(s, receiver)].octave(parameter, band).value;
                    };
                    CHECK(value(*all, AcousticParameter::c80, r) ==
                          Approx(value(*alone, AcousticParameter::c80, 0)).margin(1.13));
                    CHECK(value(*all, AcousticParameter::t30, r) ==
                          Approx(value(*alone, AcousticParameter::t30, 0)).epsilon(0.113));
                }
            }
        }
        // Companion: the level differs from receiver to receiver by more.
        CHECK(level_db(all->response(0, 1), 4) !=
              Approx(level_db(all->response(0, 2), 4)).margin(0.57));
    }
}

TEST_CASE("Receivers hear direct sound, reflections and diffraction as a listener does") {
    Scene scene = room_of_two(true);
    scene.simulation.rays = 50;
    // In the shadow of the screen, and beside it.
    const auto receivers = poses({{3.7F, 2.9F, 1.2F}, {4, 1.5F, 0.8F}, {1, 3.2F, 1}});
    const auto all = measure(scene, scene.sources, receivers, {.frames = 32});
    for (std::size_t r = 1; r < receivers.size(); ++r) {
        const auto alone =
            measure(scene, scene.sources, std::span(&receivers[r], 1), {.frames = 32});
        for (std::size_t s = 0; s < 2; ++s) {
            const auto& paths = all->response(s, r).paths;
            const auto& expected = alone->response(s).paths;
            REQUIRE(paths.size() == expected.size());
            for (std::size_t i = 0; i < paths.size(); ++i) {
                INFO("source " << s << ", receiver " << r << ", path " << i);
                CHECK(paths[i].key == expected[i].key);
                CHECK(paths[i].edges == expected[i].edges);
                // Rounding: the mean of equal values.
                CHECK(paths[i].length_m == Approx(expected[i].length_m).epsilon(1e-6));
                for (std::size_t band = 0; band < kBandCount; ++band)
                    CHECK(paths[i].energy[band] == Approx(expected[i].energy[band]).epsilon(1e-4));
            }
        }
    }
    // Companion: some of the paths bend around the screen.
    CHECK(std::any_of(all->response(0, 1).paths.begin(), all->response(0, 1).paths.end(),
                      [](const SoundPath& path) { return path.edges > 0; }));
}

TEST_CASE("Every receiver has standard errors, unless the frames are given") {
    Scene scene = room_of_two();
    scene.simulation.rays = 100;
    const auto receivers = poses({{3.7F, 2.9F, 1.2F}, {1, 3, 1}});
    const MeasurementOptions options{
        .limits = {.level_db = 0.2, .c80_db = 0.4, .t30 = 0.04, .edt = 0.04}};
    const auto certain = measure(scene, scene.sources, receivers, options);
    const auto given = measure(scene, scene.sources, receivers, {.frames = 5});
    REQUIRE(certain->parameters.size() == 4);
    for (std::size_t pair = 0; pair < 4; ++pair) {
        for (std::size_t band = 1; band < 7; ++band) {
            const MeasuredValue& t30 =
                certain->parameters[pair].octave(AcousticParameter::t30, band);
            const RoomParameters expected = room_parameters(certain->responses[pair]);
            CHECK(t30.value == expected[band].t30_s);
            REQUIRE(t30.standard_error);
            CHECK(*t30.standard_error > 0);
            CHECK(*t30.standard_error < 0.04 * *t30.value);
            const MeasuredValue& without_error =
                given->parameters[pair].octave(AcousticParameter::t30, band);
            CHECK(without_error.value);
            CHECK_FALSE(without_error.standard_error);
        }
    }
    CHECK(measure(scene, {.frames = 1, .parameters = false})->parameters.empty());
}

TEST_CASE("Measurements of other estimators have several receivers, too") {
    Scene scene = small_room();
    scene.simulation.rays = 200;
    scene.simulation.estimator = Estimator::dpc;
    const auto receivers = poses({{3.7F, 2.9F, 1.2F}, {1, 3, 1}});
    const auto all = measure(scene, scene.sources, receivers, {.frames = 30});
    REQUIRE(all->responses.size() == 2);
    scene.simulation.estimator = Estimator::patch;
    const auto patch = measure(scene, scene.sources, receivers, {.frames = 30});
    // Statistical: 6000 rays detected by spheres of 0.5 m; the level's error is some 0.1 dB.
    for (std::size_t r = 0; r < 2; ++r)
        CHECK(level_db(all->response(0, r), 4) ==
              Approx(level_db(patch->response(0, r), 4)).margin(0.5));
}

TEST_CASE("A measurement without sources, receivers or frames is an error") {
    const Scene scene = small_room();
    const auto here = poses({{1, 1, 1}});
    CHECK_THROWS_AS(measure(scene, {}, here), InputError);
    CHECK_THROWS_AS(measure(scene, scene.sources, {}), InputError);
    // Intersection tests of coordinates beyond 1e6 m overflow.
    for (const float y : {std::numeric_limits<float>::quiet_NaN(), 2e6F, -1e30F})
        CHECK_THROWS_AS(measure(scene, scene.sources, poses({{1, y, 1}})), InputError);
    CHECK_THROWS_AS(measure(scene, scene.sources, here, {.frames = 0}), InputError);
    CHECK_THROWS_AS(measure(scene, scene.sources, here, {.limits = {.t30 = 0}}), InputError);
    const auto measurement = measure(scene, scene.sources, here, {.frames = 1});
    CHECK_THROWS_AS(ImpulseResponses(*measurement, {.sample_rate_hz = 7000}), InputError);
    CHECK_THROWS_AS(ImpulseResponses(*measurement, {.ambisonic_order = 4}), InputError);
    CHECK_THROWS_AS(ImpulseResponses(*measurement, {.block = 0}), InputError);
}

TEST_CASE("A few further receivers gather more often than many") {
    CHECK(StaticPropagation::gather_frames(1) == 2);
    CHECK(StaticPropagation::gather_frames(8) == 2);
    CHECK(StaticPropagation::gather_frames(9) == 4);
    CHECK(StaticPropagation::gather_frames(17) == 8);
}

}  // namespace receivers_test
