#include "apps/room/frames/live_load.h"

#include <catch2/catch.hpp>
#include <random>

using namespace aula;

namespace {

constexpr double kPeriod_s = 1.0 / 30;
constexpr LiveLoad::Full kFull{
    .rays = 1000, .length_s = 3, .rays_fall = true, .length_falls = true};

/// A machine whose frames take a fixed time and a time per ray, for each second of response.
struct Machine {
    double second_s;
    double ray_second_s;

    double frame_s(const LiveLoad& load) const {
        return load.length_s() * (second_s + ray_second_s * load.rays());
    }
};

/// Plays for a while. Returns the number of changes of rays or length.
int play(LiveLoad& load, const Machine& machine, double seconds, double jitter = 0) {
    std::mt19937 random(1);
    std::lognormal_distribution<double> factor(0, jitter);
    int changes = 0;
    for (double s = 0; s < seconds;) {
        const int rays = load.rays();
        const double length_s = load.length_s();
        const double took_s = machine.frame_s(load) * (jitter > 0 ? factor(random) : 1);
        load.add(took_s, kPeriod_s);
        changes += load.rays() != rays || load.length_s() != length_s ? 1 : 0;
        s += std::max(took_s, kPeriod_s);
    }
    return changes;
}

}  // namespace

TEST_CASE("If frames are fast enough, rays and response length are not reduced") {
    LiveLoad load(kFull);
    CHECK(play(load, {0.001, 4e-6}, 60) == 0);
    CHECK(load.rays() == 1000);
    CHECK(load.length_s() == 3);
}

TEST_CASE("If frames are too slow for all rays, rays are reduced before the response length") {
    LiveLoad load(kFull);
    const Machine machine{0.002, 1.6e-5};  // 54 ms with all
    play(load, machine, 10);
    CHECK(machine.frame_s(load) < 0.9 * kPeriod_s);
    CHECK(load.rays() > 300);
    CHECK(load.length_s() == 3);
}

TEST_CASE("On a slow machine the response is shortened within some seconds and then constant") {
    for (const double slower : {3.0, 10.0, 20.0}) {
        INFO(slower);
        LiveLoad load(kFull);
        const Machine machine{0.002 * slower, 1.6e-5 * slower};
        play(load, machine, 30);
        CHECK(machine.frame_s(load) < 0.9 * kPeriod_s);
        CHECK(load.length_s() < 3);
        CHECK(load.length_s() >= 0.3);
        CHECK(load.rays() >= 100);
        // Rays increase in trials that become less and less frequent.
        play(load, machine, 300);
        CHECK(play(load, machine, 300) <= 6);
        CHECK(machine.frame_s(load) < 0.9 * kPeriod_s);
    }
}

TEST_CASE("Frames of several seconds are reduced in proportion to the first ones") {
    LiveLoad load(kFull);
    load.add(5, kPeriod_s);
    CHECK(load.rays() == 300);
    load.add(2, kPeriod_s);
    CHECK(load.length_s() == 1);
    load.add(1, kPeriod_s);
    CHECK(load.rays() == 100);
    load.add(0.5, kPeriod_s);
    CHECK(load.length_s() == 1);
    load.add(0.5, kPeriod_s);
    CHECK(load.length_s() == 0.3);
}

TEST_CASE("Given values are not reduced on any machine") {
    const Machine machine{0.05, 1e-4};
    LiveLoad::Full full = kFull;
    full.rays_fall = false;
    LiveLoad length(full);
    play(length, machine, 60);
    CHECK(length.rays() == 1000);
    CHECK(length.length_s() == 0.3);
    full = kFull;
    full.length_falls = false;
    LiveLoad rays(full);
    play(rays, machine, 60);
    CHECK(rays.rays() == 100);
    CHECK(rays.length_s() == 3);
    // Chosen by the user during playback.
    LiveLoad by_hand(kFull);
    for (int frame = 0; frame < 1000; ++frame) by_hand.add(0.1, kPeriod_s, false);
    CHECK(by_hand.rays() == 1000);
    CHECK(by_hand.length_s() == 0.3);
    full.rays_fall = false;
    LiveLoad none(full);
    CHECK(play(none, machine, 60) == 0);
}

TEST_CASE("Occasional delays of frames change nothing") {
    LiveLoad load(kFull);
    std::mt19937 random(1);
    for (int frame = 0; frame < 10'000; ++frame)
        load.add(random() % 20 == 0 ? 0.2 : 0.02, kPeriod_s);
    CHECK(load.rays() == 1000);
    CHECK(load.length_s() == 3);
}

TEST_CASE("Rays increase again when frames are fast, and do not oscillate otherwise") {
    LiveLoad load(kFull);
    play(load, {0.002, 1.6e-5}, 10);
    const int fewer = load.rays();
    REQUIRE(fewer < 1000);
    play(load, {0.001, 4e-6}, 60);
    CHECK(load.rays() == 1000);
    // A cost that jumps across the range without changes: each trial doubles the wait.
    LiveLoad other(kFull);
    int changes = 0;
    for (double s = 0; s < 600;) {
        const int rays = other.rays();
        const double took_s = other.rays() > 500 ? 0.05 : 0.01;
        other.add(took_s, kPeriod_s);
        changes += other.rays() != rays ? 1 : 0;
        s += std::max(took_s, kPeriod_s);
    }
    CHECK(changes < 40);  // about 150 without longer waits
}

TEST_CASE(
    "A response that began short grows to its full length while there is room, then rays do") {
    LiveLoad load({.rays = 1000, .length_s = 9, .rays_fall = true, .length_falls = true}, 300, 4);
    const Machine fast{0.0002, 1e-6};
    play(load, fast, 3.5);
    CHECK(load.length_s() == 6);
    CHECK(load.rays() == 300);
    play(load, fast, 3.2);
    CHECK(load.length_s() == 9);
    CHECK(load.rays() == 300);
    play(load, fast, 60);
    CHECK(load.rays() == 1000);
    // Companion: no room.
    LiveLoad busy({.rays = 1000, .length_s = 9, .rays_fall = true, .length_falls = true}, 300, 4);
    CHECK(play(busy, {0.001, 1.4e-5}, 60) == 0);
}

TEST_CASE("A length that was too much is tried again after longer and longer times") {
    // Frames of 6 s are too long; each change is prepared and begins with the waits so far.
    LiveLoad load({.rays = 1000, .length_s = 9, .rays_fall = false, .length_falls = true}, 1000, 4);
    int trials = 0;
    for (double s = 0; s < 600;) {
        const double length_s = load.length_s();
        const double took_s = length_s > 5 ? 0.05 : 0.01;
        load.add(took_s, kPeriod_s);
        if (load.length_s() > length_s) ++trials;
        if (load.length_s() != length_s)
            load.change(load.full(), load.rays(), load.length_s() > length_s ? 6 : 4);
        s += std::max(took_s, kPeriod_s);
    }
    CHECK(trials > 0);
    CHECK(trials < 12);  // about 150 without longer waits
}
