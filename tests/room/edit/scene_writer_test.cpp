#include "apps/room/edit/scene_writer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "apps/output/json_text.h"
#include "apps/room/edit/scene_edits.h"
#include "apps/room/frames/play_controls.h"
#include "aula/engine/material_library.h"
#include "aula/exception.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

using namespace aula;
using namespace aula::test;
namespace fs = std::filesystem;

namespace {

std::vector<fs::path> shipped_scenes() {
    const fs::path scenes = fs::path(AULA_SOURCE_DIR) / "scenes";
    std::vector<fs::path> files;
    for (const fs::path& folder : {scenes, scenes / "reference"})
        for (const auto& entry : fs::directory_iterator(folder))
            if (entry.path().extension() == ".json" && entry.path().stem() != "dataset_manifest")
                files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

/// The materials of all triangles, each by its name and values.
std::string materials_of(const Scene& scene) {
    std::ostringstream text;
    for (const Object& object : scene.objects) {
        for (const std::uint32_t index : object.triangle_materials) {
            const Material& m = scene.materials[index];
            text << m.name;
            for (std::size_t b = 0; b < kBandCount; ++b)
                text << ' ' << m.absorption[b] << ' ' << m.scattering[b] << ' '
                     << (m.sound_reduction_db ? (*m.sound_reduction_db)[b] : -1);
            text << '\n';
        }
    }
    return text.str();
}

void check_same_paths(const std::optional<Trajectory>& a, const std::optional<Trajectory>& b) {
    REQUIRE(a.has_value() == b.has_value());
    if (!a) return;
    CHECK(a->loop == b->loop);
    CHECK(std::equal(a->points.begin(), a->points.end(), b->points.begin(), b->points.end(),
                     [](const auto& p, const auto& q) {
                         return p.time_s == q.time_s && same_pose(p.pose, q.pose);
                     }));
}

/// Exact: numbers keep their digits.
void check_same_scenes(const Scene& a, const Scene& b) {
    CHECK(same_geometry(a, b));
    CHECK(materials_of(a) == materials_of(b));
    REQUIRE(a.sources.size() == b.sources.size());
    for (std::size_t s = 0; s < a.sources.size(); ++s) {
        CHECK(a.sources[s].name == b.sources[s].name);
        CHECK(same_pose(a.sources[s].pose_at(0), b.sources[s].pose_at(0)));
        CHECK(a.sources[s].directivity.on_axis_db() == b.sources[s].directivity.on_axis_db());
        CHECK(a.sources[s].gain_db == b.sources[s].gain_db);
        CHECK(a.sources[s].loop == b.sources[s].loop);
        CHECK(a.sources[s].signal == b.sources[s].signal);
        if (a.sources[s].signal == Source::Signal::file)
            CHECK(fs::equivalent(a.sources[s].signal_file, b.sources[s].signal_file));
        check_same_paths(a.sources[s].path, b.sources[s].path);
    }
    CHECK(same_pose(a.listener.pose, b.listener.pose));
    check_same_paths(a.listener.path, b.listener.path);
    CHECK(a.simulation == b.simulation);
    CHECK(a.medium.temperature_c == b.medium.temperature_c);
    CHECK(a.medium.humidity_percent == b.medium.humidity_percent);
    CHECK(a.medium.air_absorption == b.medium.air_absorption);
    CHECK(a.speech == b.speech);
}

/// A scene file with all kinds of content, in a separate folder.
class Written {
 public:
    /// `files`: names and contents of further files beside it.
    explicit Written(const std::string& text,
                     const std::vector<std::pair<std::string, std::string>>& files = {})
        : file_(folder_.path() / "in" / "scene.json") {
        fs::create_directories(folder_.path() / "in");
        fs::create_directories(folder_.path() / "out" / "deeper");
        for (const auto& [name, content] : files)
            std::ofstream(folder_.path() / "in" / name) << content;
        std::ofstream(file_) << text;
        read_ = load_scene(file_);
    }

    const LoadedScene& read() const { return read_; }
    fs::path folder() const { return file_.parent_path(); }

    /// The edited scene, read from a file in another folder.
    Scene saved(const Scene& edited) const {
        const fs::path file = folder_.path() / "out" / "deeper" / "saved.json";
        write_edited_scene(read_, edited, file_, file);
        return load_scene(file).scene;
    }
    std::string text(const Scene& edited) const {
        return edited_scene_text(read_, edited, folder(), folder());
    }

 private:
    TemporaryFolder folder_;
    fs::path file_;
    LoadedScene read_;
};

constexpr const char* kRoom = R"({
  "aula": 1, // a comment
  "geometry": [
    {"name": "room", "box": [5, 4, 3], "material": "plaster"},
    {"name": "screen", "vertices": [[1, 1, 0], [2, 1, 0], [2, 1, 2], [1, 1, 2]],
     "faces": [[0, 1, 2, 3]], "material": "own", "translate": [0.1, 0, 0],
     "path": {"loop": true, "points": [{"t": 0, "position": [0, 0, 0]},
                                       {"t": 2.5, "position": [0.3, 0, 0], "yaw_deg": 10}]}}
  ],
  "materials": {"own": {"absorption": 0.3, "source": "measured"},
                "curtain": {"absorption": 0.11}},
  "speech": {"level_db": 66, "noise_level_db": [0, 10, 20, 30, 40, 30, 20, 10]},
  "sources": [{"name": "moves", "signal": "noise", "path": {"points": [
                 {"t": 0, "position": [1, 2, 1.5]}, {"t": 3, "position": [4, 2, 1.5]}]}},
              {"name": "rests", "position": [2, 3, 1], "gain_db": -5}],
  "listener": {"path": {"points": [{"t": 0, "position": [4, 3, 1.6], "yaw_deg": 180},
                                   {"t": 4, "position": [1, 3, 1.6], "yaw_deg": 180}]}},
  "simulation": {"rays": 300},
  "expect": {"reverberation_s": [0.8, 1e-3, -2]}
})";

}  // namespace

TEST_CASE("Every shipped scene saved to another folder has the same content") {
    const TemporaryFolder folder;
    fs::create_directories(folder.path() / "a" / "b");
    for (const fs::path& file : shipped_scenes()) {
        INFO(file);
        const LoadedScene read = load_scene(file);
        const fs::path saved = folder.path() / "a" / "b" / file.filename();
        write_edited_scene(read, read.scene, file, saved);
        const LoadedScene again = load_scene(saved);
        CHECK(again.warnings.empty());
        check_same_scenes(again.scene, read.scene);
        // In the original folder nothing differs but comments and white space.
        CHECK(json_text(parse_json(
                  edited_scene_text(read, read.scene, file.parent_path(), file.parent_path()),
                  "saved")) == json_text(*read.json));
    }
}

TEST_CASE(
    "In every shipped scene the new material of one surface is saved and nothing else changes") {
    const TemporaryFolder folder;
    for (const fs::path& file : shipped_scenes()) {
        const LoadedScene read = load_scene(file);
        if (read.scene.objects.empty()) continue;
        INFO(file);
        const RayScene rays(read.scene);
        const Material felt{"felt", Bands::filled(0.37F), Bands::filled(0.21F)};
        const Scene edited = with_material(read.scene, surface_of(rays, 0), felt);
        const fs::path saved = folder.path() / file.filename();
        write_edited_scene(read, edited, file, saved);
        const LoadedScene again = load_scene(saved);
        check_same_scenes(again.scene, edited);
        CHECK(materials_of(edited) != materials_of(read.scene));
        // Meshes remain files, faces are unchanged.
        const bool has_mesh = text_of(file).find("\"file\"") != std::string::npos;
        CHECK((text_of(saved).find("\"file\"") != std::string::npos) == has_mesh);
    }
}

TEST_CASE(
    "A saved scene keeps everything but comments: quads, paths, sources of materials, "
    "expectations") {
    const Written scene(kRoom);
    const std::string text = scene.text(scene.read().scene);
    CHECK(json_text(parse_json(text, "saved")) == json_text(*scene.read().json));
    CHECK(text.find("a comment") == std::string::npos);
    CHECK(text.find("\"faces\": [[0, 1, 2, 3]]") != std::string::npos);
    CHECK(text.find("\"reverberation_s\": [0.8, 0.001, -2]") != std::string::npos);
    CHECK(text.find("\"source\": \"measured\"") != std::string::npos);
}

TEST_CASE("A saved scene has all changes: positions, gains, loops, settings") {
    const Written scene(kRoom);
    Scene edited = scene.read().scene;
    CHECK(edited.speech.speech_db == aula::SpeechConditions::male_speech_db(66));
    CHECK((*edited.speech.noise_db)[4] == 40);
    edited.sources[0].path.reset();
    edited.sources[0].position = {1.25F, 2.1F, 1.3F};
    edited.sources[1].gain_db = 2.1F;
    edited.sources[1].loop = true;
    edited.simulation.estimator = Estimator::dpc;
    edited.simulation.ir_length_s = 0.7F;
    edited.simulation.rays = 100'000;
    edited.simulation.quality = aula::Quality::draft;
    edited.simulation.transmission = false;
    edited.simulation.seed = 18446744073709551615U;
    check_same_scenes(scene.saved(edited), edited);
    edited.listener.path.reset();
    edited.listener.pose.position.x = 1.1F;
    check_same_scenes(scene.saved(edited), edited);
    // Conversion to degrees and back: three roundings.
    edited.listener.pose.yaw_rad = 1.25F;
    CHECK(scene.saved(edited).listener.pose.yaw_rad == Approx(1.25).epsilon(1e-6));
}

TEST_CASE("A saved scene keeps a source on the listener, and writes where it was moved to") {
    std::string text = kRoom;
    const std::string rests = R"("gain_db": -5)";
    text.replace(text.find(rests), rests.size(), R"("relative_to": "listener")");
    const Written scene(text);
    Scene edited = scene.read().scene;
    REQUIRE(edited.sources[1].from_listener == Vec3(2, 3, 1));
    edited.listener.path.reset();
    edited.listener.pose = {{1, 1, 1}, 0.5F, 0, 0};
    edited.attach_sources();
    const Scene followed = scene.saved(edited);
    CHECK(followed.sources[1].from_listener == Vec3(2, 3, 1));
    CHECK(followed.sources[1].position == followed.listener.pose.at({2, 3, 1}).position);
    edited.sources[1].from_listener.reset();
    edited.sources[1].set_pose({{2.5F, 1.5F, 1}, 0.75F, 0, 0});
    const Scene moved = scene.saved(edited);
    CHECK_FALSE(moved.sources[1].from_listener);
    CHECK(moved.sources[1].position == Vec3(2.5F, 1.5F, 1));
    CHECK(moved.sources[1].yaw_rad == Approx(0.75).epsilon(1e-6));
}

TEST_CASE("A saved scene has the crossover of its modes: none, a frequency, automatic") {
    std::string text = kRoom;
    const std::string rays = R"("rays": 300)";
    text.replace(text.find(rays), rays.size(), R"("rays": 300, "waves": false)");
    const Written rays_alone(text);
    const Written automatic(kRoom);
    for (const float waves_hz : {0.0F, 120.0F, aula::Simulation::kHighestWaves_hz}) {
        for (const Written* scene : {&rays_alone, &automatic}) {
            Scene edited = scene->read().scene;
            edited.simulation.waves_hz = waves_hz;
            CHECK(scene->saved(edited).simulation.waves_hz == waves_hz);
        }
    }
}

TEST_CASE("A saved scene keeps orientations and directivities, and finds their files") {
    std::string text = kRoom;
    const std::string rests = R"("gain_db": -5)";
    text.replace(text.find(rests), rests.size(),
                 R"("directivity": "horn.json", "yaw_deg": 30, "roll_deg": -20)");
    const std::string moves = R"("signal": "noise")";
    text.replace(text.find(moves), moves.size(), R"("directivity": "talker")");
    const Written scene(text, {{"horn.json", R"({"aula_directivity": 1, "level_db": [)"
                                             R"([[0,0,0,0],[3,0,-3,0],[0,0,0,0]],)"
                                             R"([[0,0,0,0],[3,0,-3,0],[0,0,0,0]],)"
                                             R"([[0,0,0,0],[3,0,-3,0],[0,0,0,0]],)"
                                             R"([[0,0,0,0],[3,0,-3,0],[0,0,0,0]],)"
                                             R"([[0,0,0,0],[3,0,-3,0],[0,0,0,0]],)"
                                             R"([[0,0,0,0],[3,0,-3,0],[0,0,0,0]],)"
                                             R"([[0,0,0,0],[3,0,-3,0],[0,0,0,0]],)"
                                             R"([[0,0,0,0],[9,0,-9,0],[0,0,0,0]]]})"}});
    Scene edited = scene.read().scene;
    edited.sources[1].yaw_rad = 1.25F;
    const Scene saved = scene.saved(edited);
    CHECK(saved.sources[1].yaw_rad == Approx(1.25).epsilon(1e-6));
    CHECK(saved.sources[1].roll_rad == edited.sources[1].roll_rad);
    for (const Vec3& d : {Vec3(1, 0, 0), Vec3(0, -0.6F, 0.8F)}) {
        for (std::size_t s = 0; s < 2; ++s) {
            CHECK(saved.sources[s].directivity.factor(d) ==
                  edited.sources[s].directivity.factor(d));
        }
    }
    CHECK_FALSE(saved.sources[1].directivity.factor({1, 0, 0}) ==
                saved.sources[0].directivity.factor({1, 0, 0}));
}

TEST_CASE("New materials of surfaces are saved with their values if the library's differ") {
    const Written scene(kRoom);
    const auto library = material_library();
    const auto named = [&](const std::string& name) {
        return std::find_if(library.begin(), library.end(),
                            [&](const auto& entry) { return entry.material.name == name; })
            ->material;
    };
    // The scene defines a curtain; glass is the library's.
    Scene edited = with_material(scene.read().scene, {0, 1}, named("curtain"));
    CHECK(material_of(edited, 0).name == "curtain 2");
    edited = with_material(edited, {4, 5, 12, 13}, named("glass"));
    const Scene saved = scene.saved(edited);
    CHECK(materials_of(saved) == materials_of(edited));
    CHECK(material_of(saved, 4).name == "glass");
    const std::string text = scene.text(edited);
    CHECK(text.find("\"curtain 2\": {") != std::string::npos);
    CHECK(text.find("\"glass\": {") == std::string::npos);
    // The whole screen is glass: the key `material` is changed.
    CHECK(text.find("\"faces\": [[0, 1, 2, 3]],\n      \"material\": \"glass\"") !=
          std::string::npos);
}

TEST_CASE("The sound reduction of a new material is saved") {
    const Written scene(kRoom);
    Material pane{"pane", Bands::filled(0.2F), Bands::filled(0.1F), Bands::filled(20)};
    pane.sound_reduction_db->value[3] = 35.5F;
    const Scene edited = with_material(scene.read().scene, {0, 1}, pane);
    CHECK(material_of(scene.saved(edited), 0) == pane);
    Material opaque = pane;
    opaque.sound_reduction_db.reset();
    CHECK(material_of(with_material(edited, {0, 1}, opaque), 0).name == "pane 2");
}

TEST_CASE("A scene that is edited again after saving is saved with all edits") {
    const Written scene(kRoom);
    const Scene once = with_material(scene.read().scene, {0, 1, 2, 3}, {"felt", {}, {}});
    const Written again(scene.text(once));
    CHECK(materials_of(again.read().scene) == materials_of(once));
    const Scene twice = with_material(again.read().scene, {2, 3, 4, 5}, {"wool", {}, {}});
    CHECK(materials_of(again.saved(twice)) == materials_of(twice));
}

TEST_CASE("A sound file named like a built-in signal remains a file in another folder") {
    const TemporaryFolder folder;
    fs::create_directories(folder.path() / "out");
    for (const char* name : {"noise", "voice.wav"}) std::ofstream(folder.path() / name) << name;
    const fs::path file = folder.path() / "scene.json";
    std::ofstream(file) << R"({"aula": 1, "sources": [
        {"position": [0, 0, 0], "signal": "./noise"}, {"position": [0, 0, 1], "signal": "noise"},
        {"position": [0, 0, 2], "signal": "voice.wav"},
        {"position": [0, 0, 3], "signal": ")" +
                               (folder.path() / "voice.wav").string() + R"("}],
        "listener": {"position": [2, 0, 0]}})";
    const LoadedScene read = load_scene(file);
    write_edited_scene(read, read.scene, file, folder.path() / "out" / "saved.json");
    check_same_scenes(load_scene(folder.path() / "out" / "saved.json").scene, read.scene);
    // Also through a link to the folder: ".." is the parent of the target.
    fs::create_directories(folder.path() / "far" / "away");
    fs::create_directory_symlink(folder.path() / "out", folder.path() / "far" / "away" / "link");
    write_edited_scene(read, read.scene, file,
                       folder.path() / "far" / "away" / "link" / "linked.json");
    check_same_scenes(load_scene(folder.path() / "far" / "away" / "link" / "linked.json").scene,
                      read.scene);
}

TEST_CASE("A scene that cannot be written leaves no file") {
    const Written scene(kRoom);
    CHECK_THROWS_AS(
        write_edited_scene(scene.read(), scene.read().scene, scene.folder() / "scene.json",
                           scene.folder() / "none" / "scene.json"),
        InputError);
    CHECK(names_in(scene.folder()).size() == 1);
}
