#include "apps/room/frames/timeline.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

namespace timeline_test {

namespace {

using namespace aula;

constexpr double kRate_hz = 48000;
constexpr double kResponse_s = 1.5;
/// The response, and the fade of endless signals.
constexpr double kTail_s = kResponse_s + Timeline::kFade_s;

Trajectory walk(double duration_s, bool loop) {
    Trajectory path;
    path.loop = loop;
    path.points = {{0, Pose{}}, {duration_s, Pose{}}};
    return path;
}

Scene scene_with(Source::Signal signal, bool loop) {
    Scene scene;
    scene.sources.resize(1);
    scene.sources[0].signal = signal;
    scene.sources[0].loop = loop;
    return scene;
}

Timeline offline(const Scene& scene, std::optional<double> duration_s = {}) {
    const auto signals = read_signals(scene, kRate_hz);
    return offline_timeline({scene, signals, kRate_hz, kResponse_s, duration_s});
}

Timeline live(const Scene& scene, std::optional<double> duration_s = {}) {
    const auto signals = read_signals(scene, kRate_hz);
    return live_timeline({scene, signals, kRate_hz, kResponse_s, duration_s});
}

}  // namespace

TEST_CASE("A walk with an endless signal ends at the walk's end, then the room rings out") {
    Scene scene = scene_with(Source::Signal::noise, false);
    scene.listener.path = walk(8, false);
    REQUIRE(offline(scene).input_end_s == 8);
    REQUIRE(offline(scene).end_s == Approx(8 + kTail_s));
    REQUIRE(live(scene).end_s == offline(scene).end_s);
}

TEST_CASE("An unlooped signal alone is played to its end and rings out") {
    const Scene scene = scene_with(Source::Signal::impulse, false);
    REQUIRE(offline(scene).end_s == Approx(1 / kRate_hz + kTail_s));
    REQUIRE(live(scene).end_s == offline(scene).end_s);
}

TEST_CASE("With loops only, one cycle is rendered, and playback is endless") {
    Scene scene = scene_with(Source::Signal::impulse, true);
    REQUIRE(offline(scene).end_s == 1);
    scene.listener.path = walk(6, true);
    REQUIRE(offline(scene).end_s == 6);
    REQUIRE(std::isinf(live(scene).end_s));
}

TEST_CASE("Without anything finite 10 s are rendered") {
    const Scene scene = scene_with(Source::Signal::noise, true);
    REQUIRE(offline(scene).end_s == 10);
    REQUIRE(std::isinf(live(scene).end_s));
}

TEST_CASE("A given duration is exact") {
    Scene scene = scene_with(Source::Signal::noise, false);
    scene.listener.path = walk(8, false);
    REQUIRE(offline(scene, 2.5).end_s == 2.5);
    REQUIRE(live(scene, 2.5).end_s == 2.5);
    REQUIRE(std::isinf(offline(scene, 2.5).input_end_s));
}

TEST_CASE("The tail lasts until sound from far away has arrived") {
    Scene scene = scene_with(Source::Signal::impulse, false);
    scene.sources[0].position = {3432, 0, 0};
    // 10 s at 343.2 m/s, and slightly more.
    REQUIRE(offline(scene).end_s > 10);
    REQUIRE(offline(scene).end_s < 10.2);
}

TEST_CASE("Endless signals are faded out after the end of the input, not before") {
    const Timeline timeline{.input_end_s = 1, .end_s = 2};
    std::vector<float> block(static_cast<std::size_t>(kRate_hz), 1.0F);
    timeline.fade(static_cast<std::int64_t>(kRate_hz / 2), kRate_hz, block);
    const auto at = [&](double time_s) {
        return block[static_cast<std::size_t>((time_s - 0.5) * kRate_hz)];
    };
    REQUIRE(at(0.5) == 1);
    REQUIRE(at(1.0) == 1);
    REQUIRE(at(1 + Timeline::kFade_s / 2) == Approx(0.5).margin(1e-3));  // one sample's step
    REQUIRE(at(1 + Timeline::kFade_s + 1e-4) == 0);
}

TEST_CASE("The output is silent from the end on and unchanged until shortly before") {
    const Timeline timeline{.end_s = 1};
    std::vector<float> block(static_cast<std::size_t>(kRate_hz), 1.0F);
    timeline.end(static_cast<std::int64_t>(kRate_hz / 2), kRate_hz, block);
    const auto at = [&](double time_s) {
        return block[static_cast<std::size_t>(std::lround((time_s - 0.5) * kRate_hz))];
    };
    REQUIRE(at(1 - Timeline::kFade_s) == 1);
    REQUIRE(at(1 - Timeline::kFade_s / 2) == Approx(0.5).margin(1e-3));  // one sample's step
    REQUIRE(at(1) == 0);
    REQUIRE(block.back() == 0);
}

TEST_CASE("The longest path of listener, sources and objects counts") {
    const std::array<double, 3> durations_s{2, 5, 8};
    for (int turn = 0; turn < 3; ++turn) {
        const auto duration_s = [&](int k) {
            return durations_s[static_cast<std::size_t>((turn + k) % 3)];
        };
        for (const bool loop : {false, true}) {
            Scene scene = scene_with(Source::Signal::noise, true);
            scene.sources.resize(2, scene.sources[0]);
            scene.objects.resize(2);
            scene.listener.path = walk(duration_s(0), loop);
            scene.sources[0].path = walk(duration_s(1), loop);
            scene.objects[0].path = walk(duration_s(2), loop);
            CAPTURE(turn, loop);
            REQUIRE(offline(scene).end_s == Approx(loop ? 8 : 8 + kTail_s));
            REQUIRE(live(scene).end_s == (loop ? Timeline{}.end_s : offline(scene).end_s));
            // The first and the last of sources and objects count as well.
            std::swap(scene.sources[0].path, scene.sources[1].path);
            std::swap(scene.objects[0].path, scene.objects[1].path);
            REQUIRE(offline(scene).end_s == Approx(loop ? 8 : 8 + kTail_s));
        }
    }
}

TEST_CASE("A walk and a signal play at the same time, and the longer one is the duration") {
    Scene scene;
    scene.sources.resize(3);
    const auto signal = [](double duration_s, bool loop) {
        return std::make_shared<const Signal>(
            std::vector<float>(static_cast<std::size_t>(duration_s * kRate_hz), 0.1F), loop);
    };
    const auto ends = [&](const SignalSet& signals, bool plays) {
        const TimelineInput input{scene, signals, kRate_hz, kResponse_s, {}};
        return (plays ? live_timeline(input) : offline_timeline(input)).end_s;
    };
    for (const bool plays : {false, true}) {
        CAPTURE(plays);
        const SignalSet finite{signal(0.5, false), signal(1.25, false), signal(0.25, false)};
        scene.listener.path.reset();
        REQUIRE(ends(finite, plays) == Approx(1.25 + kTail_s));
        scene.listener.path = walk(3, false);
        REQUIRE(ends(finite, plays) == Approx(3 + kTail_s));
        scene.listener.path = walk(0.75, false);
        REQUIRE(ends(finite, plays) == Approx(1.25 + kTail_s));
        // An endless signal is faded out at the end of the walk.
        REQUIRE(ends({signal(0.5, true), signal(0.25, false)}, plays) == Approx(0.75 + kTail_s));
    }
    // With loops only, one cycle is that of the longest loop.
    scene.listener.path = walk(0.5, true);
    REQUIRE(ends({signal(0.25, true), signal(0.75, true), signal(0.5, true)}, false) == 0.75);
    scene.listener.path = walk(2, true);
    REQUIRE(ends({signal(0.25, true), signal(0.75, true)}, false) == 2);
}

TEST_CASE("The tail lasts until sound from the final positions has arrived") {
    constexpr float kFar_m = 3432;  // 10 s
    Pose far;
    far.position.x = kFar_m;
    for (const bool listener_walks : {false, true}) {
        for (const bool away : {false, true}) {
            Scene scene = scene_with(Source::Signal::noise, false);
            Trajectory path;
            path.points = {{0, away ? Pose{} : far}, {8, away ? far : Pose{}}};
            // At a small distance all the time.
            scene.sources.resize(3, scene.sources[0]);
            (listener_walks ? scene.listener.path : scene.sources[1].path) = path;
            CAPTURE(listener_walks, away);
            // A twentieth of a second for the filters, and a fade.
            const double wait_s = away ? 10.05 + Timeline::kFade_s : kTail_s;
            REQUIRE(offline(scene).end_s == Approx(8 + wait_s).margin(1e-3));
        }
    }
}

}  // namespace timeline_test
