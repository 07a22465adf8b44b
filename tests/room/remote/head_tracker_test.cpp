#include "apps/room/remote/head_tracker.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "aula/auralizer.h"
#include "tests/support/test_scenes.h"

namespace head_tracker_test {

using namespace aula;
using namespace aula::test;

namespace {

constexpr double kPi = std::numbers::pi;

OscMessage message(const std::string& address, const std::vector<double>& numbers) {
    OscMessage made{.address = address, .arguments = {}, .sender = {}};
    for (const double number : numbers) made.arguments.emplace_back(number);
    return made;
}

glm::mat3 rotation(const OscMessage& message, bool inverted = false) {
    const Vec3 angles_rad = head_angles_rad(message, inverted).value();
    return Pose{.yaw_rad = angles_rad.x, .pitch_rad = angles_rad.y, .roll_rad = angles_rad.z}
        .rotation();
}

/// Rounding of sines and cosines in single precision.
void check_near(const Vec3& a, const Vec3& b) {
    for (int axis = 0; axis < 3; ++axis) CHECK(a[axis] == Approx(b[axis]).margin(2e-6));
}

/// Energies of the left and right ear for a source in front of a head that turns first.
std::pair<double, double> ears(const Vec3& angles_rad) {
    AuralizerOptions options;
    options.clock = RenderClock::exact;
    Auralizer auralizer(free_field({2, 0, 0}), options);
    auralizer.set_listener({.position = {},
                            .yaw_rad = angles_rad.x,
                            .pitch_rad = angles_rad.y,
                            .roll_rad = angles_rad.z});
    std::vector<float> input(4096), left(4096), right(4096);
    input[0] = 1;
    const SourceSignal signal{auralizer.sources()[0], input.data()};
    const std::array<float*, 2> outputs{left.data(), right.data()};
    auralizer.render({&signal, 1}, outputs, 4096);
    const auto energy = [](const std::vector<float>& samples) {
        double sum = 0;
        for (const float x : samples) sum += static_cast<double>(x) * static_cast<double>(x);
        return sum;
    };
    return {energy(left), energy(right)};
}

const double kHalf = std::sqrt(0.5);

/// A head that turns to the left by 90 degrees, in each dialect.
const std::vector<OscMessage> kLeft{message("/SceneRotator/quaternions", {kHalf, 0, 0, kHalf}),
                                    message("/SceneRotator/ypr", {90, 0, 0}),
                                    message("/ypr", {90, 0, 0})};

}  // namespace

TEST_CASE("A head that turns to the left hears a source in front at the right ear") {
    for (const OscMessage& turned : kLeft) {
        INFO(turned.address);
        const auto [left, right] = ears(head_angles_rad(turned, false).value());
        CHECK(right > 2 * left);
        // A tracker that sends the rotation of the scene.
        const auto [inverted_left, inverted_right] = ears(head_angles_rad(turned, true).value());
        CHECK(inverted_left > 2 * inverted_right);
    }
}

TEST_CASE("Rotations of head trackers are positive by the right-hand rule") {
    for (const OscMessage& turned : kLeft) {
        check_near(rotation(turned)[0], {0, 1, 0});
        check_near(rotation(turned, true)[0], {0, -1, 0});
    }
    // About the axis to the left: the nose goes down. About the axis to the front: to the right.
    check_near(rotation(message("/ypr", {0, 30, 0}))[0], {std::sqrt(0.75F), 0, -0.5F});
    check_near(rotation(message("/SceneRotator/quaternions",
                                {std::cos(kPi / 12), 0, std::sin(kPi / 12), 0}))[0],
               {std::sqrt(0.75F), 0, -0.5F});
    check_near(rotation(message("/ypr", {0, 0, 30}))[1], {0, std::sqrt(0.75F), 0.5F});
    check_near(rotation(message("/SceneRotator/quaternions",
                                {std::cos(kPi / 12), std::sin(kPi / 12), 0, 0}))[1],
               {0, std::sqrt(0.75F), 0.5F});
}

TEST_CASE("Quaternions and angles agree, and the inverse is that of the rotation") {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> angle(-kPi, kPi);
    for (int i = 0; i < 100; ++i) {
        const double yaw = angle(random), pitch = angle(random) / 2.01, roll = angle(random);
        // The product of the quaternions of yaw, pitch and roll.
        const double cy = std::cos(yaw / 2), sy = std::sin(yaw / 2);
        const double cp = std::cos(pitch / 2), sp = std::sin(pitch / 2);
        const double cr = std::cos(roll / 2), sr = std::sin(roll / 2);
        const double length = 1 + i % 3;  // any
        const OscMessage quaternion = message(
            "/SceneRotator/quaternions",
            {length * (cy * cp * cr + sy * sp * sr), length * (cy * cp * sr - sy * sp * cr),
             length * (cy * sp * cr + sy * cp * sr), length * (sy * cp * cr - cy * sp * sr)});
        const OscMessage angles =
            message("/SceneRotator/ypr", {180 / kPi * yaw, 180 / kPi * pitch, 180 / kPi * roll});
        const glm::mat3 product = rotation(angles) * rotation(angles, true);
        for (int c = 0; c < 3; ++c) {
            // Near the vertical an angle has the square root of the rounding.
            for (int r = 0; r < 3; ++r) {
                CHECK(rotation(quaternion)[c][r] == Approx(rotation(angles)[c][r]).margin(1e-4));
                CHECK(product[c][r] == Approx(c == r ? 1 : 0).margin(1e-4));
            }
        }
    }
}

TEST_CASE("A head that looks straight up or down has finite angles") {
    for (const double pitch_deg : {90.0, -90.0}) {
        const glm::mat3 looking = rotation(message("/ypr", {20, pitch_deg, 0}));
        check_near(looking[0], {0, 0, pitch_deg > 0 ? -1 : 1});
        const double yaw = 20 * kPi / 180;
        check_near(looking[1], Vec3(-std::sin(yaw), std::cos(yaw), 0));
    }
}

TEST_CASE("Other messages are no head tracker's") {
    for (const OscMessage& other :
         {message("/SceneRotator/quaternions", {1, 0, 0}),
          message("/SceneRotator/quaternions", {0, 0, 0, 0}),
          message("/SceneRotator/quaternions", {NAN, 0, 0, 1}),
          message("/SceneRotator/ypr", {1, 2}), message("/ypr", {INFINITY, 0, 0}),
          message("/SceneRotator/yaw", {1}), message("/ypr/x", {1, 2, 3})}) {
        INFO(other.address);
        CHECK_FALSE(head_angles_rad(other, false));
    }
}

}  // namespace head_tracker_test
