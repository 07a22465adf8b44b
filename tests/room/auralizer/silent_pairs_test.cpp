#include <catch2/catch.hpp>
#include <cmath>

#include "tests/room/auralizer/auralizer_rendering.h"

namespace silent_pairs_test {

namespace {

using namespace aula;
using test::at;
using test::mono;
using test::noise_at;
using test::rendered;

constexpr std::int64_t kSecond = 48000;

/// The small room with its source at (1.2, 1.1, 1.5) and its listener at (3.7, 2.9, 1.2), of a
/// length: 5 m as it is.
Scene room(float length_m = 5) {
    Scene scene = test::small_room();
    scene.simulation.rays = 100;
    scene.simulation.ir_length_s = 0.3F;
    for (Vec3& corner : scene.objects[0].vertices) corner.x *= length_m / 5;
    return scene;
}

/// The greatest number of silent pairs while blocks are rendered.
std::size_t most_silent(Auralizer& auralizer, std::int64_t length) {
    std::size_t most = 0;
    rendered(auralizer, length, {480}, noise_at,
             [&](std::int64_t) { most = std::max(most, auralizer.status().silent_pairs); });
    return std::max(most, auralizer.status().silent_pairs);
}

}  // namespace

TEST_CASE("A listener outside of an exchanged room is in the status until it is inside") {
    Auralizer auralizer(room(), mono());
    CHECK(most_silent(auralizer, kSecond) == 0);
    auralizer.set_scene(room(3));
    CHECK(most_silent(auralizer, kSecond * 2 / 5) == 0);  // not of a few frames
    rendered(auralizer, kSecond / 5, {480}, noise_at);
    CHECK(auralizer.status().silent_pairs == 1);
    CHECK(auralizer.silent({1}));
    // A room that does not contain it either: the status does not change meanwhile.
    auralizer.set_scene(room(2.5F));
    std::size_t frames = 0;
    rendered(auralizer, kSecond, {480}, noise_at,
             [&](std::int64_t) { frames += auralizer.status().silent_pairs; });
    CHECK(frames == 100);
    auralizer.set_listener(at(2, 2, 1));
    rendered(auralizer, kSecond / 10, {480}, noise_at);
    CHECK(auralizer.status().silent_pairs == 0);
    CHECK_FALSE(auralizer.silent({1}));
    // The sound is there as well.
    const auto heard = rendered(auralizer, kSecond / 10, {480}, noise_at);
    CHECK(std::any_of(heard.begin(), heard.end(), [](float x) { return std::abs(x) > 1e-3F; }));
    auralizer.set_listener(at(2, 2, 4));
    rendered(auralizer, kSecond, {480}, noise_at);
    CHECK(auralizer.status().silent_pairs == 1);
    const auto silence = rendered(auralizer, kSecond / 10, {480}, noise_at);
    CHECK(std::all_of(silence.begin(), silence.end(), [](float x) { return x == 0; }));
    auralizer.set_scene(room());
    auralizer.set_listener(at(2, 2, 1));
    rendered(auralizer, kSecond / 10, {480}, noise_at);
    CHECK(auralizer.status().silent_pairs == 0);
}

TEST_CASE("Pairs are silent with any estimator, and where a source is inside of an object") {
    const Estimator estimator = GENERATE(Estimator::patch, Estimator::dpc, Estimator::pt);
    INFO(estimator_name(estimator));
    Scene scene = room();
    scene.simulation.estimator = estimator;
    Object cabinet = scene.objects[0];
    for (Vec3& corner : cabinet.vertices) corner = corner * 0.2F;  // 1 m x 0.8 m x 0.6 m
    // Not on the floor, whose patches have energy from inside and outside of it.
    cabinet.translation = {3, 1, 0.5F};
    scene.objects.push_back(cabinet);
    AuralizerOptions options = mono();
    options.listeners = 2;
    Auralizer auralizer(scene, options);
    const SourceId buried = auralizer.add_source({.position = {3.5F, 1.4F, 0.8F}});
    const SourceId free = auralizer.add_source({.position = {2, 2, 2}, .gain_db = -INFINITY});
    auralizer.set_listener(1, at(2, 2, -1));
    rendered(auralizer, 2 * kSecond, {480}, noise_at);
    CHECK(auralizer.status().silent_pairs == 4);
    for (const SourceId source : {SourceId{1}, buried, free}) {
        CHECK(auralizer.silent(source, 0) == (source == buried));
        CHECK(auralizer.silent(source, 1));
    }
    CHECK_FALSE(auralizer.silent(buried, 2));
    CHECK_FALSE(auralizer.silent({99}));
    auralizer.remove_source(buried);
    rendered(auralizer, kSecond / 10, {480}, noise_at);
    CHECK(auralizer.status().silent_pairs == 2);
    CHECK_FALSE(auralizer.silent(buried));
}

TEST_CASE("A quiet source is not a silent one") {
    SECTION("muted") {
        Auralizer auralizer(room(), mono());
        auralizer.set_gain({1}, -INFINITY);
        auralizer.set_part_gains({.direct = 0, .early = 0, .late = 0});
        CHECK(most_silent(auralizer, 2 * kSecond) == 0);
    }
    SECTION("a kilometre away") {
        Auralizer auralizer(test::free_field({1000, 0, 0}), mono());
        CHECK(most_silent(auralizer, 2 * kSecond) == 0);
    }
    SECTION("outside of walls that transmit a millionth") {
        Scene scene = room();
        scene.materials[0].sound_reduction_db = Bands::filled(60);
        Auralizer auralizer(scene, mono());
        auralizer.set_listener(at(8, 2, 1));
        CHECK(most_silent(auralizer, 2 * kSecond) == 0);
    }
    SECTION("behind a wall with a small opening, of which few rays know") {
        Scene scene = room();
        scene.simulation.rays = 20;
        scene.materials[0].absorption = Bands::filled(0.9F);
        Object wall;
        wall.vertices = {{2.5F, 0, 0}, {2.5F, 3.9F, 0}, {2.5F, 3.9F, 3}, {2.5F, 0, 3}};
        wall.triangles = {{0, 1, 2}, {0, 2, 3}};
        wall.triangle_materials = {0, 0};
        scene.objects.push_back(wall);
        Auralizer auralizer(scene, mono());
        CHECK(most_silent(auralizer, 2 * kSecond) == 0);
    }
}

}  // namespace silent_pairs_test
