#include "apps/window/model/model.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <string_view>

#include "apps/room/edit/scene_edits.h"
#include "apps/window/view/curves.h"
#include "aula/exception.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"
#include "tests/support/wait.h"

// The window's model, played without a device.

using namespace aula;
using namespace aula::test;
using namespace std::string_view_literals;

namespace {

/// Scenes by file name: "room"; "two" has a second source; "wrong" cannot be played; "broken"
/// cannot be read.
Scene scene_of(const std::filesystem::path& file) {
    if (file.filename() == "broken") throw InputError(file, "/aula", "it is broken");
    Scene scene = small_room();
    scene.simulation.rays = file.filename() == "wrong" ? 0 : 100;
    if (file.filename() == "two") {
        scene.sources.push_back(scene.sources[0]);
        scene.sources[1].name = "other";
    }
    return scene;
}

LoadedScene load(const std::filesystem::path& file) {
    if (file.extension() == ".json" || file.extension() == ".obj") return load_scene(file);
    LoadedScene loaded;
    loaded.scene = scene_of(file);
    return loaded;
}

class Room {
 public:
    explicit Room(std::optional<std::string> osc = {}) {
        for (const char* name : {"room", "two", "wrong", "broken"})
            std::ofstream(folder_.path() / name) << name;
        WindowOptions options;
        options.scene_file = folder_.path() / "room";
        options.playback.device = AudioDevice::kNone;
        options.playback.output = OutputFormat::mono;
        options.load = load;
        if (osc) options.osc = {.address = *osc};
        model_ = std::make_unique<Model>(options);
    }

    Model& model() { return *model_; }
    std::filesystem::path file(const char* name) const { return folder_.path() / name; }

    /// Updates the model until a condition holds; false after a long time.
    bool shows(const std::function<bool()>& holds) {
        return eventually([&] {
            model_->update(0.01 * ++pictures_);
            return holds();
        });
    }

    /// Updates the model until no change is pending.
    bool rests() {
        return shows([&] { return model_->busy().empty() && !model_->status().preparing; });
    }

    bool says(const std::string& text) const {
        const auto& messages = model_->messages();
        return std::any_of(messages.begin(), messages.end(), [&](const auto& message) {
            return message.text.find(text) != std::string::npos;
        });
    }

 private:
    TemporaryFolder folder_;
    std::unique_ptr<Model> model_;
    int pictures_ = 0;
};

float absorption(const Model& model) { return material_of(model.scene(), 0).absorption[4]; }

/// The port in the model's message about OSC.
int osc_port(const Model& model) {
    const std::string text = "OSC on port ";
    for (const auto& message : model.messages())
        if (const auto at = message.text.find(text); at != std::string::npos)
            return std::stoi(message.text.substr(at + text.size()));
    FAIL("no message names the OSC port");
    return 0;
}

/// Sends a packet to a UDP port of this machine.
void send(int port, std::string_view packet) {
    const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    sendto(socket, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to),
           sizeof(to));
    close(socket);
}

}  // namespace

TEST_CASE("A change of a surface's material plays, and is undone and redone") {
    Room room;
    Model& model = room.model();
    const float before = absorption(model);
    model.pick(0);
    Material curtain = model.surface_material();
    curtain.absorption = Bands::filled(0.7F);
    model.give_material(curtain, false);
    CHECK(absorption(model) == 0.7F);
    REQUIRE(room.shows([&] { return model.status().audible_change == 1; }));
    REQUIRE(model.can_undo());
    model.undo();
    CHECK(absorption(model) == before);
    REQUIRE(room.shows([&] { return model.status().audible_change == 2; }));
    CHECK_FALSE(model.can_undo());
    model.redo();
    CHECK(absorption(model) == 0.7F);
    REQUIRE(room.shows([&] { return model.status().audible_change == 3; }));
}

TEST_CASE("A scene that cannot be read or played gives a message, and the old one continues") {
    Room room;
    Model& model = room.model();
    model.open(room.file("broken"));
    REQUIRE(room.rests());
    CHECK(room.says("it is broken"));
    CHECK(model.scene_file() == room.file("room"));

    // Another change starts to play while the scene is being opened.
    model.pick(0);
    model.give_material(model.library()[0].material, true);
    model.open(room.file("wrong"));
    REQUIRE(room.rests());
    REQUIRE(room.shows([&] { return model.status().failed_changes == 1; }));
    CHECK(room.says("rays"));
    CHECK(model.scene_file() == room.file("room"));
    const auto frames = model.status().frames;
    CHECK(room.shows([&] { return model.status().frames > frames + 3; }));
}

TEST_CASE("A saved scene keeps the listener's path after a walk, and the source's new position") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "walk.json";
    std::ofstream(file) << R"({"aula": 1, "geometry": [{"box": [5, 4, 3], "material": "wood"}],
        "sources": [{"name": "voice", "position": [1, 1, 1.5], "signal": "noise"}],
        "listener": {"path": {"points": [{"t": 0, "position": [4, 3, 1.6]},
                                         {"t": 100, "position": [1, 3, 1.6]}]}},
        "simulation": {"rays": 100, "ir_length_s": 0.4}, "expect": 7})";
    Room room;
    Model& model = room.model();
    model.open(file);
    REQUIRE(room.shows([&] { return model.scene_file() == file; }));
    model.walk({.ahead = 1}, 0.5);
    CHECK_FALSE(model.follows_path());
    model.move_source(0, {2, 1, 1.5F});
    const auto before = std::filesystem::current_path();
    std::filesystem::current_path(folder.path());
    model.save_scene();
    std::filesystem::current_path(before);
    CHECK(room.says("walk-edited.json, without comments"));
    const LoadedScene saved = load_scene(folder.path() / "walk-edited.json");
    REQUIRE(saved.scene.listener.path);
    CHECK(saved.scene.listener.path->duration_s() == 100);
    CHECK(saved.scene.sources[0].position == Vec3(2, 1, 1.5F));
    // The window loops all signals; the saved file does not.
    CHECK_FALSE(saved.scene.sources[0].loop);
    CHECK(saved.scene.simulation == model.setting().simulation);
}

TEST_CASE("Two windows that record at the same time write two files") {
    const TemporaryFolder folder;
    const auto before = std::filesystem::current_path();
    std::filesystem::current_path(folder.path());
    {
        Room a;
        Room b;
        const auto record = [](Room& room) {
            room.model().toggle_recording();
            REQUIRE(room.shows([&] { return room.model().monitor_status().recorded_s > 0; }));
        };
        record(a);
        record(b);
        a.model().toggle_recording();
        CHECK(a.says("recording to room-heard.wav"));
        CHECK(b.says("recording to room-heard-2.wav"));
        CHECK(std::filesystem::file_size("room-heard.wav") > 0);
        // The other file is completed when its window closes.
    }
    CHECK(std::filesystem::file_size("room-heard-2.wav") > 0);
    CHECK(names_in(".").size() == 2);
    std::filesystem::current_path(before);
}

TEST_CASE("A new file that stays empty is removed") {
    const TemporaryFolder folder;
    const std::string stem = (folder.path() / "a").string();
    {
        const NewFile first(stem, ".wav");
        const NewFile second(stem, ".wav");
        CHECK(second.path() == stem + "-2.wav");
        std::ofstream(second.path()) << "used";
    }
    CHECK(names_in(folder.path()) == std::vector<std::string>{"a-2.wav"});
    CHECK_THROWS_AS(NewFile((folder.path() / "none/a").string(), ".wav"), InputError);
}

TEST_CASE("A name that an ended program has reserved is free again") {
    const TemporaryFolder folder;
    folder.write("a.wav", "");
    folder.write("a-2.wav", "used");
    const std::string stem = (folder.path() / "a").string();
    const NewFile first(stem, ".wav");
    const NewFile second(stem, ".wav");
    CHECK(first.path() == stem + ".wav");
    CHECK(second.path() == stem + "-3.wav");
}

TEST_CASE("Opening a scene resets the sources' controls") {
    Room room;
    Model& model = room.model();
    model.set_control(0, &SourceControl::muted, true);
    model.open(room.file("two"));
    REQUIRE(room.shows([&] { return model.scene_file() == room.file("two"); }));
    REQUIRE(room.shows([&] { return model.status().sources.size() == 2; }));
    CHECK(model.controls().sources.size() == 2);
    CHECK_FALSE(model.controls().sources[0].muted);
    model.set_control(1, &SourceControl::muted, true);
    model.open(room.file("room"));
    REQUIRE(room.shows([&] { return model.scene_file() == room.file("room"); }));
    CHECK(model.controls().sources.size() == 1);
    CHECK_FALSE(model.controls().sources[0].muted);
}

TEST_CASE("A model that is dropped onto the window opens, and the window says what was guessed") {
    Room room;
    std::ofstream(room.file("box.obj"))
        << "v 0 0 0\nv 6 0 0\nv 6 5 0\nv 0 5 0\nv 0 0 3\nv 6 0 3\nv 6 5 3\nv 0 5 3\n"
           "usemtl Wand_Putz\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
           "usemtl Boden_Parkett\nf 4 3 2 1\nusemtl Decke\nf 5 6 7 8\n";
    Model& model = room.model();
    model.take_file(room.file("box.obj"));
    REQUIRE(room.shows([&] { return model.scene_file().filename() == "box.obj"; }));
    CHECK(model.scene().sources.size() == 1);
    CHECK(room.says("guessed material \"Wand_Putz\": plaster"));
}

TEST_CASE("A file that is dropped and is no scene is a sound for the selected source") {
    Room room;
    Model& model = room.model();
    model.take_file(room.file("none.wav"));
    CHECK(room.says("none.wav"));
    CHECK(model.scene_file().filename() == "room");
}

TEST_CASE("The parameters of the window are those of its view") {
    Room room;
    Model& model = room.model();
    model.watch();
    REQUIRE(room.shows([&] { return model.view() != nullptr; }));
    const PairParameters expected = view_parameters(*model.view(), model.scene().speech);
    REQUIRE(expected.broadband[1].value);
    CHECK(model.parameters().broadband[1].value == expected.broadband[1].value);
    CHECK(model.parameters().sti.value == expected.sti.value);
}

TEST_CASE("Views are shown while the player keeps adapting the response to the machine") {
    Room room;
    Model& model = room.model();
    model.watch();
    // Frames of a tenth of a second, and one change after the other, which the window has not
    // requested.
    Scene scene = model.scene();
    scene.simulation.rays = 40'000;
    PlaybackOptions playback;
    playback.output = OutputFormat::mono;
    playback.device = AudioDevice::kNone;
    const auto adapt = [&] {
        if (!model.player().status().preparing) model.player().change(scene, playback);
    };
    adapt();
    CHECK(room.shows([&] {
        adapt();
        return model.view() != nullptr;
    }));
}

TEST_CASE("Two settings each keep their estimator and view") {
    Room room;
    Model& model = room.model();
    model.watch();
    REQUIRE(room.shows([&] { return model.view() != nullptr; }));
    CHECK_FALSE(model.compares());
    model.switch_setting();
    CHECK(model.active() == 1);
    CHECK(model.compares());
    Simulation other = model.setting().simulation;
    other.estimator = Estimator::pt;
    model.set_simulation(other, 1);
    REQUIRE(room.shows(
        [&] { return model.view() && model.view()->simulation.estimator == Estimator::pt; }));
    model.switch_setting();
    CHECK(model.setting().simulation.estimator == Estimator::patch);
    CHECK(model.other_setting().simulation.estimator == Estimator::pt);
    REQUIRE(room.shows(
        [&] { return model.view() && model.view()->simulation.estimator == Estimator::patch; }));
}

TEST_CASE("Switching between equal settings, or setting the present one, prepares nothing") {
    Room room;
    Model& model = room.model();
    model.watch();
    REQUIRE(room.shows([&] { return model.view() != nullptr; }));
    model.switch_setting();
    CHECK_FALSE(model.player().status().preparing);
    model.set_simulation(model.setting().simulation, model.setting().ambisonic_order);
    CHECK_FALSE(model.player().status().preparing);
    // The view continues under the other setting.
    const auto frame = model.view()->frame;
    REQUIRE(room.shows([&] { return model.view()->frame > frame; }));
    CHECK(model.status().audible_change == 0);
    Simulation other = model.setting().simulation;
    other.patch_size_m = 0.8F;
    model.set_simulation(other, 1);
    REQUIRE(room.shows([&] { return model.status().audible_change == 1; }));
}

TEST_CASE("A setting that failed is tried again on request") {
    Room room;
    Model& model = room.model();
    Simulation wrong = model.setting().simulation;
    wrong.rays = 0;
    for (std::uint64_t failures : {1U, 2U}) {
        model.set_simulation(wrong, 1);
        REQUIRE(room.shows([&] { return model.status().failed_changes == failures; }));
        CHECK(model.setting().simulation.rays == 100);
    }
}

TEST_CASE("A change of material discards the other setting's view") {
    Room room;
    Model& model = room.model();
    model.watch();
    REQUIRE(room.shows([&] { return model.view() != nullptr; }));
    model.switch_setting();
    REQUIRE(model.compares());
    model.pick(0);
    model.give_material(model.library()[0].material, true);
    CHECK_FALSE(model.compares());
}

TEST_CASE("Of many material messages in a row the newest plays, and one undo step reverts them") {
    Room room("0");
    Model& model = room.model();
    const float before = absorption(model);
    const int port = osc_port(model);
    for (int i = 0; i < 1000; ++i) {
        send(port, "/aula/material\0\0,ss\0wall\0\0\0\0glass\0\0\0"sv);
        send(port, "/aula/material\0\0,ss\0wall\0\0\0\0curtain\0"sv);
    }
    REQUIRE(room.shows([&] { return absorption(model) != before; }));
    REQUIRE(room.rests());
    CHECK(room.shows([&] { return model.status().audible_change > 0; }));
    model.undo();
    CHECK(absorption(model) == before);
    CHECK_FALSE(model.can_undo());
}

TEST_CASE("OSC and the window change different controls without overwriting each other") {
    Room room("0");
    Model& model = room.model();
    const int port = osc_port(model);
    room.shows([] { return true; });
    // The window's copy of the controls predates the message.
    send(port, "/aula/source/mute\0\0\0,si\0source\0\0\0\0\0\1"sv);
    REQUIRE(eventually([&] { return model.player().controls().source(0).muted; }));
    model.take_listener({.position = {1, 1, 1}});
    CHECK(model.player().controls().source(0).muted);
    CHECK(model.player().controls().listener->position == Vec3(1, 1, 1));
    send(port, "/aula/listener/orientation\0\0,fff\0\0\0\0\x42\xb4\0\0\0\0\0\0\0\0\0\0"sv);
    REQUIRE(eventually([&] { return model.player().controls().listener->yaw_rad > 1.5F; }));
    CHECK(model.player().controls().listener->position == Vec3(1, 1, 1));
    REQUIRE(room.shows([&] { return model.status().listener.yaw_rad > 1.5F; }));
    CHECK(model.status().latency.head_p50_ms > 0);
    // Orientation and pose of a source: 90 degrees to the left; then at (1, 0, 0), upwards.
    send(port,
         "/aula/source/orientation\0\0\0\0,sfff\0\0\0source\0\0\x42\xb4\0\0\0\0\0\0\0\0\0\0"sv);
    REQUIRE(eventually([&] { return model.player().controls().source(0).angles_rad.has_value(); }));
    CHECK(model.player().controls().source(0).angles_rad->x == Approx(1.5708).epsilon(1e-4));
    CHECK_FALSE(model.player().controls().source(0).position);
    send(port,
         "/aula/source/pose\0\0\0,sffffff\0\0\0\0source\0\0\x3f\x80\0\0\0\0\0\0\0\0\0\0"
         "\0\0\0\0\x42\xb4\0\0\0\0\0\0"sv);
    REQUIRE(eventually([&] { return model.player().controls().source(0).position.has_value(); }));
    CHECK(*model.player().controls().source(0).position == Vec3(1, 0, 0));
    CHECK(model.player().controls().source(0).angles_rad->y == Approx(1.5708).epsilon(1e-4));
}

TEST_CASE("An edited scene file is reloaded: its positions apply, and undo restores a move") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "edited.json";
    auto write = [&, edits = 0](const std::string& material) mutable {
        std::ofstream(file) << R"({"aula": 1, "geometry": [{"box": [5, 4, 3], "material": ")"
                            << material << R"("}],
            "sources": [{"name": "voice", "position": [1, 1, 1.5], "signal": "noise"}],
            "listener": {"position": [4, 3, 1.6]}, "simulation": {"rays": 100}})";
        // Edits follow one another faster than the clock of some file systems.
        std::filesystem::last_write_time(
            file, std::filesystem::last_write_time(file) + std::chrono::seconds(++edits));
    };
    write("wood");
    Room room;
    Model& model = room.model();
    model.open(file);
    REQUIRE(room.shows([&] { return model.scene_file() == file; }));
    model.move_source(0, {2, 1, 1.5F});
    model.source_moved();

    write("no such material");
    REQUIRE(room.shows([&] { return room.says("edited.json:"); }));
    CHECK(material_of(model.scene(), 0).name == "wood");
    CHECK(model.controls().sources[0].position);
    write("curtain");
    REQUIRE(room.shows([&] { return room.says("edited.json reloaded"); }));
    CHECK_FALSE(room.says("edited.json:"));
    CHECK(material_of(model.scene(), 0).name == "curtain");
    CHECK_FALSE(model.player().controls().source(0).position);

    model.undo();
    CHECK(material_of(model.scene(), 0).name == "wood");
    CHECK(model.player().controls().source(0).position == Vec3(2, 1, 1.5F));
}

TEST_CASE("A map is measured in the background, is marked after a change, and can be cancelled") {
    Room room;
    Model& model = room.model();
    model.start_map(1.2, 1);
    CHECK(model.map_progress().has_value());
    REQUIRE(room.shows([&] { return model.map() != nullptr; }));
    CHECK_FALSE(model.map_progress());
    const auto map = model.map();
    CHECK(map->measurement.parameters.size() == map->grid.receivers.size());
    CHECK(map->grid.height_m == 1.2F);
    CHECK(model.map_is_current());

    model.move_source(0, model.scene().sources[0].position_at(0) + Vec3(0.1F, 0, 0));
    CHECK_FALSE(model.map_is_current());

    model.start_map(1.2, 0.1);
    model.cancel_map();
    REQUIRE(room.shows([&] { return !model.map_progress() && model.busy().empty(); }));
    CHECK(model.map() == map);
}

TEST_CASE("A plane outside of the room is a message, and another scene drops the map") {
    Room room;
    Model& model = room.model();
    model.start_map(1000, 1);
    REQUIRE(room.shows([&] { return room.says("is outside of the room"); }));
    CHECK_FALSE(model.map());
    model.start_map(1.2, 1);
    REQUIRE(room.shows([&] { return model.map() != nullptr; }));
    model.open(room.file("two"));
    CHECK(room.shows([&] { return model.scene().sources.size() == 2; }));
    CHECK(room.rests());
    CHECK_FALSE(model.map());
}
