#include "apps/room/frames/source_trajectory.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>

namespace source_trajectory_test {

namespace {

using namespace aula;

constexpr double kSound_m_s = 343.2;
constexpr double kFrame_s = 1.0 / 30;

/// The path from a source straight to the origin.
SoundPath straight(const Vec3& source) {
    SoundPath path;
    path.length_m = glm::length(source);
    path.departure = -source / path.length_m;
    return path;
}

/// The delay d to the origin from a position x + v t at the time of emission, t = -d.
double retarded_s(const glm::dvec3& x, const glm::dvec3& v) {
    // |x - v d|^2 = (c d)^2.
    const double a = kSound_m_s * kSound_m_s - glm::dot(v, v);
    const double b = glm::dot(x, v);
    return (-b + std::sqrt(b * b + a * glm::dot(x, x))) / a;
}

}  // namespace

TEST_CASE("The delay of a moving source is that from where it was at the time of emission") {
    for (const float speed_m_s : {1.5F, 30.0F, 50.0F, 150.0F}) {
        SourceTrajectory trajectory(3);
        double worst_s = 0;
        double worst_static_s = 0;
        for (int frame = 0; frame < 120; ++frame) {
            const double time_s = frame * kFrame_s;
            // Passes the origin at 3 m.
            const Vec3 position{speed_m_s * static_cast<float>(time_s - 2), 3, 0};
            trajectory.add(time_s, position, kSound_m_s);
            // After the sound of the first frame has arrived.
            if (time_s < 1.9) continue;
            const SoundPath path = straight(position);
            const double exact_s = retarded_s(position, {speed_m_s, 0, 0});
            worst_s = std::max(worst_s, std::abs(trajectory.delay_s(path, kSound_m_s) - exact_s));
            worst_static_s =
                std::max(worst_static_s, std::abs(double{path.length_m} / kSound_m_s - exact_s));
        }
        CAPTURE(speed_m_s, worst_s);
        // Rounding of single precision at 150 m, in the position and the direction.
        CHECK(worst_s < 1e-7);
        // Companion: the present distance is off by the part v / c of the delay.
        CHECK(worst_static_s > 1e-6);
    }
}

TEST_CASE("A source that stands has the delay of its distance, to the bit") {
    const Vec3 position{4.1F, -3.3F, 1.7F};
    const SoundPath path = straight(position);
    const double expected_s = double{path.length_m} / kSound_m_s;
    SourceTrajectory trajectory(3);
    for (int frame = 0; frame < 100; ++frame) {
        trajectory.add(frame * kFrame_s, position, kSound_m_s);
        REQUIRE(trajectory.delay_s(path, kSound_m_s) == expected_s);
    }
    // A moving listener changes paths, but not the source.
    const SoundPath other = straight({10, 0, 0});
    CHECK(trajectory.delay_s(other, kSound_m_s) == double{other.length_m} / kSound_m_s);
}

TEST_CASE("A jump, and time that goes back, begin a new trajectory") {
    SourceTrajectory trajectory(3);
    trajectory.add(0, {100, 0, 0}, kSound_m_s);
    trajectory.add(kFrame_s, {0, 10, 0}, kSound_m_s);
    const SoundPath path = straight({0, 10, 0});
    CHECK(trajectory.delay_s(path, kSound_m_s) == double{path.length_m} / kSound_m_s);
    trajectory.add(2 * kFrame_s, {0, 11, 0}, kSound_m_s);
    // Companion: without a jump the delay is another.
    CHECK(trajectory.delay_s(straight({0, 11, 0}), kSound_m_s) != 11 / kSound_m_s);
    trajectory.add(kFrame_s, {0, 11, 0}, kSound_m_s);
    CHECK(trajectory.delay_s(straight({0, 11, 0}), kSound_m_s) == 11 / kSound_m_s);
}

TEST_CASE("A reflection has the delay of the image of the source at the time of emission") {
    // A wall at x = 10 reflects to the listener at the origin: the image of the listener is at 20.
    SourceTrajectory trajectory(3);
    const glm::dvec3 velocity{0, 40, 0};
    SoundPath path;
    path.order = 1;
    for (int frame = 0; frame < 60; ++frame) {
        const glm::dvec3 position = glm::dvec3{5, -20, 0} + velocity * (frame * kFrame_s);
        trajectory.add(frame * kFrame_s, Vec3(position), kSound_m_s);
        const glm::dvec3 to_image = glm::dvec3{20, 0, 0} - position;
        path.length_m = static_cast<float>(glm::length(to_image));
        path.departure = Vec3(glm::normalize(to_image));
        if (frame < 10) continue;
        CHECK(trajectory.delay_s(path, kSound_m_s) ==
              Approx(retarded_s(-to_image, velocity)).margin(1e-7));
    }
}

}  // namespace source_trajectory_test
