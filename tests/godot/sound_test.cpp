#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <memory>
#include <vector>

#include "apps/godot/sound/axes.h"
#include "apps/godot/sound/room_output.h"
#include "tests/support/realtime_trap.h"

// The parts of the extension that do not need Godot.

namespace godot_sound_test {
namespace {

using namespace aula::godot;
using aula::test::RealtimeTrap;

constexpr float kPi = 3.14159265358979F;

/// A rotation of the engine's: about y, then about x of the result, then about z of that result.
Transform turned(float yaw, float pitch, float roll) {
    const float cy = std::cos(yaw), sy = std::sin(yaw), cx = std::cos(pitch), sx = std::sin(pitch),
                cz = std::cos(roll), sz = std::sin(roll);
    Transform result;
    result.rows = {{{cy * cz + sy * sx * sz, -cy * sz + sy * sx * cz, sy * cx},
                    {cx * sz, cx * cz, -sx},
                    {-sy * cz + cy * sx * sz, sy * sz + cy * sx * cz, cy * cx}}};
    return result;
}

struct Room {
    Room() {
        aula_scene_create(&scene);
        const std::array<float, 12> wall{0, -2, 0, 0, 2, 0, 0, 2, 2, 0, -2, 2};
        const std::array<std::uint32_t, 6> triangles{0, 1, 2, 0, 2, 3};
        aula_scene_add_object(scene, "wall", wall.data(), 4, triangles.data(), 2, "brick", 0,
                              nullptr);
        aula_options options{};
        options.size = sizeof options;
        options.block = 512;
        options.ir_length_s = 0.2;
        options.threads = 1;
        aula_room_create(scene, &options, &room);
    }
    Room(const Room&) = delete;
    Room& operator=(const Room&) = delete;
    ~Room() {
        aula_room_destroy(room);
        aula_scene_destroy(scene);
    }
    aula_scene* scene = nullptr;
    aula_room* room = nullptr;
};

}  // namespace

TEST_CASE("A pose of Godot is that of Aula") {
    // At rest -z, Aula's y, is the front: a quarter turn to the left.
    const aula_pose rest = pose_of(Transform{});
    CHECK(rest.yaw_rad == Approx(kPi / 2));
    CHECK(rest.pitch_rad == 0);
    CHECK(rest.roll_rad == 0);
    Transform moved = turned(0.3F, 0.2F, -0.1F);
    moved.origin = {1, 2, 3};
    const aula_pose pose = pose_of(moved);
    CHECK(pose.position[0] == 1);
    CHECK(pose.position[1] == -3);
    CHECK(pose.position[2] == 2);
    CHECK(pose.yaw_rad == Approx(kPi / 2 + 0.3F));
    CHECK(pose.pitch_rad == Approx(0.2F));
    CHECK(pose.roll_rad == Approx(0.1F));  // Godot's lifts the right, Aula's lowers it
}

TEST_CASE("What a body carries moves with it, without its scale") {
    Transform from = turned(0.4F, -0.3F, 0.2F), to = turned(-1.1F, 0.5F, 0.7F);
    from.origin = {1, 2, 3};
    to.origin = {-2, 0.5F, 1};
    const Vector local{0.3F, -0.8F, 1.2F};
    const Vector before = to_aula(from(local)), after = to_aula(to(local));
    const auto rows = motion(from, to);
    for (std::size_t r = 0; r < 3; ++r) {
        CHECK(rows[4 * r] * before[0] + rows[4 * r + 1] * before[1] + rows[4 * r + 2] * before[2] +
                  rows[4 * r + 3] ==
              Approx(after[r]).margin(1e-5));
    }
    // A mirrored, stretched and sheared body has the rigid transform of its x and y.
    Transform skewed = from;
    for (auto& row : skewed.rows) row = {3 * row[0], row[1] + row[0], -row[2] + row[1]};
    const Transform straight = rigid(skewed);
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c)
            CHECK(straight.rows[r][c] == Approx(from.rows[r][c]).margin(1e-6));
    // relative() undoes a rigid transform.
    const Transform same = relative(from, from);
    for (std::size_t r = 0; r < 3; ++r) {
        CHECK(same.origin[r] == Approx(0).margin(1e-6));
        for (std::size_t c = 0; c < 3; ++c)
            CHECK(same.rows[r][c] == Approx(r == c ? 1 : 0).margin(1e-6));
    }
    // A transform without an inverse has no rotation.
    Transform flat;
    flat.rows = {};
    CHECK(rigid(flat).rows == Transform{}.rows);
}

TEST_CASE("The buses of a room neither allocate, free, lock nor write, and render its sources") {
    const Room room;
    REQUIRE(room.room != nullptr);
    const aula_pose source_pose{{1, 0, 1}, 0, 0, 0}, head{{3, 0, 1}, 0, 0, 0};
    aula_source number = 0;
    REQUIRE(aula_room_add_source(room.room, &source_pose, nullptr, AULA_NOW, &number) == AULA_OK);
    REQUIRE(aula_room_set_listener(room.room, 0, &head, AULA_NOW) == AULA_OK);

    const auto input = std::make_unique<SourceInput>();
    const auto output = std::make_unique<RoomOutput>(48000.0);
    output->add(*input);
    CHECK(output->exchange(room.room, false) == nullptr);
    const std::vector<StereoSample> sound(512, {0.5F, 0.1F});
    std::vector<StereoSample> passed(512, {1, 1}), heard(512);

    // A signal of 0.3 arrives once the number of the source is known, and its first frame is there.
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    float without = 0, with = 0;
    {
        const RealtimeTrap trap;
        for (int block = 0; with == 0 && std::chrono::steady_clock::now() < end; ++block) {
            if (block == 100) input->number = number;
            input->process(sound.data(), passed.data(), 512);
            output->process(nullptr, heard.data(), 512);
            float& peak = block < 100 ? without : with;
            for (const StereoSample& sample : heard)
                peak = std::max({peak, std::abs(sample.left), std::abs(sample.right)});
        }
        if (RealtimeTrap::available()) CHECK(trap.violations().total() == 0);
    }
    CHECK(without == 0);
    CHECK(with > 0);
    CHECK(passed.front().left == 0);
    CHECK(output->load() > 0);

    // Each block is taken once: a bus that is not processed is silent.
    input->process(sound.data(), passed.data(), 512);
    CHECK(input->take(512).samples != nullptr);
    CHECK(input->take(512).samples == nullptr);
    // Blocks that are too long, and a room that is gone, are silence.
    std::vector<StereoSample> long_block(SourceInput::kMostSamples + 1, {1, 1});
    output->process(nullptr, long_block.data(), static_cast<int>(long_block.size()));
    CHECK(long_block.back().left == 0);
    CHECK(output->exchange(nullptr, false) == room.room);
    heard.front().left = 1;
    output->process(nullptr, heard.data(), 512);
    CHECK(heard.front().left == 0);
    output->remove(*input);
}

TEST_CASE("A room of Godot takes inputs up to its most") {
    const auto output = std::make_unique<RoomOutput>(48000.0);
    const auto input = std::make_unique<SourceInput>();
    for (std::size_t n = 0; n < RoomOutput::kMostInputs; ++n) CHECK(output->add(*input));
    CHECK_FALSE(output->add(*input));
    output->remove(*input);
    CHECK(output->add(*input));
}

}  // namespace godot_sound_test
