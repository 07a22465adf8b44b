#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "apps/dataset/base/sha256.h"
#include "apps/dataset/base/tar.h"
#include "apps/dataset/base/wav_bytes.h"
#include "apps/dataset/plan/distribution.h"
#include "apps/dataset/plan/room_space.h"
#include "apps/dataset/shards/status.h"
#include "aula/exception.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace aula;

NumberDistribution distribution(const std::string& text, bool whole = false) {
    const JsonValue value = parse_json(text, "test");
    const std::string name = "test";
    return {JsonReader(value, name), NumberRange{}, whole};
}

/// Mean and standard deviation of many draws.
std::pair<double, double> moments(const NumberDistribution& numbers) {
    constexpr int kDraws = 20000;
    RandomStream random(7);
    double sum = 0, squares = 0;
    for (int i = 0; i < kDraws; ++i) {
        const double x = numbers.draw(random);
        sum += x;
        squares += x * x;
    }
    const double mean = sum / kDraws;
    return {mean, std::sqrt(squares / kDraws - mean * mean)};
}

}  // namespace

TEST_CASE("SHA-256 has the values of FIPS 180-4, in any pieces") {
    CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    CHECK(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
          "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    for (const bool portable : {false, true}) {
        Sha256 pieces(portable);
        for (int i = 0; i < 1000; ++i) pieces.add(std::string(1000, 'a'));
        CHECK(pieces.hex() == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
    }
}

TEST_CASE("distributions have their moments and stay within their ends") {
    // Standard error of the mean of 20000 draws: 1/141 of the deviation; four of them.
    const auto check = [](const NumberDistribution& numbers, double mean, double deviation) {
        const auto [found_mean, found_deviation] = moments(numbers);
        CHECK(found_mean == Approx(mean).margin(0.03 * deviation));
        CHECK(found_deviation == Approx(deviation).epsilon(0.03));
    };
    check(distribution("{\"uniform\": [2, 5]}"), 3.5, 3 / std::sqrt(12.0));
    check(distribution("{\"uniform\": [1, 6]}", true), 3.5, std::sqrt(35.0 / 12));
    check(distribution("{\"choice\": [1, 3]}"), 2, 1);
    // Log-uniform from 1 to e^2: mean (e^2 - 1) / 2, mean square (e^4 - 1) / 4.
    const double mean = (std::exp(2) - 1) / 2;
    check(distribution("{\"log_uniform\": [1, 7.38905609893065]}"), mean,
          std::sqrt((std::exp(4) - 1) / 4 - mean * mean));
    RandomStream random(1);
    CHECK(distribution("4").draw(random) == 4);
    CHECK(distribution("{\"choice\": [{\"uniform\": [9, 9]}]}").draw(random) == 9);
}

TEST_CASE("positions keep their distances to walls and sources, in a box and in a mesh") {
    Placement placement;
    placement.wall_clearance_m = 0.7F;
    placement.source_clearance_m = 1.5F;
    const Vec3 size{4, 3, 2.5F};
    Scene scene;
    scene.listener.pose.position = size * 0.5F;
    std::vector<Vec3> corners;
    for (unsigned c = 0; c < 8; ++c)
        corners.push_back(size * Vec3((c & 1U) != 0, (c & 2U) != 0, (c & 4U) != 0));
    const std::vector<std::array<std::uint32_t, 3>> triangles{
        {0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
        {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    scene.add_object(corners, triangles, "plaster");
    constexpr std::array<Vec3, 2> kArray{Vec3(0.2F, 0, 0), Vec3(-0.2F, 0, 0)};
    for (const RoomSpace& space : {RoomSpace(size), RoomSpace(scene, std::nullopt)}) {
        RandomStream random(3);
        const std::vector<PlannedPose> sources{{.position = {1, 1.5F, 1.2F}}};
        for (const PlannedPose& pose : space.draw_poses(placement, 50, kArray, sources, random)) {
            for (const Vec3& microphone : kArray) {
                const Vec3 p = pose.position + microphone;
                for (int axis = 0; axis < 3; ++axis) {
                    // Rounding of single precision.
                    CHECK(p[axis] > 0.7F - 1e-5F);
                    CHECK(p[axis] < size[axis] - 0.7F + 1e-5F);
                }
                CHECK(glm::distance(p, sources[0].position) > 1.5F - 1e-5F);
            }
        }
        placement.source_clearance_m = 10;
        CHECK_THROWS_AS(space.draw_poses(placement, 1, kArray, sources, random), InputError);
        placement.source_clearance_m = 1.5F;
    }
    // Outside the mesh there is no position, although there is in its bounds.
    const RoomSpace outside(scene, Bounds{{5, 5, 5}, {9, 9, 9}});
    RandomStream random(3);
    CHECK_THROWS_AS(outside.draw_poses(placement, 1, kArray, {}, random), InputError);
}

TEST_CASE("a walk is straight and level, and each of its steps is clear") {
    Placement placement;
    placement.walk = Walk{5, NumberDistribution(2)};
    // Two rooms of 4 x 3 m, without a door: a walk stays in its room.
    Scene scene;
    scene.listener.pose.position = Vec3(2, 1.5F, 1.2F);
    const Vec3 size{8, 3, 2.5F};
    std::vector<Vec3> corners;
    for (const float x : {0.0F, size.x, size.x / 2})
        for (unsigned c = 0; c < 4; ++c)
            corners.push_back(Vec3(x, (c & 1U) != 0 ? size.y : 0, (c & 2U) != 0 ? size.z : 0));
    const std::vector<std::array<std::uint32_t, 3>> triangles{
        {0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},  {2, 3, 7},
        {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}, {8, 9, 11}, {8, 11, 10}};
    scene.add_object(corners, triangles, "plaster");
    constexpr std::array<Vec3, 1> kPoint{Vec3(0)};
    for (const RoomSpace& space : {RoomSpace(size), RoomSpace(scene, std::nullopt)}) {
        RandomStream random(3);
        const std::vector<PlannedPose> poses = space.draw_poses(placement, 6, kPoint, {}, random);
        REQUIRE(poses.size() == 30);
        for (std::size_t i = 0; i < poses.size(); ++i) {
            const Vec3& p = poses[i].position;
            for (int axis = 0; axis < 3; ++axis) {
                CHECK(p[axis] > 0.5F - 1e-5F);
                CHECK(p[axis] < size[axis] - 0.5F + 1e-5F);
            }
            if (i % 5 == 0) continue;
            // Positions are rounded to 0.1 mm.
            const Vec3 step = p - poses[i - 1].position;
            CHECK(glm::length(step) == Approx(0.5).margin(2e-4));
            CHECK(step.z == 0);
            if (i % 5 > 1)
                CHECK(glm::distance(step, poses[i - 1].position - poses[i - 2].position) < 4e-4F);
        }
    }
    placement.walk = Walk{5, NumberDistribution(9)};
    RandomStream random(3);
    CHECK_THROWS_AS(RoomSpace(size).draw_poses(placement, 1, kPoint, {}, random), InputError);
}

TEST_CASE("a tar archive is read as written, and damage is noticed") {
    const test::TemporaryFolder folder;
    const auto archive = [](const std::string& content) {
        return tar_header("000001.json", content.size()) + content +
               std::string(tar_padding(content.size()));
    };
    const std::string bytes =
        archive("first") + archive(std::string(512, 'x')) + std::string(tar_end());
    CHECK(bytes.size() == 6 * 512);
    TarReader reader(folder.write("good.tar", bytes));
    const auto first = reader.next();
    REQUIRE(first.has_value());
    CHECK(first->name == "000001.json");
    CHECK(reader.read(*first) == "first");
    CHECK(reader.next()->size == 512);
    CHECK_FALSE(reader.next().has_value());

    const auto count = [&](const std::string& damaged) {
        TarReader tar(folder.write("bad.tar", damaged));
        while (tar.next()) {
        }
    };
    for (const std::size_t length :
         {std::size_t{0}, std::size_t{100}, std::size_t{1024}, bytes.size() - 512})
        CHECK_THROWS_AS(count(bytes.substr(0, length)), InputError);
    for (const std::size_t at : {std::size_t{0}, std::size_t{124}, std::size_t{130},
                                 std::size_t{150}, std::size_t{260}, bytes.size() - 1}) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ 1);
        CHECK_THROWS_AS(count(damaged), InputError);
    }
}

TEST_CASE("WAV bytes are read as written") {
    const std::vector<std::vector<float>> channels{{1, 0, -0.5F}, {0.25F, 2, 3}};
    const std::string bytes = wav_bytes(channels, 16000);
    CHECK(is_wav(bytes, 2, 3, 16000));
    CHECK(wav_channels(bytes, 2) == channels);
    CHECK(wav_length(bytes.size(), 2) == 3);
    CHECK(wav_length(bytes.size() - 4, 2) == 0);
    CHECK(wav_length(4, 2) == 0);
    CHECK(wav_length((std::uint64_t{1} << 32U) + bytes.size(), 2) == 0);
    CHECK_FALSE(is_wav(bytes, 1, 6, 16000));
    CHECK_FALSE(is_wav(bytes, 2, 3, 8000));
    CHECK_FALSE(is_wav("RIFF", 2, 0, 16000));
}

TEST_CASE("numbers of shards are written as ranges") {
    CHECK(array_text({}).empty());
    CHECK(array_text({3}) == "3");
    CHECK(array_text({3, 17, 18, 19}) == "3,17-19");
    CHECK(array_text({0, 1, 5, 7, 8}) == "0-1,5,7-8");
}
