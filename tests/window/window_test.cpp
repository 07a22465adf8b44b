#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/support/jack_server.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"
#include "tests/window/display.h"

namespace {

using namespace aula::test;

/// Width and height of a PNG file, by its header.
std::pair<unsigned, unsigned> png_size(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    std::string header(24, '\0');
    in.read(header.data(), 24);
    if (!in || header.substr(1, 3) != "PNG") return {0, 0};
    const auto number = [&](std::size_t at) {
        unsigned value = 0;
        for (std::size_t i = 0; i < 4; ++i)
            value = value << 8 | static_cast<unsigned char>(header[at + i]);
        return value;
    };
    return {number(16), number(20)};
}

}  // namespace

TEST_CASE("The window opens, plays and draws, and it writes the screenshot only") {
    if (!are_installed("Xvfb")) {
        WARN("skipped: Xvfb is not installed");
        return;
    }
    const JackServer server(256);
    const Display display("900x600");
    if (!server.running() || !display.running()) {
        WARN("skipped: no JACK server or no display can run here");
        return;
    }
    const TemporaryFolder folder;
    const std::string picture = folder.path() / "window.png";
    setenv("XDG_STATE_HOME", folder.path().c_str(), 1);
    const ProgramResult result =
        run_program({AULA_PROGRAM, AULA_SOURCE_DIR "/scenes/shoebox.json", "--screenshot", picture,
                     "--after", "1", "--frame-rate", "10", "--rays", "200"});
    unsetenv("XDG_STATE_HOME");
    INFO(result.err);
    if (result.err.find("no window can be opened") != std::string::npos) {
        WARN("skipped: built without the window, or no OpenGL 3.3 here");
        return;
    }
    REQUIRE(result.status == 0);
    // The window is as large as the display.
    CHECK(png_size(picture) == std::pair{900U, 600U});
    // A picture of one colour takes a few kilobytes.
    CHECK(std::filesystem::file_size(picture) > 50'000);
    CHECK(names_in(folder.path()).size() == 1);
}

TEST_CASE("Resizing the window rescales its text") {
    if (!are_installed("Xvfb xdotool")) {
        WARN("skipped: Xvfb or xdotool is not installed");
        return;
    }
    const Display display;
    const TemporaryFolder folder;
    const std::string picture = folder.path() / "window.png";
    const ProgramResult result = run_program(
        {"sh", "-c",
         "\"$0\" \"$1\" --device none --screenshot \"$2\" --after 8 --frame-rate 10 --rays 200 & "
         "xdotool search --sync --onlyvisible --name . >&2; for size in '1500 1000' '700 500' "
         "'1600 1100'; do"
         "  sleep 1; xdotool search --onlyvisible --name . windowsize $size >&2; "
         "done; wait $!",
         AULA_PROGRAM, AULA_SOURCE_DIR "/scenes/shoebox.json", picture});
    INFO(result.err);
    if (!display.running() || result.err.find("no window can be opened") != std::string::npos) {
        WARN("skipped: no display can run here");
        return;
    }
    CHECK(result.status == 0);
    CHECK(png_size(picture) == std::pair{1600U, 1100U});
}

TEST_CASE("A model that is dragged onto the window and dropped opens") {
    const std::string drop_file = AULA_DROP_FILE;
    if (drop_file.empty() || !are_installed("Xvfb")) {
        WARN("skipped: Xvfb or Xlib is not installed");
        return;
    }
    const Display display("900x600");
    const TemporaryFolder folder;
    // A GLB file of a box, whose buffers are in its JSON.
    std::string json = read_file(AULA_SOURCE_DIR "/tests/cases/models/plain.gltf");
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const auto word = [](std::size_t number) {
        std::string bytes;
        for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(number >> shift);
        return bytes;
    };
    const std::string model =
        folder.write("Hörsaal 1.glb",
                     "glTF" + word(2) + word(20 + json.size()) + word(json.size()) + "JSON" + json);
    const std::string picture = folder.path() / "window.png";
    setenv("AULA_NO_STATE", "1", 1);
    const ProgramResult result = run_program(
        {"sh", "-c",
         "\"$0\" \"$1\" --device none --screenshot \"$2\" --after 8 --frame-rate 10 --rays 200 & "
         "\"$3\" 'shoebox.json - Aula' \"$4\" 'Hörsaal 1.glb - Aula'; dropped=$?; wait $! && exit "
         "$dropped",
         AULA_PROGRAM, AULA_SOURCE_DIR "/scenes/shoebox.json", picture, drop_file, model});
    unsetenv("AULA_NO_STATE");
    INFO(result.err);
    if (!display.running() || result.err.find("no window can be opened") != std::string::npos) {
        WARN("skipped: no display can run here");
        return;
    }
    CHECK(result.status == 0);
    CHECK(png_size(picture) == std::pair{900U, 600U});
    CHECK(std::filesystem::file_size(picture) > 50'000);
}

TEST_CASE("Without a sound device the window opens in silence, with a warning") {
    if (!are_installed("Xvfb")) {
        WARN("skipped: Xvfb is not installed");
        return;
    }
    const Display display;
    const TemporaryFolder folder;
    const std::string picture = folder.path() / "window.png";
    setenv("JACK_DEFAULT_SERVER", "aula-test-no-such-server", 1);
    setenv("PULSE_SERVER", "unix:/nowhere", 1);
    const ProgramResult devices = run_program({AULA_PROGRAM, "--list-devices"});
    const ProgramResult result =
        run_program({AULA_PROGRAM, AULA_SOURCE_DIR "/scenes/shoebox.json", "--screenshot", picture,
                     "--after", "0.5", "--frame-rate", "10", "--rays", "200"});
    setenv("AULA_NO_STATE", "1", 1);
    const ProgramResult shown =
        run_program({AULA_PROGRAM, AULA_SOURCE_DIR "/scenes/shoebox.json", "--duration", "0.5",
                     "--frame-rate", "10", "--rays", "200"});
    unsetenv("AULA_NO_STATE");
    unsetenv("JACK_DEFAULT_SERVER");
    unsetenv("PULSE_SERVER");
    INFO(result.err);
    if (!display.running() || devices.status != 1 ||
        result.err.find("no window can be opened") != std::string::npos) {
        WARN("skipped: no display can run here, or a sound device exists");
        return;
    }
    CHECK(result.status == 0);
    CHECK(png_size(picture) == std::pair{1600U, 1200U});
    CHECK(result.err.ends_with("playing in silence\n"));
    INFO(shown.err);
    CHECK(shown.status == 0);
    CHECK(shown.err.find("playing in silence\n") != std::string::npos);
}

TEST_CASE("Without a display a screenshot is refused") {
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    const ProgramResult result = run_program(
        {AULA_PROGRAM, AULA_SOURCE_DIR "/scenes/shoebox.json", "--screenshot", "/tmp/none.png"});
    CHECK(result.status == 2);
    CHECK(result.err.find("--screenshot") != std::string::npos);
}
