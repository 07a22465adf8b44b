#include "apps/window/view/first_person.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "tests/support/test_scenes.h"

using namespace aula;

TEST_CASE("Walking moves along the heading at 1.5 m/s and turns by 90 degrees/s") {
    Pose pose;
    pose = walked(pose, {.ahead = 1}, 2, nullptr);
    CHECK(static_cast<double>(pose.position.x) == Approx(3));
    pose = walked(pose, {.turn_left = 1}, 1, nullptr);
    CHECK(static_cast<double>(pose.yaw_rad) == Approx(1.5707963));
    pose = walked(pose, {.ahead = 1, .left = 1}, 1, nullptr);
    CHECK(static_cast<double>(pose.position.x) == Approx(1.5));
    CHECK(static_cast<double>(pose.position.y) == Approx(1.5));
    CHECK(pose.position.z == 0);
}

TEST_CASE("Walking stops 0.25 m from a wall and slides along it") {
    const RayScene walls(test::small_room());  // 5 x 4 x 3 m
    Pose pose;
    pose.position = {2.5F, 2, 1.6F};
    pose.yaw_rad = 0.5F;
    for (int i = 0; i < 300; ++i) pose = walked(pose, {.ahead = 1}, 1.0 / 30, &walls);
    // Slid into the corner, 0.25 m from both walls. Tolerance: 16 probe directions.
    CHECK(static_cast<double>(pose.position.x) == Approx(4.75).margin(0.02));
    CHECK(static_cast<double>(pose.position.y) == Approx(3.75).margin(0.02));
    CHECK(pose.position.z == 1.6F);

    // Companion: without walls the pose leaves the room.
    Pose free;
    free.position = {2.5F, 2, 1.6F};
    for (int i = 0; i < 300; ++i) free = walked(free, {.ahead = 1}, 1.0 / 30, nullptr);
    CHECK(free.position.x > 10);
}

TEST_CASE("Random walking at any frame rate stays within the walls") {
    const RayScene walls(test::small_room());
    std::mt19937 random(1);
    std::uniform_real_distribution<float> any(-3, 3);
    std::uniform_real_distribution<double> time_s(0.005, 0.5);
    Pose pose;
    pose.position = {1, 1, 1.2F};
    for (int i = 0; i < 2000; ++i) {
        pose = walked(pose, {any(random), any(random), any(random), any(random)}, time_s(random),
                      &walls);
        REQUIRE(pose.position.x > 0);
        REQUIRE(pose.position.x < 5);
        REQUIRE(pose.position.y > 0);
        REQUIRE(pose.position.y < 4);
        REQUIRE(std::abs(pose.pitch_rad) < 1.5F);
    }
}
