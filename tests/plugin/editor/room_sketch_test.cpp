#include "apps/plugin/editor/room_sketch.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>

#include "tests/support/temporary_folder.h"

namespace room_sketch_test {

namespace {

using namespace aula;
using namespace aula::test;
using plugin::RoomSketch;

/// Shows a scene until a condition holds, for at most two minutes.
template <typename Condition>
bool shown_until(RoomSketch& sketch, const std::string& file, Condition&& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    while (!holds()) {
        if (std::chrono::steady_clock::now() > end) return false;
        sketch.show({.scene = file}, plugin::initial_values());
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
}

}  // namespace

TEST_CASE("An editor measures T30 of the scene that it shows") {
    const TemporaryFolder folder;
    const std::string file = folder.write("box.json", R"({"aula": 1,
        "geometry": [{"box": [6, 5, 4], "material": "even"}],
        "materials": {"even": {"absorption": 0.3, "scattering": 1}},
        "sources": [{"position": [2, 2, 2]}], "listener": {"position": [4, 3, 1.5]}})");
    RoomSketch sketch(1);
    REQUIRE(shown_until(sketch, file, [&] { return sketch.times().has_value(); }));
    REQUIRE(sketch.room());
    CHECK(sketch.error().empty());
    CHECK(sketch.room()->scene.sources[0].position == Vec3(2, 2, 2));
    // Eyring: 24 ln(10) V / (c S -ln(1 - 0.3)). Its field is diffuse; that of the box is to 10 %.
    const double eyring_s =
        24 * std::log(10.0) * 6 * 5 * 4 / (343.2 * 2 * (30 + 24 + 20) * -std::log(0.7));
    REQUIRE(sketch.times()->mid);
    CHECK(*sketch.times()->mid == Approx(eyring_s).epsilon(0.1));
    REQUIRE(sketch.times()->octaves[3]);
    CHECK(*sketch.times()->octaves[3] == Approx(eyring_s).epsilon(0.15));
    // While another scene is loaded and measured there are no times of the last one.
    REQUIRE(shown_until(sketch, "/nowhere/hall.json", [&] { return !sketch.error().empty(); }));
    CHECK(sketch.error().find("/nowhere/hall.json") != std::string::npos);
    CHECK_FALSE(sketch.times());
    CHECK(sketch.room()->scene.sources[0].position != Vec3(2, 2, 2));  // of the default room
}

}  // namespace room_sketch_test
