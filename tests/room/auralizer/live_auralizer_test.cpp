#include "apps/room/auralizer/live_auralizer.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>

#include "apps/room/base/latency.h"
#include "tests/support/test_scenes.h"
#include "tests/support/wait.h"

namespace live_auralizer_test {

namespace {

using namespace aula;

AuralizerOptions mono() {
    AuralizerOptions options;
    options.output = OutputFormat::mono;
    return options;
}

/// Renders ten blocks of an alternating signal; the largest sample.
float level(LiveAuralizer& live) {
    std::vector<float> input(256);
    for (std::size_t n = 0; n < input.size(); ++n) input[n] = n % 16 < 8 ? 0.1F : -0.1F;
    std::vector<float> output(256);
    const std::vector<float*> outputs{output.data()};
    const std::vector<SourceSignal> inputs{{live.room().sources()[0], input.data()}};
    float largest = 0;
    for (int block = 0; block < 10; ++block) {
        live.render(inputs, outputs, 256);
        for (const float x : output) largest = std::max(largest, std::abs(x));
    }
    return largest;
}

}  // namespace

TEST_CASE("A live auralizer computes frames between start and stop, and renders after both") {
    Scene scene = test::small_room();
    scene.simulation.rays = 50;
    LiveAuralizer live(scene, mono());
    CHECK(live.room().status().frames == 0);
    CHECK(level(live) == 0);
    const FrameMaker& maker = live.compute_first(2);
    CHECK(live.room().status().frames == 1);
    CHECK(maker.source_positions().size() == 1);
    CHECK(level(live) > 0.001F);

    std::atomic<int> before = 0;
    std::atomic<int> after = 0;
    std::atomic<double> first_s = 0;
    live.start(
        [&](double time_s) {
            if (before++ == 0) first_s = time_s;
        },
        {.played_s = [] { return 2.0; },
         .after_frame =
             [&](const FrameMaker& newest, double) {
                 if (newest.rays() == 50) ++after;
             }});
    REQUIRE(test::eventually([&] { return after > 3; }));
    // The frame after the first one has the present time, so that it is due one period later.
    CHECK(first_s == 2.0);
    live.stop();
    CHECK(before == after);
    const auto frames = live.room().status().frames;
    CHECK(frames == static_cast<std::uint64_t>(1 + after));
    CHECK(level(live) > 0.001F);
    CHECK(live.room().impulse_response(live.room().sources()[0]).empty());
    live.stop();
    CHECK(live.room().status().frames == frames);
}

TEST_CASE("A frame that takes longer than its period is late, also the first one") {
    Scene scene = test::small_room();
    scene.simulation.rays = 20'000;
    const auto late_frames = [&scene](float rate_hz) {
        scene.simulation.frame_rate_hz = rate_hz;
        LiveAuralizer live(scene, mono());
        live.compute_first(0);
        CHECK(live.room().status().frames == 1);
        CHECK(live.room().status().skipped_frames == 0);
        return live.room().status().late_frames;
    };
    // Each frame takes more than 1 ms. Companion: none takes 100 s.
    CHECK(late_frames(Simulation::kMaxFrameRate_hz) == 1);
    CHECK(late_frames(0.01F) == 0);
}

TEST_CASE("The frame after the first one is handed over one period after the start") {
    constexpr double kPeriod_s = 1;
    Scene scene = test::free_field({1, 0, 0});
    scene.simulation.frame_rate_hz = static_cast<float>(1 / kPeriod_s);
    LiveAuralizer live(scene, mono());
    live.compute_first(0);
    const auto start = std::chrono::steady_clock::now();
    const auto played_s = [start] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    live.start([](double) {}, {.played_s = played_s});
    double handed_over_s = 0;
    REQUIRE(test::eventually([&] {
        const double now_s = played_s();
        handed_over_s = now_s - live.room().status().frame_age_s;
        return handed_over_s > 0;
    }));
    // Half a period is far more than the handover takes. A clock whose first frame starts one
    // period after the sound hands over after two.
    CHECK(handed_over_s < 1.5 * kPeriod_s);
}

TEST_CASE("A live auralizer that never starts ends") {
    LiveAuralizer live(test::free_field({1, 0, 0}), mono());
    live.compute_first(0);
    CHECK(level(live) > 0.001F);
}

TEST_CASE("Poses carry the time at which they are set, and those before the start do not count") {
    LiveAuralizer live(test::free_field({1, 0, 0}), mono());
    live.room().set_listener(Pose{});
    live.compute_first(0);
    level(live);
    CHECK(live.frame_pose_ns() == 0);
    CHECK(live.head_pose_ns() == 0);
    std::atomic<int> frames = 0;
    live.start([](double) {}, {.played_s = [] { return 0.0; },
                               .after_frame = [&](const FrameMaker&, double) { ++frames; }});
    REQUIRE(test::eventually([&] { return frames > 1; }));
    level(live);
    CHECK(live.frame_pose_ns() == 0);  // no pose

    const std::int64_t begin_ns = clock_ns();
    Pose pose;
    pose.yaw_rad = 1;
    live.room().set_listener(pose);
    const std::int64_t end_ns = clock_ns();
    level(live);
    CHECK(live.head_pose_ns() >= begin_ns);
    CHECK(live.head_pose_ns() <= end_ns);
    std::int64_t frame_ns = 0;
    REQUIRE(test::eventually([&] {
        level(live);
        frame_ns = std::max(frame_ns, live.frame_pose_ns());
        return frame_ns != 0;
    }));
    CHECK(frame_ns >= begin_ns);
    CHECK(frame_ns <= end_ns);
}

}  // namespace live_auralizer_test
