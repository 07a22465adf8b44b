#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>

#include "aula/exception.h"
#include "tests/room/auralizer/auralizer_rendering.h"
#include "tests/support/tone.h"
#include "tests/support/wait.h"

namespace scene_exchange_test {

namespace {

using namespace aula;
using test::at;
using test::mono;
using test::noise_at;
using test::rendered;
using test::share_off_tone;
using test::tone_at;

constexpr std::int64_t kSecond = 48000;

Scene dry_room() {
    Scene scene = test::small_room();
    scene.simulation.rays = 100;
    scene.simulation.ir_length_s = 0.3F;
    return scene;
}

/// The same room with another absorption and another length of the responses.
Scene other_room() {
    Scene scene = dry_room();
    scene.materials[0].absorption = Bands::filled(0.9F);
    scene.simulation.ir_length_s = 0.2F;
    return scene;
}

RigidTransform moved_by(const Vec3& way) { return {glm::mat3(1), way}; }

/// The dry room with two movable panels in either order. Source and listener see each other along y
/// = 1: a way of -1.5 m along y brings the screen in between, and the door not.
Scene room_with_objects(bool door_first) {
    Scene scene = dry_room();
    scene.simulation.frame_rate_hz = 200;
    scene.sources[0].position = {1, 1, 1.5F};
    scene.listener.pose.position = {4, 1, 1.5F};
    const auto add_panel = [&](const std::string& name, const Vec3& place) {
        Object panel;
        panel.name = name;
        panel.vertices = {{0, -0.5F, -0.5F}, {0, 0.5F, -0.5F}, {0, 0.5F, 0.5F}, {0, -0.5F, 0.5F}};
        panel.triangles = {{0, 1, 2}, {0, 2, 3}};
        panel.triangle_materials = {0, 0};
        panel.translation = place;
        panel.movable = true;
        scene.objects.push_back(panel);
    };
    if (door_first) add_panel("door", {3.5F, 3.3F, 1.4F});
    add_panel("screen", {2.5F, 2.6F, 1.4F});
    if (!door_first) add_panel("door", {3.5F, 3.3F, 1.4F});
    return scene;
}

/// The largest difference of two renderings.
double difference(const std::vector<float>& a, const std::vector<float>& b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        worst = std::max(worst, static_cast<double>(std::abs(a[i] - b[i])));
    return worst;
}

double energy(const std::vector<float>& samples, std::int64_t from, std::int64_t to) {
    double sum = 0;
    for (std::int64_t i = from; i < to; ++i)
        sum += std::pow(static_cast<double>(samples[static_cast<std::size_t>(i)]), 2);
    return sum;
}

}  // namespace

TEST_CASE("A change to the same scene is inaudible") {
    // Over 100 m sound travels for 0.29 s, much longer than the reverberation.
    const float distance_m = GENERATE(3.0F, 100.0F);
    Scene scene = test::free_field({distance_m, 0, 0});
    scene.simulation.ir_length_s = 0.1F;
    const auto output = [&](bool changes) {
        Auralizer auralizer(scene, mono());
        if (changes) {
            auralizer.set_scene(scene, kSecond / 3);
            auralizer.set_scene(scene, kSecond / 3 + 1000);  // while the one before fades in
        }
        return rendered(auralizer, 2 * kSecond, {256}, tone_at);
    };
    const auto through = output(false);
    const auto changed = output(true);
    const float loudest = *std::max_element(through.begin(), through.end());
    REQUIRE(loudest > 0.0005F);
    // Rounding: transforms and filters of single precision, some hundred operations of 6e-8.
    CHECK(difference(through, changed) < 2e-5 * static_cast<double>(loudest));
}

TEST_CASE("A tone has no clicks while the scene changes, on both clocks") {
    const RenderClock clock = GENERATE(RenderClock::exact, RenderClock::real_time);
    Scene third = dry_room();
    third.simulation.frame_rate_hz = 50;
    third.objects[0].translation.x = 0.3F;
    Auralizer auralizer(dry_room(), mono(clock));
    REQUIRE(test::eventually(
        [&] { return clock == RenderClock::exact || auralizer.status().frames > 0; }));
    int block = 0;
    const auto output = rendered(auralizer, 2 * kSecond, {256}, tone_at, [&](std::int64_t) {
        if (block == 60) auralizer.set_scene(other_room());
        if (block == 70) auralizer.set_scene(third);
        if (block == 76) auralizer.set_scene(dry_room());
        if (block == 90) auralizer.set_scene(other_room());
        ++block;
        if (clock == RenderClock::real_time)
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
    });
    const double share = share_off_tone(output);
    INFO("off the tone: " << 10 * std::log10(share) << " dB");
    CHECK(share < 1e-6);

    // Companion: a hard cut from one room to the other.
    Auralizer other(other_room(), mono());
    const auto after = rendered(other, 2 * kSecond, {256}, tone_at);
    auto cut = output;
    std::copy(after.begin() + kSecond / 2, after.end(), cut.begin() + kSecond / 2);
    CHECK(share_off_tone(cut) > 1e-6);
}

TEST_CASE("With changes of the scene any blocks and any number of threads give the same bytes") {
    const auto output = [](int threads, const std::vector<int>& sizes, bool early) {
        Scene first = test::room_with_panel();
        Scene second = other_room();
        Scene third = test::room_with_panel();
        third.simulation.frame_rate_hz = 47;
        for (Scene* const scene : {&first, &second, &third}) scene->simulation.threads = threads;
        Auralizer auralizer(first, mono());
        const SourceId source = auralizer.add_source({.position = {1, 1, 1}});
        const auto change = [&](std::int64_t time) {
            if (time == 0) auralizer.set_scene(second, 20000);
            if (time == 1) auralizer.set_source(source, at(2, 1, 1.5F), 25000);
            if (time == 2) auralizer.add_source({.position = {3, 1, 1}}, 22000);
            if (time == 3) auralizer.set_scene(third, 30001);
            if (time == 4) auralizer.set_listener(at(2, 2, 1, 1), 31000);
            if (time == 5) auralizer.remove_source(source, 40000);
            if (time == 6) {
                RigidTransform moved;
                moved.translation = {2, 2, 0.5F};
                auralizer.set_transform(third.objects.size() - 1, moved, 45000);
            }
        };
        if (early)
            for (int i = 0; i < 7; ++i) change(i);
        int done = 0;
        return rendered(auralizer, 60000, sizes, noise_at, [&](std::int64_t position) {
            if (!early && done < 7 && position >= 15000) change(done++);
        });
    };
    const auto reference = output(1, {256}, true);
    CHECK(energy(reference, 50000, 60000) > 0);
    CHECK(output(2, {1, 700, 63}, true) == reference);
    CHECK(output(1, {480}, false) == reference);
}

TEST_CASE("A scene that is set before the first sample is heard from the first sample on") {
    Scene wanted = dry_room();
    wanted.sources.clear();
    Auralizer constructed(wanted, mono());
    Auralizer changed(test::room_with_panel(), mono());
    for (Auralizer* const auralizer : {&constructed, &changed})
        auralizer->add_source({.position = {1, 1, 1}});
    changed.set_listener(wanted.listener.pose);
    changed.set_scene(wanted);
    const auto expected = rendered(constructed, 12000, {256}, noise_at);
    CHECK(energy(expected, 0, 12000) > 0);
    CHECK(rendered(changed, 12000, {256}, noise_at) == expected);
}

TEST_CASE("Sources, listeners and gains stay when the scene changes") {
    Auralizer auralizer(dry_room(), mono());
    const SourceId added = auralizer.add_source({.position = {1, 1, 1}});
    const std::vector<SourceId> sources = auralizer.sources();
    auralizer.set_gain(sources[0], -INFINITY);
    auralizer.set_part_gains({.direct = 1, .early = 0, .late = 0});
    auralizer.set_source(added, at(2, 2, 1));
    auralizer.set_listener(at(3, 2, 1));
    auralizer.set_scene(test::free_field({50, 0, 0}), 10000);
    CHECK(auralizer.sources() == sources);
    const auto output = rendered(auralizer, kSecond, {480}, [](std::int64_t) { return 0.5F; });
    CHECK(auralizer.sources() == sources);
    // At a distance of 1 m the amplitude is that of the signal, up to the air and rounding.
    CHECK(static_cast<double>(output.back()) == Approx(0.5).epsilon(0.01));
    CHECK(auralizer.visible(added));
    CHECK(auralizer.impulse_response(added).size() == 1);
    CHECK(auralizer.status().frames == 30);
}

TEST_CASE("The scene before rings out, and the length of the responses is that of the new one") {
    Scene church = dry_room();
    church.materials[0].absorption = Bands::filled(0.02F);
    church.simulation.ir_length_s = 1.5F;
    Auralizer auralizer(church, mono());
    CHECK(auralizer.response_length_s() == Approx(1.5));
    auralizer.set_scene(other_room(), kSecond / 2);
    // A burst, then silence.
    const auto output = rendered(auralizer, kSecond, {256}, [](std::int64_t n) {
        return n < kSecond / 4 ? noise_at(n) : 0.0F;
    });
    CHECK(auralizer.response_length_s() == Approx(0.2));
    CHECK(auralizer.tail_samples() > kSecond);
    Auralizer alone(church, mono());
    const auto reference = rendered(
        alone, kSecond, {256}, [](std::int64_t n) { return n < kSecond / 4 ? noise_at(n) : 0.0F; });
    // The sound of the scene before is what it would be, but that its frames have ended.
    const double rung = energy(output, kSecond * 3 / 5, kSecond);
    CHECK(rung == Approx(energy(reference, kSecond * 3 / 5, kSecond)).epsilon(0.1));
    rendered(auralizer, 2 * kSecond, {256}, [](std::int64_t) { return 0.0F; });
    CHECK(auralizer.tail_samples() < kSecond / 2);
}

TEST_CASE("Objects are those of the scene at the time of the command") {
    Auralizer auralizer(test::room_with_panel(), mono());
    auralizer.add_source({.position = {1, 2, 1}});
    const auto panel = auralizer.scene()->objects.size() - 1;
    auralizer.set_scene(dry_room(), 10000);
    CHECK_NOTHROW(auralizer.set_transform(panel, {}, 9999));
    CHECK_THROWS_AS(auralizer.set_transform(panel, {}, 10000), InputError);
    CHECK_THROWS_AS(auralizer.set_material(panel, "carpet", 20000), InputError);
    // One that the change overtakes.
    auralizer.set_transform(panel, {}, 8000);
    auralizer.set_material(panel, "carpet", 8000);
    auralizer.set_scene(dry_room(), 5000);
    rendered(auralizer, 12000, {256}, noise_at);
    CHECK(auralizer.scene()->objects.size() == panel);
    CHECK_NOTHROW(auralizer.status());
}

TEST_CASE("An object by its name is that of the scene at the time of the command") {
    const auto output = [](bool by_name) {
        Auralizer auralizer(room_with_objects(true), mono());
        auralizer.set_scene(room_with_objects(false), 10000);
        const RigidTransform first = moved_by({0, -1.5F, 0});
        const RigidTransform second = moved_by({0, -1, 0});
        if (by_name) {
            auralizer.set_transform("door", first, 5000);
            auralizer.set_transform("door", second, 15000);
            auralizer.set_material("screen", "curtain", 7000);
            auralizer.set_material("screen", auralizer.scene()->materials[0], 17000);
        } else {
            auralizer.set_transform(1, first, 5000);
            auralizer.set_transform(2, second, 15000);
            auralizer.set_material(2, "curtain", 7000);
            auralizer.set_material(1, auralizer.scene()->materials[0], 17000);
        }
        return rendered(auralizer, 24000, {256}, noise_at);
    };
    CHECK(output(true) == output(false));

    Auralizer auralizer(room_with_objects(true), mono());
    for (const char* const absent : {"window", ""}) {
        CHECK_THROWS_WITH(auralizer.set_transform(absent, {}),
                          "object: there is no \"" + std::string(absent) + "\" in the room");
        CHECK_THROWS_AS(auralizer.set_material(absent, "curtain"), InputError);
        CHECK_THROWS_AS(auralizer.set_material(absent, Material{}), InputError);
    }
    CHECK_THROWS_AS(auralizer.set_material("door", "cheese"), InputError);
    auralizer.set_transform("door", moved_by({0, -1.5F, 0}));
    rendered(auralizer, 4800, {256}, noise_at);
    CHECK(auralizer.visible({1}));
    auralizer.set_transform("screen", moved_by({0, -1.5F, 0}));
    rendered(auralizer, 4800, {256}, noise_at);
    CHECK_FALSE(auralizer.visible({1}));
}

TEST_CASE("An object by its name moves while another thread exchanges the order of objects") {
    Auralizer auralizer(room_with_objects(true), mono(RenderClock::real_time));
    std::atomic<bool> ends = false;
    std::vector<std::thread> movers;
    for (int m = 0; m < 4; ++m)
        movers.emplace_back([&] {
            while (!ends) auralizer.set_transform("door", moved_by({0, -1.5F, 0}));
        });
    for (int i = 0; i < 20; ++i) {
        auralizer.set_scene(room_with_objects(i % 2 != 0));
        const auto frames = auralizer.status().frames;
        REQUIRE(test::eventually([&] { return auralizer.status().frames > frames + 2; }));
        CHECK(auralizer.visible({1}));
    }
    ends = true;
    for (std::thread& mover : movers) mover.join();
}

TEST_CASE("A scene that cannot be built changes nothing") {
    const RenderClock clock = GENERATE(RenderClock::exact, RenderClock::real_time);
    AuralizerOptions options = mono(clock);
    options.max_memory_bytes = 100 << 20;
    Auralizer auralizer(dry_room(), options);
    Scene huge = dry_room();
    huge.simulation.ir_length_s = 20;
    CHECK_THROWS_AS(auralizer.set_scene(huge), InputError);
    Scene wrong = dry_room();
    wrong.simulation.frame_rate_hz = -1;
    CHECK_THROWS_AS(auralizer.set_scene(wrong), InputError);
    CHECK(auralizer.response_length_s() == Approx(0.3));
    REQUIRE(test::eventually([&] {
        rendered(auralizer, 4800, {256}, noise_at);
        return auralizer.status().frames > 3;
    }));
}

TEST_CASE("Paths of a scene are followed in it only") {
    Scene moving = test::room_with_panel();
    moving.objects.back().path = Trajectory{{{0, {}}, {1, at(1, 0, 0)}}};
    AuralizerOptions options = mono();
    options.before_frame = follow_paths(moving);
    Auralizer auralizer(moving, options);
    auralizer.set_scene(dry_room(), 10000);
    auralizer.set_scene(moving, 20000);
    rendered(auralizer, 30000, {256}, noise_at);
    CHECK(auralizer.status().frames > 0);
}

TEST_CASE("In real time the paths of scenes that another thread sets are followed") {
    Scene moving = test::room_with_panel();
    moving.simulation.frame_rate_hz = 200;
    moving.objects.back().path = Trajectory{{{0, {}}, {1, at(1, 0, 0)}}};
    Scene still = dry_room();
    still.simulation.frame_rate_hz = 200;
    AuralizerOptions options = mono(RenderClock::real_time);
    options.before_frame = [follow = follow_paths(moving)](Auralizer& a, double time_s) {
        // Most of the frame, so that scenes come in between.
        follow(a, time_s);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        follow(a, time_s);
    };
    Auralizer auralizer(moving, options);
    for (int i = 0; i < 10; ++i) auralizer.set_scene(i % 2 == 0 ? still : moving);
    const auto frames = auralizer.status().frames;
    CHECK(test::eventually([&] { return auralizer.status().frames > frames + 3; }));
}

TEST_CASE("Scenes change while another thread renders, and in a pause") {
    Auralizer auralizer(dry_room(), mono(RenderClock::real_time));
    std::atomic<bool> ends = false;
    std::thread audio([&] {
        std::vector<float> input(256, 0.1F);
        std::vector<float> output(256);
        const std::vector<float*> outputs{output.data()};
        while (!ends) {
            const SourceSignal signal{{1}, input.data()};
            auralizer.render({&signal, 1}, outputs, 256);
            std::this_thread::sleep_for(std::chrono::microseconds(500));
        }
    });
    for (int i = 0; i < 12; ++i) {
        auralizer.set_scene(i % 2 == 0 ? other_room() : dry_room());
        const SourceId source = auralizer.add_source({.position = {1, 1, 1}});
        auralizer.set_listener(at(2, 1, 1, static_cast<float>(i)));
        auralizer.remove_source(source);
    }
    auralizer.pause();
    REQUIRE(test::eventually([&] { return auralizer.status().paused; }));
    for (int i = 0; i < 3; ++i) auralizer.set_scene(other_room());
    auralizer.resume();
    REQUIRE(test::eventually([&] { return auralizer.response_length_s() < 0.25; }));
    const auto frames = auralizer.status().frames;
    REQUIRE(test::eventually([&] { return auralizer.status().frames > frames + 3; }));
    ends = true;
    audio.join();
    CHECK(auralizer.sources() == std::vector<SourceId>{{1}});
}

}  // namespace scene_exchange_test
