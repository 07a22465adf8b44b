#include "apps/room/frames/sound_at_listener.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace {

using namespace aula;

constexpr float kPi = std::numbers::pi_v<float>;
/// Sines and cosines of single precision, a few operations deep.
constexpr double kRounding = 1e-6;

Pose looking(float yaw_rad) {
    Pose pose;
    pose.yaw_rad = yaw_rad;
    return pose;
}

std::array<float, 3> in_head(const HeadRotation& head, const Vec3& world) {
    std::array<float, 3> v{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        v[axis] = head[axis][0] * world.x + head[axis][1] * world.y + head[axis][2] * world.z;
    return v;
}

}  // namespace

TEST_CASE("A path of fluence 1/(4 pi d^2) has the pressure 1/d, and order 0 is the direct sound") {
    ImpulseResponse response;
    response.channels.assign(4, std::vector<float>(8));
    SoundPath direct;
    direct.is_main = true;
    direct.length_m = 5;
    direct.direction = {0, 1, 0};
    direct.energy = Bands::filled(1 / (4 * kPi * 25));
    SoundPath wall = direct;
    wall.kind = SoundPath::Kind::image;
    wall.order = 1;
    wall.key = 7;
    wall.is_main = false;
    wall.length_m = 10;
    response.paths = {direct, wall};
    const SourceSound sound = source_sound(response, 343.2, 20);
    REQUIRE(sound.direct);
    REQUIRE(sound.direct->delay_s == Approx(5 / 343.2));
    REQUIRE(sound.direct->direction == std::array<float, 3>{0, 1, 0});
    for (const float gain : sound.direct->band_gain)
        REQUIRE(static_cast<double>(gain) == Approx(0.2).epsilon(kRounding));
    REQUIRE(sound.early.size() == 1);
    REQUIRE(sound.early[0].delay_s == Approx(10 / 343.2));
    REQUIRE(static_cast<double>(sound.gain) == Approx(10));
    REQUIRE(sound.ambisonics[0].size() == 8);
}

TEST_CASE(
    "All paths of order 0 have the gain of the direct sound, whose main path is rendered as such") {
    ImpulseResponse response;
    response.channels.assign(4, std::vector<float>(8));
    SoundPath bent;
    bent.kind = SoundPath::Kind::bent;
    bent.edges = 1;
    bent.key = 7;
    bent.length_m = 4.5F;  // weak paths may be shorter than the main one
    bent.energy = Bands::filled(1 / (4 * kPi));
    SoundPath main = bent;
    main.key = 9;
    main.is_main = true;
    main.length_m = 5;
    SoundPath wall = main;
    wall.is_main = false;
    wall.kind = SoundPath::Kind::image;
    wall.order = 1;
    wall.key = 8;
    wall.edges = 0;
    response.paths = {bent, main, wall};
    const SourceSound sound = source_sound(response, 343.2, 0, 0.5F, 0.25F);
    REQUIRE(sound.direct);
    CHECK(sound.direct->delay_s == Approx(5 / 343.2));
    CHECK(static_cast<double>(sound.direct->band_gain[0]) == Approx(0.5).epsilon(kRounding));
    REQUIRE(sound.early.size() == 2);
    CHECK(sound.early[0].id == 7);
    CHECK(static_cast<double>(sound.early[0].band_gain[0]) == Approx(0.5).epsilon(kRounding));
    CHECK(sound.early[1].id == 8);
    CHECK(static_cast<double>(sound.early[1].band_gain[0]) == Approx(0.25).epsilon(kRounding));
}

TEST_CASE("Sound from the left of the room is in front of a head that is turned left") {
    const auto front = in_head(head_rotation(looking(kPi / 2)), {0, 1, 0});
    REQUIRE(static_cast<double>(front[0]) == Approx(1).margin(kRounding));
    REQUIRE(static_cast<double>(front[1]) == Approx(0).margin(kRounding));
}

TEST_CASE("A head turns at constant speed between two poses, by the smaller angle") {
    HeadMotion motion(1600);
    motion.turn_to(looking(kPi - 0.1F));
    const auto first_pose = motion.advance(1600);
    REQUIRE(first_pose == head_rotation(looking(kPi - 0.1F)));
    motion.turn_to(looking(-kPi + 0.1F));
    motion.advance(400);
    const auto half_way = motion.advance(400);
    const auto expected = head_rotation(looking(kPi));
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            REQUIRE(static_cast<double>(half_way[row][column]) ==
                    Approx(static_cast<double>(expected[row][column])).margin(10 * kRounding));
    motion.advance(800);
    REQUIRE(static_cast<double>(in_head(motion.advance(1), {-1, 0, 0})[1]) ==
            Approx(-std::sin(0.1)).margin(10 * kRounding));
}

TEST_CASE("Poses that arrive more often than frames are all followed") {
    HeadMotion motion(1600);
    motion.turn_to(looking(0));
    motion.advance(400);
    motion.turn_to(looking(1));
    motion.advance(200);
    const auto half_way = motion.advance(1);
    REQUIRE(static_cast<double>(in_head(half_way, {1, 0, 0})[1]) ==
            Approx(-std::sin(0.5 + 1.0 / 400)).margin(10 * kRounding));
    // Complete after the 400 samples between the two poses, not after a frame.
    REQUIRE(motion.advance(199) == head_rotation(looking(1)));
}
