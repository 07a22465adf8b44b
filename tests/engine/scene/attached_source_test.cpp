// Sources that move and turn with the listener.
#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <string>

#include "aula/engine/scene_file.h"
#include "aula/exception.h"

namespace attached_source_test {

using namespace aula;

namespace {

Scene scene_of(const std::string& source, const std::string& listener) {
    return parse_scene(
               R"({"aula": 1, "sources": [)" + source + R"(], "listener": )" + listener + "}",
               "scene", ".")
        .scene;
}

constexpr const char* kMouth = R"({"position": [0.1, 0, -0.08], "relative_to": "listener"})";

}  // namespace

TEST_CASE("a source relative to the listener is placed and turned in its axes") {
    Scene scene = scene_of(kMouth, R"({"position": [2, 3, 1.6], "yaw_deg": 90, "roll_deg": 10})");
    const auto place = [&] { return scene.sources[0].pose_at(5); };
    // To the front is +y, and the right ear, at +x, is lower by the roll. Rounding: coordinates of
    // some metres in single precision.
    CHECK(glm::distance(place().position, Vec3(2 - 0.08F * glm::sin(glm::radians(10.0F)), 3.1F,
                                               1.6F - 0.08F * glm::cos(glm::radians(10.0F)))) <
          1e-5F);
    CHECK(place().yaw_rad == scene.listener.pose.yaw_rad);
    CHECK(place().roll_rad == scene.listener.pose.roll_rad);
    scene.listener.pose = {{1, 1, 1}, 0, 0, 0};
    scene.attach_sources();
    CHECK(glm::distance(place().position, Vec3(1.1F, 1, 0.92F)) < 1e-5F);
    CHECK(place().yaw_rad == 0);
    // Companion: sources in the world stay.
    const Scene other = scene_of(R"({"position": [0.1, 0, -0.08], "relative_to": "world"})",
                                 R"({"position": [2, 3, 1.6], "yaw_deg": 90})");
    CHECK(other.sources[0].pose_at(0).position == Vec3(0.1F, 0, -0.08F));
}

TEST_CASE("a source relative to the listener follows its path through turns, loops and jumps") {
    const Scene scene = scene_of(kMouth, R"({"path": {"loop": true, "points": [
        {"t": 0, "position": [2, 3, 1.6]},
        {"t": 1, "position": [2, 3, 1.6], "yaw_deg": 360, "pitch_deg": 40},
        {"t": 1, "position": [4, 3, 1.6], "yaw_deg": 90},
        {"t": 3, "position": [4, 5, 1.6], "yaw_deg": 100, "roll_deg": -60}]}})");
    REQUIRE(scene.sources[0].path);
    for (double t = 0; t < 7; t += 0.013) {
        const Pose mouth = scene.sources[0].pose_at(t);
        const Pose head = scene.listener.pose_at(t);
        CAPTURE(t);
        // Arcs as chords of 5 degrees: 0.1 % of 13 cm; in addition rounding.
        CHECK(glm::distance(mouth.position, head.at({0.1F, 0, -0.08F}).position) < 2e-4F);
        CHECK(mouth.yaw_rad == Approx(head.yaw_rad).margin(1e-5));
        CHECK(mouth.pitch_rad == Approx(head.pitch_rad).margin(1e-5));
        CHECK(mouth.roll_rad == Approx(head.roll_rad).margin(1e-5));
    }
    // Companion: straight lines between the points of the path miss the turn by a diameter.
    const Trajectory coarse{
        {{0, scene.sources[0].pose_at(0)}, {0.999, scene.sources[0].pose_at(0.999)}}, false};
    CHECK(glm::distance(coarse.at(0.5).position, scene.sources[0].pose_at(0.5).position) > 0.1F);
}

TEST_CASE("the path of a source on a listener that turns without end has a limited memory") {
    Scene scene = scene_of(kMouth, R"({"position": [0, 0, 0]})");
    scene.listener.path = Trajectory{};
    for (int i = 0; i < 20'000; ++i)
        scene.listener.path->points.push_back(
            {static_cast<double>(i), Pose{{0, 0, 0}, i % 2 == 0 ? 0 : 1e4F, 0, 0}});
    scene.attach_sources();
    CHECK(scene.sources[0].path->points.size() > 1'000'000);  // of 20 million chords
    CHECK(scene.sources[0].path->points.size() < 1'030'000);
}

TEST_CASE("a source relative to the listener has neither a path nor an orientation of its own") {
    const auto refused = [](const std::string& members, const std::string& message) {
        CHECK_THROWS_WITH(scene_of("{" + members + "}", R"({"position": [0, 0, 0]})"),
                          Catch::Contains(message));
    };
    const std::string relative = R"("relative_to": "listener", )";
    refused(relative + R"("position": [0, 0, 0], "yaw_deg": 10)",
            "/sources/0/yaw_deg: a source relative to the listener moves and turns with it; "
            "expected a position alone");
    refused(relative + R"("path": {"points": [{"t": 0, "position": [0, 0, 0]}]})",
            "/sources/0/path: a source relative to the listener");
    refused(R"("position": [0, 0, 0], "relative_to": "head")",
            R"(/sources/0/relative_to: "head"; expected "world" or "listener")");
    refused(R"("position": [0, 0, 0], "relative_to": 1)", "/sources/0/relative_to");
}

}  // namespace attached_source_test
