#include "aula/engine/scene_file.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "aula/engine/material_library.h"
#include "aula/exception.h"
#include "tests/support/temporary_folder.h"

using aula::Scene;
using aula::Vec3;

namespace {

// A scene with some members of the top object.
std::string scene_text(const std::string& members) {
    return R"({"aula": 1, "sources": [{"position": [1, 1, 1]}], "listener": {"position": [2, 1, 1]}, )" +
           members + "}";
}

Scene load(const std::string& text) {
    const aula::test::TemporaryFolder folder;
    return aula::load_scene(folder.write("scene.json", text)).scene;
}

std::vector<std::string> warnings(const std::string& text) {
    const aula::test::TemporaryFolder folder;
    return aula::load_scene(folder.write("scene.json", text)).warnings;
}

float area(const aula::Object& object) {
    float sum = 0;
    for (const auto& [a, b, c] : object.triangles) {
        const auto& v = object.vertices;
        sum += glm::length(glm::cross(v[b] - v[a], v[c] - v[a])) / 2;
    }
    return sum;
}

}  // namespace

TEST_CASE("every key of a scene file is read") {
    const aula::test::TemporaryFolder folder;
    folder.write("voice.wav", "");
    const std::string band = "[[0,0,0,0],[3,0,-3,0],[0,0,0,0]]";
    folder.write("horn.json", R"({"aula_directivity": 1, "source": "estimated", "level_db": [)" +
                                  band + "," + band + "," + band + "," + band + "," + band + "," +
                                  band + "," + band + "," + band + "]}");
    const auto file = folder.write("scene.json", R"({
        // comments of both kinds
        "aula": 1, /* are allowed */
        "geometry": [
            {"name": "room", "box": [10, 8, 3.5], "min": [-1, 0, 0], "material": "wall"},
            {"name": "door", "vertices": [[0,0,0],[1,0,0],[1,0,2],[0,0,2]], "faces": [[0,1,2,3]],
             "material": "wood", "translate": [1, 2, 0],
             "path": {"points": [{"t": 0, "position": [0,0,0], "yaw_deg": 0},
                                 {"t": 2, "position": [0,0,0], "yaw_deg": 90}]}}
        ],
        "materials": {"wall": {"absorption": [0,0.1,0.2,0.3,0.4,0.5,0.6,1], "scattering": 0.25}},
        "medium": {"temperature_c": 10, "humidity_percent": 30, "pressure_kpa": 90,
                   "air_absorption": false},
        "sources": [
            {"name": "voice", "position": [2, 2, 1.5], "signal": "voice.wav", "gain_db": -6,
             "loop": true, "path": {"loop": true, "points": [
                {"t": 0, "position": [2,2,1.5]},
                {"t": 4, "position": [6,2,1.5], "yaw_deg": 40}]}},
            {"name": "hiss", "position": [3, 3, 1], "signal": "noise", "directivity": "cardioid",
             "yaw_deg": 90, "pitch_deg": -10, "roll_deg": 5},
            {"name": "click", "position": [4, 3, 1], "signal": "impulse",
             "directivity": "horn.json"}
        ],
        "listener": {"position": [8, 5, 1.7], "yaw_deg": 180, "pitch_deg": 10, "roll_deg": -20},
        "simulation": {"estimator": "dpc-published", "rays": 500, "order": 20,
            "response_time_s": 0.25, "patch_size_m": 0.75, "listener_radius_m": 0.3,
            "frame_rate_hz": 60, "ir_length_s": 1.5, "seed": 18446744073709551615, "threads": 2,
            "memory_mb": 64, "direct": false, "diffraction_order": 3, "specular_order": 0, "specular": false},
        "expect": {"T30": [1, null, {"anything": true}]}
    })");
    const auto [scene, warnings, guesses, json] = aula::load_scene(file);
    CHECK(guesses.empty());
    CHECK(warnings.empty());
    CHECK(scene.simulation.rays);

    REQUIRE(scene.objects.size() == 2);
    const aula::Object& room = scene.objects[0];
    CHECK(room.name == "room");
    CHECK(room.triangles.size() == 12);
    CHECK(area(room) == Approx(2 * (80 + 35 + 28)));
    const aula::Object& door = scene.objects[1];
    CHECK(door.translation == Vec3(1, 2, 0));
    REQUIRE(door.path.has_value());
    CHECK(glm::distance(door.world_vertices(2)[1], Vec3(1, 3, 0)) < 1e-5F);

    const aula::Material& wall = scene.materials[room.triangle_materials[0]];
    CHECK(wall.name == "wall");
    CHECK(wall.absorption.value == std::array<float, 8>{0, .1F, .2F, .3F, .4F, .5F, .6F, 1});
    CHECK(wall.scattering == aula::Bands::filled(0.25F));
    CHECK(scene.materials[door.triangle_materials[0]].name == "wood");

    CHECK(scene.medium.temperature_c == 10);
    CHECK(scene.medium.humidity_percent == 30);
    CHECK(scene.medium.pressure_kpa == 90);
    CHECK_FALSE(scene.medium.air_absorption);

    REQUIRE(scene.sources.size() == 3);
    const aula::Source& voice = scene.sources[0];
    CHECK(voice.name == "voice");
    CHECK(voice.signal == aula::Source::Signal::file);
    CHECK(voice.signal_file == folder.path() / "voice.wav");
    CHECK(voice.gain_db == -6);
    CHECK(voice.loop);
    CHECK(voice.position_at(5) == Vec3(3, 2, 1.5));
    CHECK(voice.pose_at(5).yaw_rad == Approx(glm::radians(10.0)));
    CHECK(voice.directivity.is_omnidirectional());
    const aula::Pose hiss = scene.sources[1].pose_at(5);
    CHECK(hiss.position == Vec3(3, 3, 1));
    CHECK(hiss.yaw_rad == glm::radians(90.0F));
    CHECK(hiss.pitch_rad == glm::radians(-10.0F));
    CHECK(hiss.roll_rad == glm::radians(5.0F));
    CHECK(scene.sources[1].directivity.factor({1, 0, 0})[0] == Approx(3));
    CHECK(scene.sources[1].directivity_file.empty());
    const aula::Directivity& horn = scene.sources[2].directivity;
    CHECK(horn.factor({1, 0, 0})[3] / horn.factor({0, 1, 0})[3] == Approx(1.9953).epsilon(1e-4));
    CHECK(scene.sources[2].directivity_file == folder.path() / "horn.json");
    CHECK(scene.sources[1].signal == aula::Source::Signal::noise);
    CHECK_FALSE(scene.sources[1].loop);
    CHECK(scene.sources[2].signal == aula::Source::Signal::impulse);

    const aula::Pose pose = scene.listener.pose_at(3);
    CHECK(pose.position == Vec3(8, 5, 1.7));
    CHECK(pose.yaw_rad == glm::radians(180.0F));
    CHECK(pose.pitch_rad == glm::radians(10.0F));
    CHECK(pose.roll_rad == glm::radians(-20.0F));

    const aula::Simulation& s = scene.simulation;
    CHECK(s.estimator == aula::Estimator::dpc_published);
    CHECK(s.rays == 500);
    CHECK(s.order == 20);
    CHECK(s.response_time_s == 0.25F);
    CHECK(s.patch_size_m == 0.75F);
    CHECK(s.listener_radius_m == 0.3F);
    CHECK(s.frame_rate_hz == 60);
    CHECK(s.ir_length_s == 1.5F);
    CHECK(s.seed == 18446744073709551615U);
    CHECK(s.threads == 2);
    CHECK(s.memory_mb == 64);
    CHECK_FALSE(s.direct);
    CHECK(s.diffraction_order == 3);
    CHECK(s.specular_order == 0);
    CHECK_FALSE(s.specular);
}

TEST_CASE("a scene of one source and a listener is free field with all defaults") {
    const Scene scene = load(
        R"({"aula": 1, "sources": [{"position": [0, 0, 0]}], "listener": {"position": [1, 0, 0]}})");
    CHECK(scene.objects.empty());
    CHECK(scene.sources[0].name == "source1");
    CHECK(scene.sources[0].signal == aula::Source::Signal::impulse);
    CHECK(scene.medium.temperature_c == 20);
    CHECK(scene.medium.air_absorption);
    CHECK(scene.simulation.estimator == aula::Estimator::patch);
    CHECK_FALSE(scene.simulation.rays.has_value());
    CHECK_FALSE(scene.simulation.ir_length_s.has_value());
    CHECK_FALSE(scene.simulation.threads.has_value());
}

TEST_CASE("a length of the responses \"auto\" is left to the room") {
    const Scene scene = load(
        R"({"aula": 1, "sources": [{"position": [0, 0, 0]}], "listener": {"position": [1, 0, 0]},
            "simulation": {"ir_length_s": "auto"}})");
    CHECK_FALSE(scene.simulation.ir_length_s.has_value());
}

TEST_CASE("scattering is 0.1 where a material does not state it") {
    const Scene scene = load(scene_text(R"("materials": {"a": {"absorption": 0.3}})"));
    CHECK(scene.materials.at(0).absorption == aula::Bands::filled(0.3F));
    CHECK(scene.materials.at(0).scattering == aula::Bands::filled(0.1F));
}

TEST_CASE("a material is like another one where it gives no values") {
    const Scene scene = load(scene_text(R"("materials": {"door": {"absorption": [0.3,0.3,0.2,0.2,
            0.1,0.1,0.1,0.1], "scattering": 0.2, "sound_reduction_db": 30},
        "shelves": {"like": "door", "scattering": 0.5},
        "wall": {"like": "gypsum_board", "scattering": 0.3},
        "hard": {"scattering": 0.4, "absorption": 0.01, "like": "shelves"}})"));
    const aula::Material& door = scene.find_material("door");
    const aula::Material& shelves = scene.find_material("shelves");
    CHECK(shelves.absorption == door.absorption);
    CHECK(shelves.sound_reduction_db == door.sound_reduction_db);
    CHECK(shelves.scattering == aula::Bands::filled(0.5F));
    CHECK(scene.find_material("hard").absorption == aula::Bands::filled(0.01F));
    CHECK(scene.find_material("hard").sound_reduction_db == door.sound_reduction_db);
    const auto library = aula::material_library();
    const auto board = std::find_if(library.begin(), library.end(), [](const auto& entry) {
        return entry.material.name == "gypsum_board";
    });
    CHECK(scene.find_material("wall").absorption == board->material.absorption);
    // The scene has the materials that it names, no others.
    CHECK(std::none_of(scene.materials.begin(), scene.materials.end(),
                       [](const auto& material) { return material.name == "gypsum_board"; }));
}

TEST_CASE("a material is like one of the library, or one before it") {
    const auto error = [](const std::string& materials) {
        try {
            load(scene_text(R"("materials": {)" + materials + "}"));
        } catch (const aula::InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    CHECK(error(R"("a": {"like": "plastr"})").find("did you mean \"plaster\"") !=
          std::string::npos);
    CHECK(error(R"("a": {"like": "b"}, "b": {"absorption": 0.1})").find("/materials/a/like") !=
          std::string::npos);
    // It transmits more than it absorbs.
    CHECK(error(R"("a": {"absorption": 0.2, "sound_reduction_db": 10},
                   "b": {"like": "a", "absorption": 0.01})")
              .find("/materials/b/absorption") != std::string::npos);
    CHECK(error(R"("a": {"absorption": 1, "sound_reduction_db": [20,20,20,1,20,20,20,20]},
                   "b": {"like": "a", "absorption": 0.1})")
              .find("/materials/b/absorption") != std::string::npos);
}

TEST_CASE("walls are opaque unless a sound reduction is stated, for all bands or for each") {
    const Scene scene = load(scene_text(R"("materials": {"wall": {"absorption": 0.3},
        "pane": {"absorption": 0.2, "sound_reduction_db": 20},
        "door": {"absorption": 1, "sound_reduction_db": [120,40,30,20,20.5,12,11,0]}},
        "simulation": {"transmission": false})"));
    const aula::Material& pane = scene.find_material("pane");
    CHECK_FALSE(scene.find_material("wall").sound_reduction_db);
    CHECK(pane.sound_reduction_db == aula::Bands::filled(20));
    CHECK(scene.find_material("door").sound_reduction_db ==
          aula::Bands{{120, 40, 30, 20, 20.5F, 12, 11, 0}});
    CHECK(scene.find_material("wall").transmission() == aula::Bands{});
    CHECK(pane.transmission() == aula::Bands::filled(0.01F));
    CHECK_FALSE(scene.simulation.transmission);
    CHECK(aula::Simulation{}.transmission);
}

TEST_CASE("a scene's material takes precedence over the library's of the same name") {
    const Scene scene = load(scene_text(
        R"("materials": {"wood": {"absorption": 0.77}}, "geometry": [{"box": [9,9,9], "material": "wood"}])"));
    CHECK(scene.materials.size() == 1);
    CHECK(scene.materials[0].absorption == aula::Bands::filled(0.77F));
}

TEST_CASE("the walls of a box face inwards") {
    const Scene scene = load(scene_text(R"("geometry": [{"box": [4, 6, 8], "material": "wood"}])"));
    const aula::Object& box = scene.objects.at(0);
    for (const auto& [a, b, c] : box.triangles) {
        const auto& v = box.vertices;
        const Vec3 normal = glm::cross(v[b] - v[a], v[c] - v[a]);
        CHECK(glm::dot(normal, Vec3(2, 3, 4) - v[a]) > 0);
    }
}

TEST_CASE("up is applied before scale, and both before translation") {
    const Scene scene = load(scene_text(
        R"("geometry": [{"vertices": [[1,2,3],[0,0,0],[1,0,0]], "faces": [[0,1,2]],
            "material": "wood", "up": "y", "scale": 10, "translate": [100, 0, 0]}])"));
    CHECK(scene.objects.at(0).vertices[0] == Vec3(10, -30, 20));
    CHECK(scene.objects.at(0).world_vertices(0)[0] == Vec3(110, -30, 20));
}

TEST_CASE("polygon faces become triangles that cover them and face the same side") {
    const Scene scene = load(scene_text(
        R"("geometry": [{"vertices": [[0,0,0],[2,0,0],[2,2,0],[1,0.5,0],[0,2,0]],
            "faces": [[0,1,2,3,4]], "material": "wood"}])"));
    CHECK(scene.objects.at(0).triangles.size() == 3);
    CHECK(scene.objects.at(0).triangle_materials.size() == 3);
    CHECK(area(scene.objects.at(0)) == Approx(4 - 1.5));
    // The corners are in counter-clockwise order seen from above.
    for (const auto& [a, b, c] : scene.objects.at(0).triangles) {
        const auto& v = scene.objects.at(0).vertices;
        CHECK(glm::cross(v[b] - v[a], v[c] - v[a]).z > 0);
    }
}

TEST_CASE("without a position the start of the path is used") {
    const Scene scene = load(R"({"aula": 1,
        "sources": [{"path": {"points": [{"t": 0, "position": [1,2,3]},
                                         {"t": 1, "position": [7,7,7]}]}}],
        "listener": {"path": {"points": [{"t": 0, "position": [4,5,6]}]}}})");
    CHECK(scene.sources[0].position == Vec3(1, 2, 3));
    CHECK(scene.listener.pose.position == Vec3(4, 5, 6));
}

TEST_CASE("a source or a listener outside the geometry causes a warning with its position") {
    const auto lines = warnings(
        R"({"aula": 1, "geometry": [{"box": [4, 4, 3], "material": "wood"}],
            "sources": [{"name": "in", "position": [1, 1, 1]}, {"name": "out", "position": [1, 1, 9]}],
            "listener": {"path": {"points": [{"t": 0, "position": [1,1,1]},
                                             {"t": 1, "position": [1,-1,1]}]}}})");
    REQUIRE(lines.size() == 2);
    CHECK(lines[0].find("scene.json: /sources/1: the source \"out\" is outside") !=
          std::string::npos);
    CHECK(lines[1].find("scene.json: /listener: the listener is outside the geometry at "
                        "(1, -1, 1)") != std::string::npos);
}

TEST_CASE("bounds include moving geometry, and free field has none") {
    CHECK(warnings(R"({"aula": 1, "geometry": [{"box": [4, 4, 3], "material": "wood",
            "path": {"points": [{"t": 0, "position": [0,0,0]}, {"t": 9, "position": [50,0,0]}]}}],
            "sources": [{"position": [1, 1, 1]}], "listener": {"position": [51, 1, 1]}})")
              .empty());
    CHECK(warnings(scene_text(R"("expect": 0)")).empty());
}

TEST_CASE("surfaces change the material of their triangles, including the first and the last") {
    const Scene scene = load(scene_text(R"("materials": {"wall": {"absorption": 0.1},
        "pane": {"absorption": 0.2}, "felt": {"absorption": 0.9}},
        "geometry": [{"box": [4, 3, 2], "material": "wall", "surfaces": [
            {"material": "pane", "triangles": [[0, 0], [4, 6]]},
            {"material": "felt", "triangles": [[6, 7], [11, 11]]}]}])"));
    std::vector<std::string> names;
    for (const std::uint32_t m : scene.objects[0].triangle_materials)
        names.push_back(scene.materials[m].name);
    CHECK(names == std::vector<std::string>{"pane", "wall", "wall", "wall", "pane", "pane", "felt",
                                            "felt", "wall", "wall", "wall", "felt"});
}
