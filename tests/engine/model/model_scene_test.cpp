#include "engine/model/model_scene.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "engine/mesh/mesh_import.h"
#include "engine/model/standing_places.h"
#include "engine/rays/ray_scene.h"
#include "tests/engine/mesh/square_gltf.h"
#include "tests/support/cpu_time.h"
#include "tests/support/temporary_folder.h"

using namespace aula;
using namespace aula::test;
using Catch::Contains;
using Json = nlohmann::json;

namespace {

/// A box as OBJ, each of its faces with a material. The extents are along the axes of the file.
std::string box_obj(double x, double y, double z, const std::vector<std::string>& materials) {
    std::ostringstream text;
    for (int corner = 0; corner < 8; ++corner) {
        text << "v " << ((corner & 1) != 0 ? x : 0) << ' ' << ((corner & 2) != 0 ? y : 0) << ' '
             << ((corner & 4) != 0 ? z : 0) << '\n';
    }
    // Low and high faces across x, y and z.
    const char* const faces[6] = {"1 3 7 5", "2 6 8 4", "1 5 6 2", "3 4 8 7", "1 2 4 3", "5 7 8 6"};
    for (std::size_t f = 0; f < 6; ++f)
        text << "usemtl " << materials[f % materials.size()] << "\nf " << faces[f] << '\n';
    return text.str();
}

Bounds bounds_of(const Scene& scene) { return geometry_bounds(scene.objects); }

/// Whether a point is inside the bounds and at least so far from them.
bool is_inside(const Bounds& bounds, const Vec3& point, float margin_m) {
    return bounds.contains(point - Vec3(margin_m)) && bounds.contains(point + Vec3(margin_m));
}

bool has_guess(const LoadedScene& loaded, const std::string& part) {
    return std::any_of(loaded.warnings.begin(), loaded.warnings.end(),
                       [&](const std::string& line) {
                           return line.find(": guessed ") != std::string::npos &&
                                  line.find(part) != std::string::npos;
                       });
}

}  // namespace

TEST_CASE("A room in metres opens, with people standing in it who see each other") {
    const TemporaryFolder folder;
    const auto file = folder.write(
        "room.obj", box_obj(8, 6, 3, {"Wall", "Wall", "Wall", "Wall", "Carpet.001", "Ceiling"}));
    const LoadedScene loaded = load_scene(file);
    const Scene& scene = loaded.scene;
    const Bounds bounds = bounds_of(scene);
    CHECK(bounds.max == Vec3(8, 6, 3));
    REQUIRE(scene.sources.size() == 1);
    const Vec3 source = scene.sources[0].position_at(0);
    const Vec3 listener = scene.listener.pose_at(0).position;
    for (const Vec3& place : {source, listener}) {
        CHECK(is_inside(bounds, place, 0.5F));
        CHECK(place.z == Approx(1.6).margin(1e-3));
    }
    CHECK(glm::distance(source, listener) > 2);
    // The listener looks at the source.
    const glm::mat3 head = scene.listener.pose_at(0).rotation();
    CHECK(glm::dot(head[0], glm::normalize(source - listener)) > 0.99F);
    std::vector<std::string> names;
    for (const Material& material : scene.materials) names.push_back(material.name);
    CHECK(names == std::vector<std::string>{"plaster", "carpet"});
    // "Carpet.001" is a copy of "carpet", which the library has: no guess.
    CHECK(has_guess(loaded, "material \"Wall\": plaster, \"wall\" is in its name"));
    CHECK_FALSE(has_guess(loaded, "Carpet"));
    CHECK(has_guess(loaded, "source \"clap\""));
    CHECK(has_guess(loaded, "listener at"));
    CHECK_FALSE(has_guess(loaded, "up:"));
    CHECK_FALSE(has_guess(loaded, "unit:"));
}

TEST_CASE("Units and the vertical axis are guessed from the size, and from floors and ceilings") {
    const TemporaryFolder folder;
    const std::vector<std::string> plain{"a"};
    // Floor and ceiling across y though the room is higher than deep: a shaft.
    const std::vector<std::string> named{"a", "a", "floor", "ceiling", "a", "a"};
    struct Case {
        std::string obj;
        Vec3 size_m;
    };
    const std::vector<Case> cases{{box_obj(18, 12, 4.8, plain), {18, 12, 4.8F}},
                                  {box_obj(18, 4.8, 12, plain), {18, 12, 4.8F}},
                                  {box_obj(18000, 4800, 12000, plain), {18, 12, 4.8F}},
                                  {box_obj(18000, 12000, 4800, plain), {18, 12, 4.8F}},
                                  {box_obj(500, 400, 270, plain), {5, 4, 2.7F}},
                                  {box_obj(240, 180, 100, plain), {6.096F, 4.572F, 2.54F}},
                                  {box_obj(6, 9, 5, named), {6, 5, 9}},
                                  // A large hall in metres, and a flat yard.
                                  {box_obj(120, 80, 30, plain), {120, 80, 30}},
                                  {box_obj(20, 20, 0.5, plain), {20, 20, 0.5F}}};
    for (const Case& room : cases) {
        const Bounds bounds = bounds_of(load_scene(folder.write("room.obj", room.obj)).scene);
        const Vec3 size = bounds.max - bounds.min;
        CAPTURE(room.size_m.x, room.size_m.y, room.size_m.z, size.x, size.y, size.z);
        CHECK(glm::distance(size, room.size_m) < 1e-3F);
    }
    // Nothing says: a corridor, and a cube.
    for (const auto& room : {box_obj(12, 3, 3, plain), box_obj(4, 4, 4, plain)})
        CHECK(has_guess(load_scene(folder.write("room.obj", room)), "up: z, neither names"));
}

TEST_CASE("What the user knows replaces the guess") {
    const TemporaryFolder folder;
    const auto file = folder.write("room.obj", box_obj(18000, 4800, 12000, {"a"}));
    const auto geometry_of = [&](const ModelOptions& options) {
        const ModelScene model = scene_of_model(file, folder.path(), options);
        for (const std::string& guess : model.guesses) {
            CHECK(guess.starts_with("up:") == !options.y_is_up);
            CHECK(guess.starts_with("unit:") == !options.scale);
        }
        for (const JsonMember& member : std::get<JsonValue::Object>(model.json.value)) {
            if (member.key != "geometry") continue;
            std::string keys;
            const auto& objects = std::get<JsonValue::Array>(member.value.value);
            for (const JsonMember& key : std::get<JsonValue::Object>(objects[0].value)) {
                keys += key.key + " ";
                if (key.key == "scale")
                    CHECK(std::get<double>(key.value.value) == options.scale.value_or(0.001));
            }
            return keys;
        }
        return std::string();
    };
    CHECK(geometry_of({.scale = 0.002, .y_is_up = true}) == "file up scale materials ");
    CHECK(geometry_of({.scale = 1, .y_is_up = false}) == "file materials ");
}

TEST_CASE("glTF gives materials, sources, their sounds and the listener") {
    const TemporaryFolder folder;
    folder.write("square.bin", square_bytes());
    folder.write("voice.wav", "RIFF");
    Json model = square_gltf();
    model["materials"] = Json::parse(R"([{"name": "Panel", "extras":
        {"absorption": 0.5, "scattering": [0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.2], "other": 1}}])");
    model["meshes"][0]["primitives"][0]["material"] = 0;
    const auto add_node = [&](const char* text) {
        const auto index = model["nodes"].size();
        model["nodes"].push_back(Json::parse(text));
        model["scenes"][0]["nodes"].push_back(index);
    };
    add_node(R"({"name": "Speaker_Left", "translation": [1, 2, 3]})");
    add_node(R"({"name": "voice", "translation": [4, 1.5, -2],
                 "extensions": {"KHR_audio_emitter": {"emitter": 0}}})");
    add_node(R"({"name": "Camera", "translation": [0, 1.7, 0], "camera": 0})");
    add_node(R"({"name": "Listener", "translation": [2, 1.6, 0], "rotation": [0, 1, 0, 0]})");
    model["extensions"]["KHR_audio_emitter"] = Json::parse(R"({
        "emitters": [{"type": "positional", "gain": 0.5, "sources": [0]}],
        "sources": [{"audio": 0, "loop": true}],
        "audio": [{"uri": "voice.wav"}]})");
    const auto file = folder.write("room.gltf", model.dump());
    const LoadedScene loaded = load_scene(file, SignalFiles::optional);
    const Scene& scene = loaded.scene;
    REQUIRE(scene.materials.size() == 1);
    CHECK(scene.materials[0].name == "Panel");
    CHECK(scene.materials[0].absorption[3] == 0.5F);
    CHECK(scene.materials[0].scattering[7] == 0.2F);
    REQUIRE(scene.sources.size() == 2);
    // y is up in glTF: (x, y, z) -> (x, -z, y).
    CHECK(scene.sources[0].name == "Speaker_Left");
    CHECK(scene.sources[0].position_at(0) == Vec3(1, -3, 2));
    CHECK(scene.sources[0].signal == Source::Signal::impulse);
    CHECK(scene.sources[1].name == "voice");
    CHECK(glm::distance(scene.sources[1].position_at(0), Vec3(4, 2, 1.5F)) < 1e-6F);
    CHECK(scene.sources[1].signal == Source::Signal::file);
    CHECK(scene.sources[1].signal_file == folder.path() / "voice.wav");
    CHECK(scene.sources[1].loop);
    CHECK(scene.sources[1].gain_db == Approx(-6.02).margin(0.01));
    // The node of that name precedes the camera. It is turned to -z, which is +y.
    const Pose listener = scene.listener.pose_at(0);
    CHECK(glm::distance(listener.position, Vec3(2, 0, 1.6F)) < 1e-6F);
    CHECK(glm::distance(listener.rotation()[0], Vec3(0, 1, 0)) < 1e-3F);
    for (const char* const part : {"source", "listener", "material"})
        CHECK_FALSE(has_guess(loaded, part));

    // Without the listener's node the camera hears, along its own -z.
    model["nodes"].back()["name"] = "Empty";
    const Pose camera = load_scene(folder.write("camera.gltf", model.dump()), SignalFiles::optional)
                            .scene.listener.pose_at(0);
    CHECK(glm::distance(camera.position, Vec3(0, 0, 1.7F)) < 1e-6F);
    CHECK(glm::distance(camera.rotation()[0], Vec3(0, 1, 0)) < 1e-3F);

    // Words of other languages are guesses. The light is none.
    Json named_places = model;
    for (const char* const node :
         {R"({"name": "Lautsprecher links", "translation": [1, 2, 4]})",
          R"({"name": "Hörer", "translation": [2, 1.5, 0]})",
          R"({"name": "Light source", "extensions": {"KHR_lights_punctual": {"light": 0}}})"}) {
        named_places["scenes"][0]["nodes"].push_back(named_places["nodes"].size());
        named_places["nodes"].push_back(Json::parse(node));
    }
    const LoadedScene german =
        load_scene(folder.write("german.gltf", named_places.dump()), SignalFiles::optional);
    REQUIRE(german.scene.sources.size() == 3);
    CHECK(german.scene.sources[2].name == "Lautsprecher links");
    CHECK(has_guess(german,
                    "source \"Lautsprecher links\" at (1.00, -4.00, 2.00): "
                    "\"lautsprecher\" is in its name"));
    CHECK(has_guess(german, "listener \"Hörer\" at (2.00, 0.00, 1.50): \"horer\" is in its name"));
    CHECK_FALSE(has_guess(german, "Speaker_Left"));

    // A modelled loudspeaker is none, and is named where nothing else is a source.
    Json shapes = model;
    for (Json& node : shapes["nodes"]) {
        node["name"] = node.contains("mesh") ? "Lautsprecher links" : "Empty";
        node.erase("extensions");
    }
    const LoadedScene modelled =
        load_scene(folder.write("shapes.gltf", shapes.dump()), SignalFiles::optional);
    CHECK(modelled.scene.sources[0].name == "clap");
    CHECK(has_guess(modelled, "shape \"Lautsprecher links\""));
    CHECK_FALSE(has_guess(german, "shape"));

    // Each sound of an emitter is a source. URIs have no spaces.
    folder.write("two words.wav", "OggS");
    Json several = model;
    auto& audio = several["extensions"]["KHR_audio_emitter"];
    audio["emitters"][0]["sources"] = {0, 1, 2};
    audio["sources"] = Json::parse(R"([{"audio": 0}, {"audio": 1, "gain": 2}, {"audio": 2}])");
    audio["audio"] =
        Json::parse(R"([{"uri": "two%20words.wav"}, {"uri": "voice.wav"}, {"bufferView": 0}])");
    const LoadedScene many =
        load_scene(folder.write("several.gltf", several.dump()), SignalFiles::optional);
    REQUIRE(many.scene.sources.size() == 4);
    CHECK(many.scene.sources[1].signal_file == folder.path() / "two words.wav");
    CHECK(many.scene.sources[2].name == "voice 2");
    CHECK(many.scene.sources[2].position == many.scene.sources[1].position);
    CHECK(many.scene.sources[2].gain_db == Approx(0).margin(0.01));
    // The buffer view has the corners of the square.
    CHECK(many.scene.sources[3].signal == Source::Signal::impulse);
    CHECK(has_guess(many, "source \"voice\": claps, its sound \"" +
                              (folder.path() / "several.gltf").string() +
                              "#2\" is of a format that is not read; expected"));

    // Sounds in the model: a data URI and a buffer view.
    Json inside = several;
    auto& sounds = inside["extensions"]["KHR_audio_emitter"];
    inside["buffers"].push_back(
        {{"uri", "data:application/octet-stream;base64,AABSSUZGAA=="}, {"byteLength", 7}});
    const auto number = inside["buffers"].size() - 1;
    inside["bufferViews"].push_back({{"buffer", number}, {"byteOffset", 2}, {"byteLength", 5}});
    sounds["audio"] = {{{"uri", "data:audio/mpeg;base64,SUQzBAA="}, {"mimeType", "audio/mpeg"}},
                       {{"bufferView", inside["bufferViews"].size() - 1}},
                       {{"uri", "data:audio/mp4;base64,AAAAIGZ0eXA="}, {"mimeType", "audio/mp4"}}};
    inside["scenes"][0]["extensions"]["KHR_audio_emitter"]["emitters"] = {0};
    const auto file_inside = folder.write("inside.gltf", inside.dump());
    const LoadedScene carried = load_scene(file_inside);
    REQUIRE(carried.scene.sources.size() == 4);
    CHECK(carried.scene.sources[1].signal_file == folder.path() / "inside.gltf#0");
    CHECK(SoundInModel::of_name(carried.scene.sources[1].signal_file).value().read() ==
          std::string("ID3\x04\0", 5));
    CHECK(SoundInModel::of_name(carried.scene.sources[2].signal_file).value().read() ==
          std::string("RIFF\0", 5));
    CHECK(carried.scene.sources[3].signal == Source::Signal::impulse);
    CHECK(has_guess(carried, "sounds: without 1 global emitter"));
    CHECK(has_guess(carried, "inside.gltf#2\" of the type \"audio/mp4\" is of a format"));
    for (const char* const name :
         {"inside.gltf", "a.wav#0", "inside.gltf#", "inside.gltf#x", "inside.gltf#-1"})
        CHECK_FALSE(SoundInModel::of_name(name));
    CHECK_THROWS_WITH(
        (SoundInModel{file_inside, 3}.read()),
        Contains("inside.gltf#3: ") && Contains("has no sound 3; expected a number below 3"));

    // A name of the library, a sound that is missing, and a coefficient that is none.
    std::filesystem::remove(folder.path() / "voice.wav");
    model["materials"][0]["extras"] = {{"aula_material", "brick"}};
    const LoadedScene named = load_scene(folder.write("named.gltf", model.dump()));
    CHECK(named.scene.materials[0].name == "brick");
    CHECK(has_guess(named, "source \"voice\": claps"));
    model["materials"][0]["extras"] = {{"absorption", 3}};
    CHECK_THROWS_WITH(
        load_scene(folder.write("wrong.gltf", model.dump())),
        Contains("wrong.gltf: /materials/Panel/absorption: 3") && Contains("expected"));
}

TEST_CASE("A model with many sounds inside is read once") {
    const TemporaryFolder folder;
    folder.write("square.bin", square_bytes());
    const auto cpu_s = [&](std::size_t sounds) {
        Json model = square_gltf();
        Json& audio = model["extensions"]["KHR_audio_emitter"];
        for (std::size_t i = 0; i < sounds; ++i) {
            // AU of little endian: "dns.", then zeros.
            audio["audio"].push_back({{"uri", "data:;base64,ZG5zLgAA" + std::string(8000, 'A')}});
            audio["sources"].push_back({{"audio", i}});
            audio["emitters"].push_back({{"type", "positional"}, {"sources", {i}}});
            model["scenes"][0]["nodes"].push_back(model["nodes"].size());
            model["nodes"].push_back(
                {{"name", "bell"}, {"extensions", {{"KHR_audio_emitter", {{"emitter", i}}}}}});
        }
        const auto file = folder.write("bells.gltf", model.dump());
        CHECK(import_mesh(file).sounds_inside.size() == sounds);
        return test::cpu_time_s([&] {
            const ModelScene scene = scene_of_model(file, folder.path(), {});
            CHECK(std::none_of(scene.guesses.begin(), scene.guesses.end(), [](const auto& line) {
                return line.find("claps") != std::string::npos;
            }));
        });
    };
    // Ten times as long for ten times the sounds; reading the model for each takes 50 s, a hundred
    // times as long.
    CHECK(cpu_s(500) < 40 * std::min(cpu_s(50), cpu_s(50)));
}

TEST_CASE("Of several scenes of a glTF file the chosen one is read, else the first with faces") {
    const TemporaryFolder folder;
    folder.write("square.bin", square_bytes());
    Json model = square_gltf();
    model["nodes"].push_back({{"name", "Speaker"}});
    model["scenes"] = {{{"name", "Yard"}, {"nodes", {model["nodes"].size() - 1}}},
                       {{"name", "Hall"}, {"nodes", model["scenes"][0]["nodes"]}}};
    model.erase("scene");
    const LoadedScene hall = load_scene(folder.write("hall.gltf", model.dump()));
    CHECK(has_guess(hall, "scene: \"Hall\", one of 2 in the file"));
    CHECK(hall.scene.sources[0].name == "clap");
    model["scene"] = 1;
    CHECK(has_guess(load_scene(folder.write("hall.gltf", model.dump())), "scene: \"Hall\""));
    model["scene"] = 0;
    CHECK_THROWS_WITH(load_scene(folder.write("yard.gltf", model.dump())),
                      Contains("/scene: scene 0 of 2 holds no triangle; expected"));
    // Lines are no faces. Sharing the Yard's node, the Hall has its speaker.
    model.erase("scene");
    model["meshes"].push_back(model["meshes"][0]);
    model["meshes"][1]["primitives"][0]["mode"] = 1;
    model["nodes"].push_back({{"mesh", 1}});
    model["scenes"][0]["nodes"].push_back(model["nodes"].size() - 1);
    model["scenes"][1]["nodes"].push_back(model["nodes"].size() - 2);
    const LoadedScene shared = load_scene(folder.write("shared.gltf", model.dump()));
    CHECK(has_guess(shared, "scene: \"Hall\""));
    CHECK(shared.scene.sources[0].name == "Speaker");
}

TEST_CASE("Nodes that many scenes of a glTF file share are searched once") {
    const TemporaryFolder folder;
    folder.write("square.bin", square_bytes());
    const auto cpu_s = [&](std::size_t scenes) {
        Json model = square_gltf();
        // Scenes of one node each, above all others.
        constexpr std::size_t kNodes = 10'000;
        Json children = Json::array();
        for (std::size_t n = 1; n <= kNodes; ++n) children.push_back(n);
        for (std::size_t n = 1; n <= kNodes; ++n) model["nodes"].push_back(Json::object());
        model["nodes"].push_back({{"children", std::move(children)}});
        const Json square = model["scenes"][0];
        model["scenes"] = Json(scenes, Json{{"nodes", {kNodes + 1}}});
        model["scenes"].push_back(square);
        const auto file = folder.write("scenes.gltf", model.dump());
        return test::cpu_time_s([&] { CHECK(import_mesh(file).scene == std::to_string(scenes)); });
    };
    // Searching the nodes of each scene takes 5 s for a thousand.
    CHECK(cpu_s(1000) < 4 * std::min(cpu_s(10), cpu_s(10)));
}

TEST_CASE("Where no room is around, people stand on the ground, or nowhere") {
    const TemporaryFolder folder;
    // Ground with a wall.
    const auto yard = folder.write("yard.obj",
                                   "v 0 0 0\nv 40 0 0\nv 40 30 0\nv 0 30 0\nf 1 2 3 4\n"
                                   "v 15 10 0\nv 25 10 0\nv 25 10 9\nv 15 10 9\nf 5 6 7 8\n");
    const Scene scene = load_scene(yard).scene;
    for (const Vec3& place :
         {scene.sources[0].position_at(0), scene.listener.pose_at(0).position}) {
        CHECK(place.z == Approx(1.6).margin(1e-3));
        CHECK(std::abs(place.y - 10) > 0.4F);
    }
    const auto sheet = folder.write("sheet.obj", "v 0 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 2 3\n");
    const LoadedScene small = load_scene(sheet);
    CHECK(has_guess(small, "which has no place to stand"));
    // They are not at the same point.
    CHECK(small.scene.sources[0].position_at(0) != small.scene.listener.pose_at(0).position);
}

TEST_CASE("People stand on floors, steps and tiers, not on chairs and tables") {
    const TemporaryFolder folder;
    std::string obj = box_obj(8, 6, 3, {"a"});
    std::size_t vertices = 8;
    const auto add_top = [&](double x, double y, double wide, double deep, double z) {
        for (const auto& [dx, dy] : {std::pair{0.0, 0.0}, {wide, 0.0}, {wide, deep}, {0.0, deep}})
            obj += "v " + std::to_string(x + dx) + " " + std::to_string(y + dy) + " " +
                   std::to_string(z) + "\n";
        obj += "f";
        for (std::size_t i = 1; i <= 4; ++i) obj += " " + std::to_string(vertices + i);
        obj += "\n";
        vertices += 4;
    };
    // Chairs in the grid of places, of which every second one is on a chair; a table; tiers.
    for (int x = 0; x < 3; ++x)
        for (int y = 0; y < 4; ++y) add_top(0.55 + x, 1.55 + y, 0.4, 0.4, 0.46);
    add_top(3.6, 2, 1.2, 2.4, 0.74);
    add_top(6, 0, 1, 6, 0.4);
    add_top(7, 0, 1, 6, 0.8);
    const Scene scene = load_scene(folder.write("room.obj", obj)).scene;
    std::set<int> heights_cm;
    for (const Vec3& place : standing_places(RayScene(scene), bounds_of(scene)))
        heights_cm.insert(static_cast<int>(std::lround(100 * place.z)));
    CHECK(heights_cm == std::set{160, 200, 240});
}

TEST_CASE("In a house people stand in its largest room, not in a wall or on the roof") {
    const TemporaryFolder folder;
    // Two rooms of 3 and 9 m with a wall of 0.4 m between, all closed.
    std::string obj = box_obj(3, 5, 2.6, {"Wall"});
    std::string other;
    std::istringstream lines(box_obj(9, 5, 2.6, {"Wall"}));
    for (std::string line; std::getline(lines, line);) {
        double x = 0, y = 0, z = 0;
        int a = 0, b = 0, c = 0, d = 0;
        if (std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z) == 3) {
            other += "v " + std::to_string(x + 3.4) + " " + std::to_string(y) + " " +
                     std::to_string(z) + "\n";
        } else if (std::sscanf(line.c_str(), "f %d %d %d %d", &a, &b, &c, &d) == 4) {
            other += "f " + std::to_string(a + 8) + " " + std::to_string(b + 8) + " " +
                     std::to_string(c + 8) + " " + std::to_string(d + 8) + "\n";
        }
    }
    const Scene scene = load_scene(folder.write("house.obj", obj + other)).scene;
    for (const Vec3& place :
         {scene.sources[0].position_at(0), scene.listener.pose_at(0).position}) {
        CHECK(place.x > 3.9F);
        CHECK(place.x < 11.9F);
        CHECK(place.z == Approx(1.6).margin(1e-3));
    }
}

TEST_CASE("A model far from the origin is read, or refused where single precision ends") {
    const TemporaryFolder folder;
    const auto moved = [&](double by) {
        std::string obj = box_obj(8, 6, 3, {"Wall"});
        std::istringstream lines(obj);
        std::string text;
        for (std::string line; std::getline(lines, line);) {
            double x = 0, y = 0, z = 0;
            text += std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z) == 3
                        ? "v " + std::to_string(x + by) + " " + std::to_string(y) + " " +
                              std::to_string(z) + "\n"
                        : line + "\n";
        }
        return folder.write("far.obj", text);
    };
    const Scene scene = load_scene(moved(500'000)).scene;
    CHECK(is_inside(bounds_of(scene), scene.sources[0].position_at(0), 0.5F));
    // As in a map's coordinates.
    CHECK_THROWS_WITH(load_scene(moved(4'500'000)), Contains("more than 1e6 m from the origin"));
    CHECK_THROWS_WITH(load_scene(moved(1e30)), Contains("far.obj: "));
}

TEST_CASE("A model that cannot be read is one line with its name") {
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(load_scene(folder.path() / "none.glb"),
                      Contains("none.glb: no such file; expected"));
    CHECK_THROWS_WITH(load_scene(folder.write("bad.ply", "ply\n")), Contains("bad.ply: "));
    CHECK(is_mesh_file("A.GLB"));
    CHECK_FALSE(is_mesh_file("scene.json"));
    CHECK_FALSE(is_mesh_file("obj"));
}
