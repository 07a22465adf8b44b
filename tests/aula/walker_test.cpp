#include "apps/aula/walker.h"

#include <catch2/catch.hpp>

using namespace aula;

TEST_CASE(
    "A held key moves the listener at 1.5 m/s, and the movement stops soon after its release") {
    Walker walker{Pose{}};
    // Two seconds of a key that repeats 30 times a second.
    for (int i = 0; i < 60; ++i) {
        walker.press(Key::forward);
        walker.advance(1.0 / 30);
    }
    // Rounding of 60 additions in single precision.
    REQUIRE(static_cast<double>(walker.advance(0).position.x) == Approx(3).epsilon(1e-5));
    const double stopped = static_cast<double>(walker.advance(10).position.x);
    REQUIRE(stopped > 3);
    REQUIRE(stopped < 3.31);
    REQUIRE(static_cast<double>(walker.advance(10).position.x) == stopped);
}

TEST_CASE("The movement follows the heading, and the key for left moves to the left") {
    Walker walker{Pose{}};
    // 90 degrees a second.
    for (int i = 0; i < 30; ++i) {
        walker.press(Key::turn_left);
        walker.advance(1.0 / 30);
    }
    walker.press(Key::turn_right);  // stops the turn
    walker.press(Key::forward);
    const Pose& ahead = walker.advance(1);
    REQUIRE(static_cast<double>(ahead.yaw_rad) == Approx(1.5707963).epsilon(1e-5));
    REQUIRE(static_cast<double>(ahead.position.y) == Approx(0.3).epsilon(1e-5));
    REQUIRE(static_cast<double>(ahead.position.x) == Approx(0).margin(1e-5));
    walker.press(Key::left);
    REQUIRE(static_cast<double>(walker.advance(1).position.x) == Approx(-0.3).epsilon(1e-4));
}
