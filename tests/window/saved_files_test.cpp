#include "apps/window/model/saved_files.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "apps/output/json_text.h"
#include "apps/room/edit/scene_writer.h"
#include "aula/audio/sound_file.h"
#include "aula/engine/scene_file.h"
#include "engine/model/model_scene.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"

using namespace aula;
using namespace aula::test;

namespace {

/// Makes a temporary folder the working directory.
class WorkingFolder {
 public:
    WorkingFolder() { std::filesystem::current_path(folder_.path()); }
    ~WorkingFolder() { std::filesystem::current_path(before_); }
    WorkingFolder(const WorkingFolder&) = delete;
    WorkingFolder& operator=(const WorkingFolder&) = delete;

 private:
    std::filesystem::path before_ = std::filesystem::current_path();
    TemporaryFolder folder_;
};

std::string text_of(const char* file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

EditedScene scene_of(const char* listener) {
    std::ofstream("walk.json") << R"({"aula": 1,
        "geometry": [{"box": [5, 4, 3], "material": "wood"}],
        "sources": [{"name": "voice", "position": [1, 1, 1.5], "signal": "noise"},
                    {"name": "guest", "signal": "noise",
                     "path": {"points": [{"t": 0, "position": [2, 1, 1.5]},
                                         {"t": 9, "position": [2, 3, 1.5]}]}}],
        "listener": )" << listener
                               << R"(, "simulation": {"ir_length_s": 0.4}})";
    WindowOptions options;
    options.load = [](const std::filesystem::path& file) { return load_scene(file); };
    return EditedScene(open_scene(options, "walk.json"));
}

}  // namespace

TEST_CASE("A saved scene has the gains and positions of the controls and the simulation") {
    const WorkingFolder folder;
    const EditedScene edited = scene_of(R"({"position": [4, 3, 1.6]})");
    PlayControls controls;
    controls.sources.resize(2);
    controls.sources[0].gain_db = -7.0F;
    controls.sources[1].position = Vec3(3, 2, 1);
    controls.listener = Pose{.position = {2, 2, 1.7F}};
    Simulation simulation = edited.scene().simulation;
    simulation.rays = 321;
    const std::string message = save_played_scene(edited, controls, simulation);
    CHECK(message ==
          "scene written to walk-edited.json, without comments and the path of guest, which was "
          "moved");
    const Scene saved = load_scene("walk-edited.json").scene;
    CHECK(saved.simulation.rays == 321);
    CHECK(saved.sources[0].gain_db == -7);
    CHECK(saved.sources[0].position == Vec3(1, 1, 1.5F));
    CHECK(saved.sources[1].position == Vec3(3, 2, 1));
    CHECK_FALSE(saved.sources[1].path);
    CHECK_FALSE(saved.sources[0].loop);
    CHECK(saved.listener.pose.position == Vec3(2, 2, 1.7F));
}

TEST_CASE("A saved scene keeps trajectories of the listener and of sources that were not moved") {
    const WorkingFolder folder;
    const EditedScene edited = scene_of(
        R"({"path": {"points": [{"t": 0, "position": [4, 3, 1.6]},
                                {"t": 100, "position": [1, 3, 1.6]}]}})");
    PlayControls controls;  // without entries for the sources
    controls.listener = Pose{.position = {2, 2, 1.7F}};
    CHECK(save_played_scene(edited, controls, edited.scene().simulation) ==
          "scene written to walk-edited.json, without comments");
    const Scene saved = load_scene("walk-edited.json").scene;
    REQUIRE(saved.listener.path);
    CHECK(saved.listener.path->duration_s() == 100);
    CHECK(saved.sources[1].path);
}

TEST_CASE("A source on the listener that was moved or turned is saved where it plays") {
    const WorkingFolder folder;
    std::ofstream("own.json") << R"({"aula": 1,
        "geometry": [{"box": [5, 4, 3], "material": "wood"}],
        "sources": [{"name": "own", "position": [0.1, 0, 0], "relative_to": "listener",
                     "signal": "noise"}],
        "listener": {"position": [1, 1, 1.6], "yaw_deg": 90}})";
    WindowOptions options;
    options.load = [](const std::filesystem::path& file) { return load_scene(file); };
    const EditedScene edited(open_scene(options, "own.json"));
    PlayControls controls;
    controls.listener = Pose{.position = {3, 2, 1.7F}};
    controls.sources.resize(1);
    CHECK(save_played_scene(edited, controls, edited.scene().simulation) ==
          "scene written to own-edited.json, without comments");
    CHECK(load_scene("own-edited.json").scene.sources[0].position == Vec3(3.1F, 2, 1.7F));
    for (const bool turned : {false, true}) {
        CAPTURE(turned);
        controls.sources[0] = {};
        if (turned)
            controls.sources[0].angles_rad = Vec3(0.5F, 0, 0);
        else
            controls.sources[0].position = Vec3(4, 3, 1);
        const std::string file = turned ? "own-edited-3.json" : "own-edited-2.json";
        CHECK(save_played_scene(edited, controls, edited.scene().simulation) ==
              "scene written to " + file +
                  ", without comments and relative_to of own, which was "
                  "moved");
        const Pose saved = load_scene(file).scene.sources[0].pose_at(0);
        const Pose played = controls.source_at(edited.scene(), 0, 0);
        CHECK(saved.position == played.position);
        CHECK(saved.yaw_rad == Approx(played.yaw_rad));
    }
}

TEST_CASE("The saved scene of a model is that of aula import, with the changes") {
    const WorkingFolder folder;
    std::ofstream("box.obj") << "v 0 0 0\nv 6 0 0\nv 6 5 0\nv 0 5 0\nv 0 0 3\nv 6 0 3\nv 6 5 3\n"
                                "v 0 5 3\nusemtl Wand_Putz\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n"
                                "f 4 1 5 8\nusemtl Boden_Parkett\nf 4 3 2 1\nusemtl Decke\n"
                                "f 5 6 7 8\n";
    WindowOptions options;
    options.load = [](const std::filesystem::path& file) { return load_scene(file); };
    const EditedScene edited(open_scene(options, "box.obj"));
    CHECK(save_played_scene(edited, {}, edited.scene().simulation) ==
          "scene written to box-edited.json");
    const ModelScene model = scene_of_model("box.obj", "");
    REQUIRE(model.guesses.size() >= 4);
    CHECK(text_of("box-edited.json") ==
          model_comment("box.obj", model.guesses) + json_text(model.json) + "\n");

    PlayControls controls;
    controls.sources.resize(1);
    controls.sources[0].position = Vec3(3, 2, 1);
    save_played_scene(edited, controls, edited.scene().simulation);
    CHECK(load_scene("box-edited-2.json").scene.sources[0].position == Vec3(3, 2, 1));
}

TEST_CASE("The response of a view is written as a sound file with the report of its source") {
    const WorkingFolder folder;
    Scene scene = small_room();
    scene.sources.push_back(scene.sources[0]);
    scene.sources[1].name = "second";
    FrameView view;
    view.source = 1;
    view.sources = {scene.sources[0].position, scene.sources[1].position};
    view.listener = scene.listener.pose;
    view.simulation = scene.simulation;
    view.length_s = 0.4;
    view.response.bins = TimeBins(view.length_s);
    for (std::size_t bin = 0; bin < view.response.bins.count(); ++bin) {
        const double time_s = view.response.bins.begin_s(bin);
        view.response.energy.push_back(Bands::filled(static_cast<float>(std::exp(-30 * time_s))));
        view.response.directions.emplace_back();
    }
    PlaybackOptions playback;
    playback.output = OutputFormat::mono;
    CHECK(save_response(scene, view, playback, "room") ==
          "room-ir.wav and room-report.json written");
    const SoundClip clip = read_sound("room-ir.wav", playback.sample_rate_hz);
    CHECK(static_cast<double>(clip.samples.size()) > 0.3 * playback.sample_rate_hz);
    CHECK(text_of("room-report.json").find("second") != std::string::npos);
}
