#include "apps/session/timeline.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace {

using namespace aula;

constexpr double kRate_hz = 48000;
constexpr double kResponse_s = 1.5;
/// The response and the fade of what would go on.
constexpr double kTail_s = kResponse_s + Timeline::kFade_s;

Path walk(double duration_s, bool loop) {
    Path path;
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

TEST_CASE("With loops alone one round is rendered, and playing has no end") {
    Scene scene = scene_with(Source::Signal::impulse, true);
    REQUIRE(offline(scene).end_s == 1);
    scene.listener.path = walk(6, true);
    REQUIRE(offline(scene).end_s == 6);
    REQUIRE(std::isinf(live(scene).end_s));
}

TEST_CASE("Where nothing is finite 10 s are rendered") {
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
    // 10 s at 343.2 m/s, and not much more.
    REQUIRE(offline(scene).end_s > 10);
    REQUIRE(offline(scene).end_s < 10.2);
}

TEST_CASE("Signals that go on are faded out after the end of the input, not before") {
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

TEST_CASE("What is heard is silent from the end on, and as it is until shortly before") {
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
