#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "apps/capi/include/aula.h"
#include "aula/audio/sound_file.h"
#include "tests/support/jack_server.h"
#include "tests/support/program.h"
#include "tests/support/small_scenes.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait.h"

// Machines and hosts on which Aula has failed.

using namespace aula::test;

namespace {

/// The program, on a machine without a JACK server and with that configuration of ALSA.
ProgramResult without_sound(const std::string& alsa_configuration,
                            const std::vector<std::string>& arguments) {
    std::vector<std::string> command{"env", "ALSA_CONFIG_PATH=" + alsa_configuration,
                                     "JACK_DEFAULT_SERVER=aula-test-no-such-server",
                                     "JACK_NO_START_SERVER=1", AULA_PROGRAM};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run_program(command);
}

}  // namespace

TEST_CASE("Where ALSA's configuration is missing or useless there is no device, and no abort") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::vector<std::string> configurations{
        "/dev/null",
        "/no/such/file",
        // PortAudio asserts that a PCM named "default" or "dmix" remains.
        folder.write("one.conf", "pcm.only { type null }\n"),
        folder.write("number.conf", "pcm 5\n"),
        folder.write("cut.conf", "pcm.default { type\n"),
        folder.write("list.conf", "pcm.default { type null }\npcm.odd { type [ 1 2 ] }\n"),
    };
    for (const std::string& configuration : configurations) {
        CAPTURE(configuration);
        for (const auto& arguments : std::vector<std::vector<std::string>>{
                 {"--list-devices"}, {scene, "--no-window", "--duration", "0.1"}}) {
            const ProgramResult result = without_sound(configuration, arguments);
            INFO(result.err);
            CHECK(result.status == 1);
            CHECK(result.err.starts_with("aula: no audio output device"));
            CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
        }
    }
    // Companion: PortAudio is used where its list has a default.
    const ProgramResult listed = without_sound(
        folder.write("default.conf", "pcm.only { type null }\npcm.default { type null }\n"),
        {"--list-devices"});
    INFO(listed.err);
    CHECK(listed.status == 0);
    CHECK(listed.out.find("default") != std::string::npos);
}

TEST_CASE("A JACK server that returns at another rate is played to at that rate") {
    auto server = std::make_unique<JackServer>(1024);
    if (!server->running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    Program program({AULA_PROGRAM, scene, "--no-window", "--duration", "1000"});
    const auto has_ports = [] {
        return run_program({"jack_lsp"}).out.find("aula:out_1") != std::string::npos;
    };
    REQUIRE(eventually(has_ports));
    const std::string name = std::getenv("JACK_DEFAULT_SERVER");
    server.reset();
    server = std::make_unique<JackServer>(512, 2, 44100);
    if (!server->running() || std::getenv("JACK_DEFAULT_SERVER") != name) {
        WARN("skipped: no second JACK server of the same name can run here");
        return;
    }
    CHECK(eventually(has_ports));
    CHECK(eventually([&] {
        return program.err().find("is available again, at 44100 Hz") != std::string::npos;
    }));
    REQUIRE(program.running());
    program.signal(SIGINT);
    const ProgramResult played = program.wait();
    INFO(played.err);
    CHECK(played.status == 130);
}

TEST_CASE("A sample of 1e38 in a sound file is silence, and is reported") {
    const TemporaryFolder folder;
    const auto render = [&](float sample) {
        const std::string sound = folder.path() / "sound.wav";
        std::vector<float> samples(4800, 0.01F);
        samples[2000] = sample;
        aula::WavWriter writer(sound, 44100, 1, aula::SampleFormat::float32);
        writer.write(samples);
        writer.commit();
        std::string text = kFreeField;
        text.replace(text.find("impulse"), std::strlen("impulse"), "sound.wav");
        const std::string scene = folder.write("scene.json", text);
        const std::string out = folder.path() / "out.wav";
        const ProgramResult result =
            run_program({AULA_PROGRAM, scene, "--offline", out, "--output", "mono"});
        INFO(result.err);
        CHECK(result.status == 0);
        CHECK((result.err.find("1 samples that are not finite, or beyond 1e6") !=
               std::string::npos) == (sample != 0));
        return aula::read_sound(out, 48000).samples;
    };
    const std::vector<float> silent = render(0);
    REQUIRE(std::any_of(silent.begin(), silent.end(), [](float x) { return x != 0; }));
    for (const float sample : {1e38F, -3e38F, 2e6F}) CHECK(render(sample) == silent);
}

TEST_CASE("Names in messages of the C interface are escaped") {
    const auto message_for = [](const char* file) {
        aula_scene* scene = nullptr;
        CHECK(aula_scene_load(file, &scene) == AULA_INPUT_ERROR);
        return std::string(aula_message());
    };
    CHECK(message_for("a\nb").starts_with("a\\x0ab: "));
    CHECK(message_for("a\x1b[31m.json").starts_with("a\\x1b[31m.json: "));
    CHECK(message_for("\xff\xfe\x1b[31m").starts_with("\\xff\\xfe\\x1b[31m: "));
    CHECK(message_for("a\xc2\x9b"
                      "31m")
              .starts_with("a\\xc2\\x9b31m: "));
    // As the program prints it.
    const ProgramResult printed = run_program({AULA_PROGRAM, "./a\nb\x1b[31m", "--no-window"});
    CHECK(printed.err.starts_with("aula: ./a\\x0ab\\x1b[31m: "));
    CHECK(std::count(printed.err.begin(), printed.err.end(), '\n') == 1);
}

TEST_CASE("A room with 1024 sources and 64 listeners is refused before it takes gigabytes") {
    aula_scene* scene = nullptr;
    REQUIRE(aula_scene_create(&scene) == AULA_OK);
    aula_options options{};
    options.size = sizeof(options);
    options.max_sources = 1024;
    options.listeners = 64;
    aula_room* room = nullptr;
    CHECK(aula_room_create(scene, &options, &room) == AULA_INPUT_ERROR);
    CHECK(room == nullptr);
    const std::string message = aula_message();
    INFO(message);
    unsigned long long bytes = 0;
    REQUIRE(std::sscanf(message.c_str(), "auralizer: its renderers take %llu bytes", &bytes) == 1);
    CHECK(bytes > 9'000'000'000);
    CHECK(message.find("max_memory_bytes") != std::string::npos);

    // The number is the bound of the option: one byte less refuses.
    options.max_sources = 4;
    options.listeners = 2;
    options.max_memory_bytes = 1;
    REQUIRE(aula_room_create(scene, &options, &room) == AULA_INPUT_ERROR);
    REQUIRE(std::sscanf(aula_message(), "auralizer: its renderers take %llu bytes", &bytes) == 1);
    options.max_memory_bytes = bytes - 1;
    CHECK(aula_room_create(scene, &options, &room) == AULA_INPUT_ERROR);
    options.max_memory_bytes = bytes;
    CHECK(aula_room_create(scene, &options, &room) == AULA_OK);
    aula_room_destroy(room);
    aula_scene_destroy(scene);
}
