#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/plugin/host_commands.h"

// Runs the plugins in other programs' hosts.

namespace {

using namespace aula::test;
namespace fs = std::filesystem;

const std::string kDefaultRoom = std::string(AULA_SOURCE_DIR) + "/scenes/default.json";

/// Writes clicks.wav: clicks, one each second, as the default room's source.
void write_clicks(const TemporaryFolder& folder, std::size_t samples) {
    std::vector<float> clicks(samples);
    for (std::size_t n = 0; n < samples; n += 48000) clicks[n] = 1;
    write_mono(folder.path() / "clicks.wav", clicks);
}

}  // namespace

TEST_CASE("lv2_validate finds no error in the bundle") {
    // A script of lv2-dev that calls a program of sordi.
    if (!has("lv2_validate") || !has("sord_validate")) return;
    const TemporaryFolder folder;
    const std::string bundle = AULA_BUNDLES "/aula.lv2/";
    const ProgramResult result =
        run_host(folder, "lv2_validate " + bundle + "manifest.ttl " + bundle + "aula.ttl " +
                             bundle + "presets.ttl");
    INFO(result.out << result.err);
    CHECK(result.status == 0);
    CHECK((result.out + result.err).find("Found 0 errors") != std::string::npos);
    CHECK((result.out + result.err).find("warning") == std::string::npos);
}

TEST_CASE("lv2apply in freewheel equals the offline rendering of the default room") {
    if (!has("lv2apply")) return;
    const std::string layout = GENERATE(std::string("binaural"), "foa", "toa");
    const TemporaryFolder folder;
    const std::size_t samples = 72000;
    write_clicks(folder, samples);
    const ProgramResult applied = run_host(
        folder, "lv2apply -i clicks.wav -o applied.wav -c freewheel 1 urn:aula:room#" + layout);
    INFO(applied.err);
    REQUIRE(applied.status == 0);
    const fs::path offline = folder.path() / "offline.wav";
    REQUIRE(run_program({AULA_PROGRAM, kDefaultRoom, "--offline", offline, "--output", layout,
                         "--duration", "1.5"})
                .status == 0);
    const std::vector<float> plugin = wav_samples(folder.path() / "applied.wav");
    const std::vector<float> program = wav_samples(offline);
    const std::size_t channels = layout == "binaural" ? 2 : layout == "foa" ? 4 : 16;
    REQUIRE(plugin.size() == channels * samples);
    REQUIRE(program.size() == plugin.size());
    float largest = 0;
    float difference = 0;
    for (std::size_t n = 0; n < plugin.size(); ++n) {
        largest = std::max(largest, std::abs(program[n]));
        difference = std::max(difference, std::abs(plugin[n] - program[n]));
    }
    CHECK(largest > 0.1F);
    CHECK(difference < 1e-6F);
}

TEST_CASE("ffmpeg renders through the plugin") {
    if (!has("ffmpeg")) return;
    const TemporaryFolder folder;
    write_clicks(folder, 24000);
    const ProgramResult result =
        run_host(folder,
                 "ffmpeg -loglevel error -i clicks.wav -af "
                 "'lv2=p=urn\\\\:aula\\\\:room#binaural:c=freewheel=1' -c:a pcm_f32le out.wav");
    INFO(result.err);
    REQUIRE(result.status == 0);
    const std::vector<float> output = wav_samples(folder.path() / "out.wav");
    const auto is_loud = [](float x) { return std::abs(x) > 0.01F; };
    CHECK(std::any_of(output.begin(), output.end(), is_loud));
    CHECK(std::all_of(output.begin(), output.end(), [](float x) { return std::isfinite(x); }));
}

TEST_CASE("A host lists the presets of the bundle") {
    if (!has("lv2info")) return;
    const TemporaryFolder folder;
    const ProgramResult info = run_host(folder, "lv2info 'urn:aula:room#binaural'");
    INFO(info.out << info.err);
    REQUIRE(info.status == 0);
    const std::size_t begin = info.out.find("Presets:");
    REQUIRE(begin != std::string::npos);
    const std::string presets = info.out.substr(begin, info.out.find("Port 0:") - begin);
    CHECK(std::count(presets.begin(), presets.end(), '\n') >= 9);
    CHECK(presets.find("Tiled Bathroom") != std::string::npos);
}

TEST_CASE("A preset that places the listener does not leave its orientation to the scene") {
    const std::string presets = read_file(AULA_BUNDLES "/aula.lv2/presets.ttl");
    // The value of a port in the preset of the bright room, whose scene has another orientation.
    const std::size_t preset = presets.find("Bright Room");
    const std::size_t yaw = presets.find("\"listener_yaw\"", preset);
    const std::string value = "pset:value ";
    const std::size_t at = presets.find(value, yaw);
    REQUIRE(at != std::string::npos);
    const float degrees = std::stof(presets.substr(at + value.size()));
    CHECK(degrees != 0);  // 0 is the orientation of the scene
    CHECK(std::abs(degrees) < 1);
    // It resets the shares of the room: its places are those in metres.
    const std::size_t end = presets.find("pset:Preset", preset);
    CHECK(presets.find("\"source_room_x\"", preset) < end);
    CHECK(presets.find("\"listener_room_z\"", preset) < end);
}

TEST_CASE("The installed bundle contains its scenes and needs no other folder") {
    const TemporaryFolder folder;
    const ProgramResult result =
        run_host(folder, "cmake --install '" AULA_BUILD_DIR "' --component lv2 --prefix prefix");
    INFO(result.err);
    REQUIRE(result.status == 0);
    const fs::path bundle = folder.path() / "prefix/lib/lv2/aula.lv2";
    for (const std::string file : {"aula.so", "manifest.ttl", "aula.ttl", "presets.ttl",
                                   "scenes/church.json", "scenes/church/church.obj"}) {
        INFO(file);
        CHECK(fs::is_regular_file(fs::symlink_status(bundle / file)));
    }
    CHECK(fs::is_directory(fs::symlink_status(bundle / "scenes")));
    // Every scene of a preset is there.
    const std::string presets = read_file(bundle / "presets.ttl");
    for (std::size_t at = presets.find("<scenes/"); at != std::string::npos;
         at = presets.find("<scenes/", at + 1)) {
        const std::string file = presets.substr(at + 1, presets.find('>', at) - at - 1);
        INFO(file);
        CHECK(fs::is_regular_file(bundle / file));
    }
}

TEST_CASE("The binary needs no library of audio devices and exports its entry point only") {
    if (!has("readelf")) return;
    const TemporaryFolder folder;
    const ProgramResult needed = run_host(folder, "readelf -d '" AULA_PLUGIN_BINARY "'");
    REQUIRE(needed.status == 0);
    for (const std::string library : {"portaudio", "jack", "asound", "libGL", "epoxy", "glfw"}) {
        INFO(library);
        CHECK(needed.out.find(library) == std::string::npos);
    }
    CHECK(needed.out.find("NODELETE") != std::string::npos);
    const ProgramResult symbols = run_host(folder, "nm -D --defined-only '" AULA_PLUGIN_BINARY "'");
    REQUIRE(symbols.status == 0);
    CHECK(std::count(symbols.out.begin(), symbols.out.end(), '\n') == 1);
    CHECK(symbols.out.find("lv2_descriptor") != std::string::npos);
}
