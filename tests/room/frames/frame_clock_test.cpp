#include "apps/room/frames/frame_clock.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

using namespace aula;

namespace {

constexpr double kFrame_s = 1.0 / 30;

/// Simulated time, and the frames that are computed in it.
struct Run {
    FrameClock::Clock::time_point start{};
    double now_s = 0;
    FrameClock clock{start};
    int frames = 0;
    std::uint64_t missed = 0;

    FrameClock::Clock::time_point now() const {
        return start + std::chrono::duration_cast<FrameClock::Clock::duration>(
                           std::chrono::duration<double>(now_s));
    }
    void wait_until(FrameClock::Clock::time_point time) {
        now_s = std::max(now_s, std::chrono::duration<double>(time - start).count());
    }

    /// Frames that take `cost_s` until a time; `played` gives the duration of the sound played
    /// until a time.
    void until(double end_s, double cost_s, const std::function<double(double)>& played) {
        while (now_s < end_s) {
            clock.next(kFrame_s);
            wait_until(clock.due());
            missed += clock.skip_missed(now());
            wait_until(clock.begin());
            now_s += cost_s;
            clock.took(cost_s);
            clock.follow(played(now_s), now());
            ++frames;
        }
    }
};

}  // namespace

TEST_CASE("frames follow the playback time of a device with a different clock") {
    Run run;
    // A thousandth fast, in blocks of 256 samples.
    const auto played = [](double now_s) {
        return std::floor(1.001 * now_s * 48000 / 256) * 256 / 48000;
    };
    run.until(60, 0.005, played);
    // Behind by the drift of 50 frames, 1.7 ms, and by half a block, 2.7 ms.
    CHECK(std::abs(run.clock.time_s() - 1.001 * run.now_s) < kFrame_s + 0.006);
    CHECK(run.frames == Approx(60 * 1.001 / kFrame_s).margin(2));
    CHECK(run.missed == 0);
    // Companion: a clock that does not follow the playback is 60 ms behind.
    Run uncorrected;
    uncorrected.until(60, 0.005, [](double now_s) { return now_s; });
    CHECK(std::abs(uncorrected.clock.time_s() - 1.001 * uncorrected.now_s) > kFrame_s + 0.006);
}

TEST_CASE("a frame starts as late as allows it to end two milliseconds before its deadline") {
    Run run;
    run.until(2, 0.020, [](double now_s) { return now_s; });
    const auto spare = std::chrono::duration<double>(run.clock.end() - run.clock.begin()).count();
    CHECK(spare == Approx(0.022).margin(1e-6));
    // A frame that took long is remembered for a second.
    run.clock.took(0.030);
    for (int i = 0; i < 29; ++i) run.clock.took(0.010);
    CHECK(std::chrono::duration<double>(run.clock.end() - run.clock.begin()).count() ==
          Approx(0.032).margin(1e-6));
    run.clock.took(0.010);
    CHECK(std::chrono::duration<double>(run.clock.end() - run.clock.begin()).count() ==
          Approx(0.012).margin(1e-6));
}

TEST_CASE("frames that take too long skip others and keep up with the playback time") {
    Run run;
    run.until(10, 2.5 * kFrame_s, [](double now_s) { return now_s; });
    CHECK(run.missed > 100);
    CHECK(std::abs(run.clock.time_s() - run.now_s) < 3 * kFrame_s);
}

TEST_CASE("while a device is lost the frame time waits, and continues with the playback") {
    constexpr double kGone_s = 10;
    constexpr double kBack_s = 40;
    const auto played = [](double now_s) {
        return now_s < kGone_s ? now_s : now_s < kBack_s ? kGone_s : now_s - (kBack_s - kGone_s);
    };
    Run run;
    run.until(kBack_s, 0.005, played);
    CHECK(std::abs(run.clock.time_s() - kGone_s) < 0.6);
    const int before = run.frames;
    run.until(kBack_s + 5, 0.005, played);
    CHECK(run.frames - before >= 145);
    CHECK(std::abs(run.clock.time_s() - played(run.now_s)) < 2 * kFrame_s + 0.02);
}

TEST_CASE("A frame keeps its time in the sound when the sound stops") {
    Run run;
    run.until(2, 0.005, [](double now_s) { return now_s; });
    const double time_s = run.clock.time_s();
    const double played_s = run.now_s;
    run.now_s += 7;
    run.clock.resume(played_s, run.now());
    CHECK(run.clock.time_s() == time_s);
    CHECK(std::chrono::duration<double>(run.clock.due() - run.now()).count() ==
          Approx(time_s - played_s).margin(1e-6));
    run.until(run.now_s + 1, 0.005, [](double now_s) { return now_s - 7; });
    CHECK(run.missed == 0);
    CHECK(run.clock.time_s() == Approx(run.now_s - 7).margin(kFrame_s));
}
