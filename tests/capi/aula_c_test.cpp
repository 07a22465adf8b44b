#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>
#include <vector>

#include "apps/capi/handles.h"
#include "aula.h"
#include "aula/exception.h"
#include "tests/capi/box_room.h"
#include "tests/room/auralizer/auralizer_rendering.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait.h"

using namespace aula;
using namespace aula::test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A rigid transform that moves nothing.
constexpr std::array<float, 12> kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// All functions that change a room, with arguments that are right for a room with source 1.
std::vector<int> change_all(aula_room* room) {
    const aula_pose pose{{2, 2, 1}, 0, 0, 0};
    aula_source added = 7;
    return {aula_room_add_source(room, &pose, "cardioid", AULA_NOW, &added),
            aula_room_set_source(room, 1, &pose, AULA_NOW),
            aula_room_set_gain(room, 1, -6, AULA_NOW),
            aula_room_set_listener(room, 0, &pose, AULA_NOW),
            aula_room_set_transform(room, 0, kIdentity.data(), AULA_NOW),
            aula_room_set_material(room, 0, "curtain", AULA_NOW),
            aula_room_set_transform_by_name(room, "walls", kIdentity.data(), AULA_NOW),
            aula_room_set_material_by_name(room, "walls", "curtain", AULA_NOW),
            aula_room_commit(room, 0),
            aula_room_remove_source(room, 1, AULA_NOW)};
}

}  // namespace

TEST_CASE("C: null arguments are input errors and leave null handles") {
    CScene scene;
    scene.add_box();
    CRoom room(quick_options(AULA_EXACT));
    const aula_source source = room.add_source();
    const BoxMesh box;
    const std::array<float, AULA_BANDS> bands{};
    aula_scene* no_scene = scene.handle;
    aula_room* no_room = room.handle;
    aula_source found = 1;
    std::size_t index = 0;
    int silent = 0;
    float* const outputs[] = {nullptr};
    aula_status status{};
    const std::vector<int> results{
        aula_scene_load(nullptr, &no_scene),
        aula_scene_load("x.json", nullptr),
        aula_scene_create(nullptr),
        aula_scene_add_material(nullptr, "m", bands.data(), bands.data(), nullptr),
        aula_scene_add_material(scene.handle, nullptr, bands.data(), bands.data(), nullptr),
        aula_scene_add_material(scene.handle, "m", nullptr, bands.data(), nullptr),
        aula_scene_add_material(scene.handle, "m", bands.data(), nullptr, nullptr),
        aula_scene_add_object(nullptr, "o", box.vertices.data(), 8, box.triangles.data(), 12,
                              "brick", 0, nullptr),
        aula_scene_add_object(scene.handle, "o", nullptr, 8, box.triangles.data(), 12, "brick", 0,
                              nullptr),
        aula_scene_add_object(scene.handle, "o", box.vertices.data(), 8, nullptr, 12, "brick", 0,
                              nullptr),
        aula_scene_add_object(scene.handle, "o", box.vertices.data(), 8, box.triangles.data(), 12,
                              nullptr, 0, nullptr),
        aula_scene_find_object(nullptr, "walls", &index),
        aula_scene_find_object(scene.handle, nullptr, &index),
        aula_scene_find_object(scene.handle, "walls", nullptr),
        aula_scene_make_movable(nullptr, 0),
        aula_scene_find_source(nullptr, "voice", &found),
        aula_scene_find_source(scene.handle, nullptr, &found),
        aula_scene_find_source(scene.handle, "voice", nullptr),
        aula_scene_add_source(nullptr, "s", &room.pose, nullptr, 0, &found),
        aula_scene_add_source(scene.handle, nullptr, &room.pose, nullptr, 0, &found),
        aula_scene_add_source(scene.handle, "s", nullptr, nullptr, 0, &found),
        aula_scene_add_source(scene.handle, "s", &room.pose, nullptr, 0, nullptr),
        aula_scene_set_listener(nullptr, &room.pose),
        aula_scene_set_listener(scene.handle, nullptr),
        aula_room_create(nullptr, nullptr, &no_room),
        aula_room_create(scene.handle, nullptr, nullptr),
        aula_room_add_source(nullptr, &room.pose, nullptr, 0, &found),
        aula_room_add_source(room.handle, nullptr, nullptr, 0, &found),
        aula_room_add_source(room.handle, &room.pose, nullptr, 0, nullptr),
        aula_room_set_source(room.handle, source, nullptr, 0),
        aula_room_set_listener(room.handle, 0, nullptr, 0),
        aula_room_set_transform(room.handle, 0, nullptr, 0),
        aula_room_set_material(room.handle, 0, nullptr, 0),
        aula_room_set_transform_by_name(room.handle, nullptr, kIdentity.data(), 0),
        aula_room_set_transform_by_name(room.handle, "walls", nullptr, 0),
        aula_room_set_material_by_name(room.handle, nullptr, "curtain", 0),
        aula_room_set_material_by_name(room.handle, "walls", nullptr, 0),
        aula_room_process(nullptr, nullptr, 0, outputs, 1, 1),
        aula_room_process_exactly(nullptr, nullptr, 0, outputs, 1, 1),
        aula_room_process_exactly(room.handle, nullptr, 1, outputs, 1, 1),
        aula_room_process_exactly(room.handle, nullptr, 0, nullptr, 1, 1),
        aula_room_process_exactly(room.handle, nullptr, 0, outputs, 1, 1),
        aula_room_status(nullptr, &status),
        aula_room_status(room.handle, nullptr),
        aula_room_is_silent(nullptr, source, 0, &silent),
        aula_room_is_silent(room.handle, source, 0, nullptr),
        aula_room_impulse_response(nullptr, source, 0, nullptr, 0, &index),
        aula_room_impulse_response(room.handle, source, 0, nullptr, 1, &index),
        aula_room_impulse_response(room.handle, source, 0, nullptr, 0, nullptr)};
    for (std::size_t call = 0; call < results.size(); ++call) {
        INFO("call " << call);
        CHECK(results[call] == AULA_INPUT_ERROR);
    }
    for (const int result : change_all(nullptr)) CHECK(result == AULA_INPUT_ERROR);
    CHECK(no_scene == nullptr);
    CHECK(no_room == nullptr);
    CHECK(found == 0);
    CHECK(std::string(aula_message()) == "room is null");
    aula_scene_destroy(nullptr);
    aula_room_destroy(nullptr);
}

TEST_CASE("C: wrong content of a scene is an error that says what was expected") {
    CScene scene;
    scene.add_box();
    BoxMesh box;
    const auto add = [&](const char* name, const char* material, std::size_t triangles) {
        return aula_scene_add_object(scene.handle, name, box.vertices.data(), 8,
                                     box.triangles.data(), triangles, material, 0, nullptr);
    };
    CHECK((add("walls", "brick", 12) == AULA_INPUT_ERROR && message_has("an object \"walls\"")));
    CHECK((add(nullptr, "cheese", 12) == AULA_INPUT_ERROR && message_has("cheese")));
    CHECK((add(nullptr, "brick", 0) == AULA_INPUT_ERROR && message_has("no triangle")));
    box.triangles[7] = 8;
    CHECK((add(nullptr, "brick", 12) == AULA_INPUT_ERROR && message_has("triangle 2")));
    box.triangles[7] = 0;
    for (const float wrong : {kNan, std::numeric_limits<float>::infinity(), 2e6F}) {
        box.vertices[5] = wrong;
        CHECK((add(nullptr, "brick", 12) == AULA_INPUT_ERROR && message_has("vertex 1")));
    }
    box.vertices[5] = 0;
    CHECK(add(nullptr, "brick", 12) == AULA_OK);
    CHECK(add(nullptr, "brick", 12) == AULA_OK);  // names may be absent

    std::array<float, AULA_BANDS> half{};
    half.fill(0.5F);
    std::array<float, AULA_BANDS> wrong = half;
    const auto material = [&](const char* name, const float* absorption, const float* scattering,
                              const float* reduction_db) {
        return aula_scene_add_material(scene.handle, name, absorption, scattering, reduction_db);
    };
    CHECK(material("felt", half.data(), half.data(), nullptr) == AULA_OK);
    CHECK(material("felt", half.data(), half.data(), nullptr) == AULA_INPUT_ERROR);
    CHECK(material("", half.data(), half.data(), nullptr) == AULA_INPUT_ERROR);
    for (const float value : {-0.1F, 1.1F, kNan}) {
        wrong[7] = value;
        CHECK(material("x", wrong.data(), half.data(), nullptr) == AULA_INPUT_ERROR);
        CHECK(material("x", half.data(), wrong.data(), nullptr) == AULA_INPUT_ERROR);
    }
    wrong.fill(0);  // transmits everything
    CHECK((material("x", half.data(), half.data(), wrong.data()) == AULA_INPUT_ERROR &&
           message_has("transmits")));
    wrong.fill(30);
    CHECK(material("x", half.data(), half.data(), wrong.data()) == AULA_OK);
    CHECK(add("panel", "felt", 12) == AULA_OK);

    std::size_t index = 0;
    CHECK((aula_scene_find_object(scene.handle, "panel", &index) == AULA_OK && index == 3));
    CHECK(aula_scene_find_object(scene.handle, "Panel", &index) == AULA_INPUT_ERROR);
    CHECK(aula_scene_find_object(scene.handle, "", &index) == AULA_INPUT_ERROR);
    CHECK(aula_scene_make_movable(scene.handle, 3) == AULA_OK);
    CHECK(aula_scene_make_movable(scene.handle, 4) == AULA_INPUT_ERROR);
    aula_source source = 1;
    CHECK(aula_scene_find_source(scene.handle, "voice", &source) == AULA_INPUT_ERROR);
    CHECK(source == 0);
}

TEST_CASE("C: a scene file is read, and its errors are named") {
    const TemporaryFolder folder;
    const auto load = [&](const std::string& text, aula_scene** scene) {
        return aula_scene_load(folder.write("s.json", text).c_str(), scene);
    };
    aula_scene* scene = nullptr;
    REQUIRE(load(R"({"aula": 1, "listener": {"position": [0, 0, 0]},
                     "sources": [{"name": "a", "position": [1, 0, 0], "signal": "impulse"},
                                 {"name": "b", "position": [2, 0, 0], "signal": "noise"}]})",
                 &scene) == AULA_OK);
    aula_source source = 0;
    CHECK((aula_scene_find_source(scene, "b", &source) == AULA_OK && source == 2));
    CHECK(aula_scene_source_name(scene, 2) == std::string("b"));
    CHECK(aula_scene_source_name(scene, 0) == nullptr);
    CHECK(aula_scene_source_name(scene, 3) == nullptr);
    CHECK(aula_scene_source_name(nullptr, 1) == nullptr);
    aula_scene_destroy(scene);
    CHECK((load(R"({"aula": 1})", &scene) == AULA_INPUT_ERROR && message_has("s.json")));
    CHECK(scene == nullptr);
    CHECK(aula_scene_load("/no/such/file", &scene) == AULA_INPUT_ERROR);
}

TEST_CASE("C: a scene of arrays with source and listener sounds like its file") {
    const TemporaryFolder folder;
    const auto sound = [](aula_scene* scene, aula_source source) {
        aula_room* room = nullptr;
        aula_options options = quick_options(AULA_EXACT);
        options.ir_length_s = 0;
        REQUIRE(aula_room_create(scene, &options, &room) == AULA_OK);
        std::vector<float> samples(9600), input(9600);
        input[0] = 1;
        const aula_signal signal{source, input.data()};
        float* const outputs[] = {samples.data()};
        REQUIRE(aula_room_process_exactly(room, &signal, 1, outputs, 1, 9600) == AULA_OK);
        aula_status status{};
        status.size = sizeof status;
        REQUIRE(aula_room_status(room, &status) == AULA_OK);
        CHECK(status.response_length_s > 1);  // of brick
        aula_room_destroy(room);
        return samples;
    };
    const CScene scene;
    scene.add_box();
    const aula_pose place{{1, 1, 1.5F}, 0.5F, 0, 0}, head{{4, 3, 1.7F}, 0, 0, 0};
    aula_source source = 0;
    REQUIRE(aula_scene_add_source(scene.handle, "voice", &place, "cardioid", -3, &source) ==
            AULA_OK);
    CHECK(source == 1);
    REQUIRE(aula_scene_set_listener(scene.handle, &head) == AULA_OK);

    const std::string file = folder.write("s.json", R"({"aula": 1,
        "geometry": [{"name": "walls", "box": [6, 4, 3], "material": "brick"}],
        "sources": [{"name": "voice", "position": [1, 1, 1.5], "yaw_deg": 28.6478897565,
                     "directivity": "cardioid", "gain_db": -3}],
        "listener": {"position": [4, 3, 1.7]}})");
    aula_scene* loaded = nullptr;
    REQUIRE(aula_scene_load(file.c_str(), &loaded) == AULA_OK);
    const std::vector<float> expected = sound(loaded, 1), samples = sound(scene.handle, source);
    aula_scene_destroy(loaded);
    // The triangles are numbered differently, so that diffuse sound has other rays.
    double energy = 0, expected_energy = 0;
    for (std::size_t n = 0; n < samples.size(); ++n) {
        energy += static_cast<double>(samples[n]) * static_cast<double>(samples[n]);
        expected_energy += static_cast<double>(expected[n]) * static_cast<double>(expected[n]);
    }
    CHECK(energy == Approx(expected_energy).epsilon(0.1));

    CHECK((aula_scene_add_source(scene.handle, "voice", &place, nullptr, 0, &source) ==
               AULA_INPUT_ERROR &&
           message_has("voice")));
    CHECK(source == 0);
    CHECK(aula_scene_add_source(scene.handle, "", &place, nullptr, 0, &source) == AULA_INPUT_ERROR);
    CHECK((aula_scene_add_source(scene.handle, "b", &place, "banana", 0, &source) ==
               AULA_INPUT_ERROR &&
           message_has("banana")));
    CHECK(aula_scene_add_source(scene.handle, "b", &place, nullptr, 300, &source) ==
          AULA_INPUT_ERROR);
    const aula_pose far{{kNan, 0, 0}, 0, 0, 0};
    CHECK(aula_scene_add_source(scene.handle, "b", &far, nullptr, 0, &source) == AULA_INPUT_ERROR);
    CHECK(aula_scene_set_listener(scene.handle, &far) == AULA_INPUT_ERROR);
    CHECK(aula_scene_add_source(scene.handle, "b", &place, nullptr, 0, &source) == AULA_OK);
    CHECK(source == 2);
}

TEST_CASE("C: wrong arguments for a room are errors that change nothing") {
    CRoom room(quick_options(AULA_EXACT));
    const aula_source source = room.add_source();
    aula_pose pose = room.pose;
    aula_source added = 9;
    for (const float y : {kNan, 1e30F}) {
        pose.position[1] = y;
        CHECK(aula_room_set_source(room.handle, source, &pose, 0) == AULA_INPUT_ERROR);
        CHECK(aula_room_set_listener(room.handle, 0, &pose, 0) == AULA_INPUT_ERROR);
        CHECK(aula_room_add_source(room.handle, &pose, nullptr, 0, &added) == AULA_INPUT_ERROR);
        CHECK(added == 0);
    }
    CHECK((aula_room_add_source(room.handle, &room.pose, "banana", 0, &added) == AULA_INPUT_ERROR &&
           message_has("banana")));
    for (const aula_source absent : {aula_source{0}, aula_source{99}, ~aula_source{0}}) {
        CHECK(aula_room_set_source(room.handle, absent, &room.pose, 0) == AULA_INPUT_ERROR);
        CHECK(aula_room_set_gain(room.handle, absent, 0, 0) == AULA_INPUT_ERROR);
        CHECK((aula_room_remove_source(room.handle, absent, 0) == AULA_INPUT_ERROR &&
               message_has(std::to_string(absent))));
        std::size_t length = 1;
        CHECK(aula_room_impulse_response(room.handle, absent, 0, nullptr, 0, &length) ==
              AULA_INPUT_ERROR);
        CHECK(length == 0);
    }
    CHECK(aula_room_set_gain(room.handle, source, 201, 0) == AULA_INPUT_ERROR);
    CHECK(aula_room_set_gain(room.handle, source, kNan, 0) == AULA_INPUT_ERROR);
    CHECK(aula_room_set_gain(room.handle, source, -INFINITY, 0) == AULA_OK);
    for (const std::int32_t listener : {-1, 1}) {
        std::size_t length = 1;
        CHECK(aula_room_set_listener(room.handle, listener, &room.pose, 0) == AULA_INPUT_ERROR);
        CHECK(aula_room_impulse_response(room.handle, source, listener, nullptr, 0, &length) ==
              AULA_INPUT_ERROR);
    }
    CHECK(aula_room_set_transform(room.handle, 1, kIdentity.data(), 0) == AULA_INPUT_ERROR);
    std::array<float, 12> sheared = kIdentity;
    sheared[1] = 0.5F;
    CHECK(aula_room_set_transform(room.handle, 0, sheared.data(), 0) == AULA_INPUT_ERROR);
    CHECK(aula_room_set_material(room.handle, 1, "curtain", 0) == AULA_INPUT_ERROR);
    CHECK(aula_room_set_material(room.handle, 0, "cheese", 0) == AULA_INPUT_ERROR);
    CHECK(aula_room_set_material_by_name(room.handle, "walls", "cheese", 0) == AULA_INPUT_ERROR);
    for (const char* const absent : {"door", ""}) {
        CHECK((aula_room_set_material_by_name(room.handle, absent, "curtain", 0) ==
                   AULA_INPUT_ERROR &&
               message_has("there is no \"" + std::string(absent) + "\" in the room")));
        CHECK(aula_room_set_transform_by_name(room.handle, absent, kIdentity.data(), 0) ==
              AULA_INPUT_ERROR);
    }
    CHECK(aula_room_add_source(room.handle, &room.pose, nullptr, 0, &added) == AULA_OK);
    CHECK((aula_room_add_source(room.handle, &room.pose, nullptr, 0, &added) == AULA_INPUT_ERROR &&
           message_has("2 sources")));

    std::array<float, 8> output{};
    output.fill(7);
    float* const outputs[] = {output.data(), output.data()};
    const aula_signal signals[3] = {};
    for (const auto process : {aula_room_process, aula_room_process_exactly}) {
        CHECK(process(room.handle, signals, 1, outputs, 2, 8) == AULA_INPUT_ERROR);
        CHECK(process(room.handle, signals, 3, outputs, 1, 8) == AULA_INPUT_ERROR);
        CHECK(process(room.handle, signals, 1, outputs, 1, -1) == AULA_INPUT_ERROR);
    }
    CHECK((aula_room_process(room.handle, signals, 1, outputs, 1, 8) == AULA_INPUT_ERROR &&
           message_has("aula_room_process_exactly")));
    CHECK(std::count(output.begin(), output.end(), 7.0F) == 8);
    aula_status status{};
    status.size = sizeof(status);
    CHECK((aula_room_status(room.handle, &status) == AULA_OK && status.sources == 2));
    CRoom live(quick_options(AULA_REAL_TIME));
    CHECK((aula_room_process_exactly(live.handle, nullptr, 0, outputs, 1, 8) == AULA_INPUT_ERROR &&
           message_has("aula_room_process()")));
}

TEST_CASE("C: options out of range are errors") {
    const CScene scene;
    const auto refuses = [&](auto change) {
        aula_options options = quick_options(AULA_EXACT);
        change(options);
        aula_room* room = nullptr;
        const int result = aula_room_create(scene.handle, &options, &room);
        aula_room_destroy(room);
        return result == AULA_INPUT_ERROR && room == nullptr;
    };
    CHECK_FALSE(refuses([](aula_options&) {}));
    CHECK(refuses([](aula_options& o) { o.clock = 2; }));
    CHECK(refuses([](aula_options& o) { o.output = 99; }));
    CHECK(refuses([](aula_options& o) { o.sample_rate_hz = 1; }));
    CHECK(refuses([](aula_options& o) { o.sample_rate_hz = double{kNan}; }));
    CHECK(refuses([](aula_options& o) { o.frame_rate_hz = -1; }));
    CHECK(refuses([](aula_options& o) { o.frame_rate_hz = double{kNan}; }));
    CHECK(refuses([](aula_options& o) { o.ir_length_s = 11; }));
    CHECK(refuses([](aula_options& o) { o.block = -1; }));
    CHECK(refuses([](aula_options& o) { o.ambisonic_order = 4; }));
    CHECK(refuses([](aula_options& o) { o.listeners = 65; }));
    CHECK(refuses([](aula_options& o) { o.max_sources = -1; }));
    CHECK(refuses([](aula_options& o) { o.rays = -1; }));
    CHECK(refuses([](aula_options& o) { o.threads = -1; }));
    CHECK(refuses([](aula_options& o) { o.threads = 1025; }));
    CHECK(refuses([](aula_options& o) { o.frame_rate_hz = 1001; }));
    CHECK(refuses([](aula_options& o) { o.rays = 200'001; }));
    CHECK(refuses([](aula_options& o) {
        o.output = AULA_BINAURAL;
        o.hrtf = "/no/such.sofa";
    }));
    CHECK(refuses([](aula_options& o) {
        o.output = AULA_BINAURAL;
        o.headphones = "/no/such.wav";
    }));
    CHECK(refuses([](aula_options& o) {
        o.output = AULA_MONO;
        o.headphones = "headphones.wav";
    }));
}

TEST_CASE("C: a room has the channels of its output for each listener") {
    const CScene scene;
    for (const auto& [output, channels] : {std::pair{AULA_BINAURAL, 2}, std::pair{AULA_MONO, 1},
                                           std::pair{AULA_FOA, 4}, std::pair{AULA_TOA, 16}}) {
        aula_options options = quick_options(AULA_EXACT);
        options.output = output;
        options.listeners = 2;
        aula_room* room = nullptr;
        REQUIRE(aula_room_create(scene.handle, &options, &room) == AULA_OK);
        aula_status status{};
        status.size = sizeof(status);
        CHECK(aula_room_status(room, &status) == AULA_OK);
        CHECK(status.channels == 2 * channels);
        CHECK(status.skipped_frames == 0);  // on the exact clock
        CHECK(status.muted_samples == 0);
        aula_room_destroy(room);
    }
}

TEST_CASE("C: structs of older and newer programs are understood") {
    const CScene scene;
    aula_room* room = nullptr;
    struct {
        aula_options known;
        std::size_t next = 0;  // without padding, whose value is not defined
    } newer{.known = quick_options(AULA_EXACT)};
    newer.known.size = sizeof(newer);
    REQUIRE(aula_room_create(scene.handle, &newer.known, &room) == AULA_OK);
    aula_room_destroy(room);
    newer.next = 1;  // a member that this version does not know
    CHECK(aula_room_create(scene.handle, &newer.known, &room) == AULA_INPUT_ERROR);
    for (const std::size_t size : {std::size_t{0}, sizeof(std::size_t) - 1, ~std::size_t{0}}) {
        newer.known.size = size;
        CHECK((aula_room_create(scene.handle, &newer.known, &room) == AULA_INPUT_ERROR &&
               message_has("sizeof(aula_options)")));
    }
    aula_options older = quick_options(AULA_EXACT);
    older.size = offsetof(aula_options, rays);
    older.rays = -1;  // beyond the end of an older struct
    REQUIRE(aula_room_create(scene.handle, &older, &room) == AULA_OK);
    aula_status status{};
    status.size = offsetof(aula_status, rays);
    status.rays = 77;
    CHECK(aula_room_status(room, &status) == AULA_OK);
    CHECK(status.rays == 77);
    CHECK(status.size == offsetof(aula_status, rays));
    status.size = 0;
    CHECK((aula_room_status(room, &status) == AULA_INPUT_ERROR &&
           message_has("sizeof(aula_status)")));
    aula_room_destroy(room);
}

TEST_CASE("C: late, skipped and muted are what the Auralizer counts") {
    // Frames of 1 ms, which take longer.
    aula_options options = quick_options(AULA_REAL_TIME);
    options.frame_rate_hz = 1000;
    options.rays = 3000;
    CRoom room(options);
    const aula_source source = room.add_source();
    aula_status status{};
    status.size = sizeof(status);
    REQUIRE(eventually(
        [&] { return aula_room_status(room.handle, &status) == AULA_OK && status.frames > 4; }));
    CHECK(status.late_frames > 0);
    CHECK(status.late_frames <= status.frames);
    CHECK(status.skipped_frames > 0);
    std::vector<float> input(256, 0.1F);
    input[7] = 1e38F;
    input[8] = kNan;
    std::vector<float> output(256);
    const aula_signal signal{source, input.data()};
    float* const outputs[] = {output.data()};
    REQUIRE(aula_room_process(room.handle, &signal, 1, outputs, 1, 256) == AULA_OK);
    REQUIRE(aula_room_status(room.handle, &status) == AULA_OK);
    CHECK(status.muted_samples == 2);
    CHECK(room.handle->auralizer.status().muted_samples == 2);
    for (const float x : output) CHECK(std::abs(x) < 100);
}

TEST_CASE("C: a listener that nothing of a source reaches is in the status") {
    CRoom room(quick_options(AULA_EXACT));
    const aula_source source = room.add_source();
    std::vector<float> output(48000);
    float* const outputs[] = {output.data()};
    for (const bool outside : {false, true, false}) {
        room.listener.position[2] = outside ? 4 : 1.7F;
        REQUIRE(aula_room_set_listener(room.handle, 0, &room.listener, AULA_NOW) == AULA_OK);
        REQUIRE(aula_room_process_exactly(room.handle, nullptr, 0, outputs, 1, 48000) == AULA_OK);
        aula_status status{};
        status.size = sizeof(status);
        REQUIRE(aula_room_status(room.handle, &status) == AULA_OK);
        CHECK(status.silent_pairs == (outside ? 1U : 0U));
        int silent = 2;
        CHECK(aula_room_is_silent(room.handle, source, 0, &silent) == AULA_OK);
        CHECK(silent == (outside ? 1 : 0));
        for (const auto& [other, listener] : {std::pair{source, 1}, std::pair{source + 1, 0}}) {
            silent = 2;
            CHECK(aula_room_is_silent(room.handle, other, listener, &silent) == AULA_INPUT_ERROR);
            CHECK(silent == 0);
        }
    }
}

TEST_CASE("C: after a failure of the propagation each function returns it") {
    for (const RenderClock clock : {RenderClock::exact, RenderClock::real_time}) {
        AuralizerOptions options = mono(clock);
        options.before_frame = [](Auralizer&, double time_s) {
            if (time_s > 0) throw Failure("the roof fell in");
        };
        aula_room room(small_room(), {}, options);
        aula_status status{};
        status.size = sizeof(status);
        std::vector<float> output(4096, 7);
        float* const outputs[] = {output.data()};
        const auto process =
            clock == RenderClock::exact ? aula_room_process_exactly : aula_room_process;
        REQUIRE(eventually([&] {
            process(&room, nullptr, 0, outputs, 1, 4096);
            return aula_room_status(&room, &status) == AULA_FAILURE;
        }));
        CHECK(message_has("the roof fell in"));
        for (const int result : change_all(&room)) CHECK(result == AULA_FAILURE);
        std::size_t length = 1;
        CHECK(aula_room_impulse_response(&room, 1, 0, nullptr, 0, &length) == AULA_FAILURE);
        const int expected = clock == RenderClock::exact ? AULA_FAILURE : AULA_OK;
        CHECK(process(&room, nullptr, 0, outputs, 1, 4096) == expected);
    }
}

TEST_CASE("C: commands of several threads and rendering run at the same time") {
    CRoom room(quick_options(AULA_REAL_TIME));
    REQUIRE(room.add_source() == 1);
    std::atomic<bool> stop = false;
    std::atomic<int> failures = 0;
    const auto count = [&](bool holds) { failures += holds ? 0 : 1; };
    std::vector<std::thread> threads;
    for (int t = 0; t < 3; ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; !stop; ++i) {
                aula_pose pose = room.pose;
                pose.position[0] += 0.01F * static_cast<float>(i % 100);
                count(aula_room_set_source(room.handle, 1, &pose, AULA_NOW) == AULA_OK);
                count(aula_room_set_listener(room.handle, 0, &room.listener, AULA_NOW) == AULA_OK);
                aula_status status{};
                status.size = sizeof(status);
                count(aula_room_status(room.handle, &status) == AULA_OK);
                // Each thread has its message.
                const std::string name = "thread " + std::to_string(t);
                count(aula_room_set_material(room.handle, 0, name.c_str(), AULA_NOW) ==
                      AULA_INPUT_ERROR);
                count(std::string(aula_message()).find(name) != std::string::npos);
                if (t > 0) continue;
                aula_source added = 0;
                count(aula_room_add_source(room.handle, &pose, nullptr, AULA_NOW, &added) ==
                      AULA_OK);
                count(aula_room_remove_source(room.handle, added, AULA_NOW) == AULA_OK);
                std::size_t length = 0;
                count(aula_room_impulse_response(room.handle, 1, 0, nullptr, 0, &length) ==
                      AULA_OK);
            }
        });
    const std::vector<float> input(300, 0.1F);
    std::vector<float> output(300);
    float* const outputs[] = {output.data()};
    const aula_signal signal{1, input.data()};
    aula_status status{};
    status.size = sizeof(status);
    bool audible = false;
    REQUIRE(eventually([&] {
        count(aula_room_process(room.handle, &signal, 1, outputs, 1, 300) == AULA_OK);
        audible |= output[0] != 0;
        count(aula_room_status(room.handle, &status) == AULA_OK);
        return audible && status.frames > 5;
    }));
    stop = true;
    for (std::thread& thread : threads) thread.join();
    CHECK(failures == 0);
}
