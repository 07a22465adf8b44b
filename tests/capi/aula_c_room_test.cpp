#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <vector>

#include "aula.h"
#include "tests/capi/box_room.h"
#include "tests/room/auralizer/auralizer_rendering.h"

using namespace aula;
using namespace aula::test;

namespace {

/// The scene of CRoom.
Scene box_scene() {
    Scene scene;
    std::vector<Vec3> corners;
    const BoxMesh box;
    for (std::size_t v = 0; v < 8; ++v)
        corners.emplace_back(box.vertices[3 * v], box.vertices[3 * v + 1], box.vertices[3 * v + 2]);
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::size_t t = 0; t < 12; ++t)
        triangles.push_back(
            {box.triangles[3 * t], box.triangles[3 * t + 1], box.triangles[3 * t + 2]});
    scene.add_object(corners, triangles, "brick", "walls");
    scene.objects[0].movable = true;
    scene.simulation.rays = 50;
    scene.simulation.threads = 2;  // any number
    scene.simulation.ir_length_s = 0.2F;
    return scene;
}

}  // namespace

TEST_CASE("C: a room renders the samples of an Auralizer") {
    constexpr int kLength = 9600;
    const bool by_name = GENERATE(false, true);
    CRoom room(quick_options(AULA_EXACT));
    const aula_source source = room.add_source();
    aula_status status{};
    status.size = sizeof(status);
    REQUIRE(aula_room_status(room.handle, &status) == AULA_OK);
    CHECK(status.channels == 1);
    CHECK(status.latency_samples == 256);
    CHECK(status.response_length_s == Approx(0.2));
    std::vector<float> input(kLength);
    for (int n = 0; n < kLength; ++n) input[static_cast<std::size_t>(n)] = noise_at(n);
    std::vector<float> output(kLength);
    const std::array<float, 12> turned{0, -1, 0, 5, 1, 0, 0, -1, 0, 0, 1, 0};
    aula_pose moved = room.pose;
    moved.yaw_rad = 1;
    moved.position[0] = 2;
    for (int n = 0; n < kLength; n += 480) {
        if (n == 1920) REQUIRE(aula_room_set_source(room.handle, source, &moved, 2000) == AULA_OK);
        if (n == 2400) REQUIRE(aula_room_set_gain(room.handle, source, -3, AULA_NOW) == AULA_OK);
        if (n == 4800)
            REQUIRE((by_name ? aula_room_set_material_by_name(room.handle, "walls", "curtain", n)
                             : aula_room_set_material(room.handle, 0, "curtain", n)) == AULA_OK);
        if (n == 6720)
            REQUIRE((by_name
                         ? aula_room_set_transform_by_name(room.handle, "walls", turned.data(), n)
                         : aula_room_set_transform(room.handle, 0, turned.data(), n)) == AULA_OK);
        const aula_signal signal{source, input.data() + n};
        float* const outputs[] = {output.data() + n};
        REQUIRE(aula_room_process_exactly(room.handle, &signal, 1, outputs, 1, 480) == AULA_OK);
    }

    AuralizerOptions options = mono();
    options.max_sources = 2;
    Auralizer auralizer(box_scene(), options);
    auralizer.set_listener({.position = {4, 3, 1.7F}, .yaw_rad = 3.1F});
    const SourceId id = auralizer.add_source({.position = {1, 1, 1.5F}});
    auralizer.set_source(id, {.position = {2, 1, 1.5F}, .yaw_rad = 1}, 2000);
    auralizer.set_gain(id, -3, 2400);
    auralizer.set_material(0, "curtain", 4800);
    // A quarter turn to the left: x becomes y, y becomes -x.
    auralizer.set_transform(
        0, {glm::mat3(Vec3(0, 1, 0), Vec3(-1, 0, 0), Vec3(0, 0, 1)), {5, -1, 0}}, 6720);
    std::vector<float> expected(kLength);
    float* const outputs[] = {expected.data()};
    const SourceSignal signal{id, input.data()};
    auralizer.render({&signal, 1}, outputs, kLength);
    CHECK(output == expected);  // exact
    CHECK(*std::max_element(output.begin(), output.end()) > 0.01F);

    const std::vector<float> response = auralizer.impulse_response(id)[0];
    std::size_t length = 0;
    std::vector<float> buffer(response.size() + 10, 7);
    REQUIRE(aula_room_impulse_response(room.handle, source, 0, buffer.data(), buffer.size(),
                                       &length) == AULA_OK);
    REQUIRE(length == response.size());
    CHECK(std::equal(response.begin(), response.end(), buffer.begin()));
    CHECK(std::count(buffer.begin() + static_cast<std::ptrdiff_t>(length), buffer.end(), 0.0F) ==
          10);
    buffer.assign(20, 7);
    REQUIRE(aula_room_impulse_response(room.handle, source, 0, buffer.data(), 10, &length) ==
            AULA_OK);
    CHECK(length == response.size());
    CHECK(std::equal(buffer.begin(), buffer.begin() + 10, response.begin()));
    CHECK(std::count(buffer.begin() + 10, buffer.end(), 7.0F) == 10);
}

TEST_CASE("C: poses have all angles, and responses all channels") {
    constexpr int kLength = 4800;
    aula_options c_options = quick_options(AULA_EXACT);
    c_options.output = AULA_FOA;
    CRoom room(c_options);
    room.pose.pitch_rad = 0.4F;
    room.pose.roll_rad = -0.7F;
    const aula_source source = room.add_source();
    const aula_pose head{{4, 3, 1.7F}, 3.1F, -0.3F, 0.5F};
    REQUIRE(aula_room_set_source(room.handle, source, &room.pose, 0) == AULA_OK);
    REQUIRE(aula_room_set_listener(room.handle, 0, &head, 0) == AULA_OK);
    AuralizerOptions options = mono();
    options.output = OutputFormat::foa;
    options.max_sources = 2;
    Auralizer auralizer(box_scene(), options);
    const SourceId id = auralizer.add_source({.position = {1, 1, 1.5F}});
    auralizer.set_source(id, {.position = {1, 1, 1.5F}, .pitch_rad = 0.4F, .roll_rad = -0.7F}, 0);
    auralizer.set_listener(
        {.position = {4, 3, 1.7F}, .yaw_rad = 3.1F, .pitch_rad = -0.3F, .roll_rad = 0.5F}, 0);

    std::vector<float> input(kLength);
    for (int n = 0; n < kLength; ++n) input[static_cast<std::size_t>(n)] = noise_at(n);
    std::vector<std::vector<float>> output(4, std::vector<float>(kLength));
    std::vector<std::vector<float>> expected = output;
    const aula_signal c_signal{source, input.data()};
    float* const c_outputs[] = {output[0].data(), output[1].data(), output[2].data(),
                                output[3].data()};
    REQUIRE(aula_room_process_exactly(room.handle, &c_signal, 1, c_outputs, 4, kLength) == AULA_OK);
    const SourceSignal signal{id, input.data()};
    float* const outputs[] = {expected[0].data(), expected[1].data(), expected[2].data(),
                              expected[3].data()};
    auralizer.render({&signal, 1}, outputs, kLength);
    CHECK(output == expected);  // exact

    const auto response = auralizer.impulse_response(id);
    const std::size_t capacity = response[0].size() + 7;
    std::vector<float> buffer(4 * capacity);
    std::size_t length = 0;
    REQUIRE(aula_room_impulse_response(room.handle, source, 0, buffer.data(), capacity, &length) ==
            AULA_OK);
    for (std::size_t c = 0; c < 4; ++c)
        CHECK(std::equal(response[c].begin(), response[c].end(), buffer.data() + c * capacity));

    aula_status status{};
    status.size = sizeof(status);
    REQUIRE(aula_room_status(room.handle, &status) == AULA_OK);
    CHECK(status.frames > 2);
    CHECK(status.frame_worst_ms > status.frame_mean_ms);
}

TEST_CASE("C: a room plays another scene as an Auralizer does") {
    constexpr int kLength = 9600;
    aula_options given = quick_options(AULA_EXACT);
    given.ir_length_s = 0.1;
    CRoom room(given);
    const aula_source source = room.add_source();
    aula_scene* other = nullptr;
    REQUIRE(aula_scene_create(&other) == AULA_OK);
    REQUIRE(aula_room_set_scene(room.handle, other, 4000) == AULA_OK);
    aula_scene_destroy(other);
    CHECK(aula_room_set_material(room.handle, 0, "curtain", 5000) == AULA_INPUT_ERROR);
    CHECK(aula_room_set_scene(room.handle, nullptr, 4000) == AULA_INPUT_ERROR);
    CHECK(aula_room_set_scene(nullptr, nullptr, 4000) == AULA_INPUT_ERROR);
    std::vector<float> input(kLength);
    for (int n = 0; n < kLength; ++n) input[static_cast<std::size_t>(n)] = noise_at(n);
    std::vector<float> output(kLength);
    const aula_signal signal{source, input.data()};
    float* const outputs[] = {output.data()};
    REQUIRE(aula_room_process_exactly(room.handle, &signal, 1, outputs, 1, kLength) == AULA_OK);

    AuralizerOptions options = mono();
    options.max_sources = 2;
    Scene first = box_scene();
    first.simulation.ir_length_s = 0.1F;
    Auralizer auralizer(first, options);
    auralizer.set_listener({.position = {4, 3, 1.7F}, .yaw_rad = 3.1F});
    const SourceId id = auralizer.add_source({.position = {1, 1, 1.5F}});
    Scene second;
    second.simulation.rays = first.simulation.rays;
    second.simulation.ir_length_s = 0.1F;
    second.simulation.frame_rate_hz = first.simulation.frame_rate_hz;
    second.simulation.threads = first.simulation.threads;
    auralizer.set_scene(second, 4000);
    std::vector<float> expected(kLength);
    float* const expected_outputs[] = {expected.data()};
    const SourceSignal expected_signal{id, input.data()};
    auralizer.render({&expected_signal, 1}, expected_outputs, kLength);
    CHECK(output == expected);  // exact
}
