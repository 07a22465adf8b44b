#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>

#include "aula/audio/sound_file.h"
#include "tests/support/program.h"
#include "tests/support/small_scenes.h"
#include "tests/support/wait.h"

namespace {

using namespace aula::test;

void require_ok(const ProgramResult& result) {
    INFO(result.err);
    REQUIRE(result.status == 0);
}

/// True once the program has created a file in a folder; false if it ends before.
bool file_appears(const std::filesystem::path& folder, Program& program) {
    return eventually([&] { return !names_in(folder).empty() || !program.running(); }) &&
           !names_in(folder).empty();
}

}  // namespace

TEST_CASE("The same seed renders the same bytes, with one thread and with two") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const auto render = [&](const std::string& name, std::vector<std::string> options) {
        const std::string out = folder.path() / name;
        options.insert(options.begin(), {AULA_PROGRAM, scene, "--offline", out});
        require_ok(run_program(options));
        return read_file(out);
    };
    const std::string one = render("one.wav", {"--threads", "1", "--duration", "0.6"});
    const std::string two = render("two.wav", {"--threads", "2", "--duration", "0.6"});
    const std::string again = render("again.wav", {"--threads", "2", "--duration", "0.6"});
    const std::string other = render("other.wav", {"--seed", "2", "--duration", "0.6"});
    // 0.6 s of two channels of 32-bit floats at 48 kHz.
    REQUIRE(one.size() > 230'400);
    REQUIRE((one == two));
    REQUIRE((two == again));
    REQUIRE_FALSE((one == other));
}

TEST_CASE("A rendering lasts as long as the walk and the tail, or exactly the given duration") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::string out = folder.path() / "out.wav";
    require_ok(run_program({AULA_PROGRAM, scene, "--offline", out, "--output", "mono"}));
    // The walk, the fade-out of the noise and the length of the response.
    REQUIRE(aula::sound_info(out).samples == Approx(48000 * (1 + 0.02 + 0.5)).margin(1));
    REQUIRE(aula::sound_info(out).channels == 1);
    require_ok(run_program({AULA_PROGRAM, scene, "--offline", out, "--output", "foa", "--duration",
                            "0.25", "--sample-rate", "44100"}));
    REQUIRE(aula::sound_info(out).samples == 11025);
    REQUIRE(aula::sound_info(out).channels == 4);
    REQUIRE(aula::sound_info(out).sample_rate_hz == 44100);
}

TEST_CASE("Rendered PCM is not delayed by the limiter") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("free.json", kFreeField);
    const auto first_sound = [&](const std::string& format) {
        const std::string out = folder.path() / "out.wav";
        require_ok(run_program(
            {AULA_PROGRAM, scene, "--offline", out, "--output", "mono", "--format", format}));
        const auto samples = aula::read_sound(out, 48000).samples;
        std::size_t loudest = 0;
        for (std::size_t i = 0; i < samples.size(); ++i)
            if (std::abs(samples[i]) > std::abs(samples[loudest])) loudest = i;
        return loudest;
    };
    // 3.432 m at 343.2 m/s are 480 samples.
    REQUIRE(first_sound("float") == 480);
    REQUIRE(first_sound("pcm24") == 480);
}

TEST_CASE("PCM is dithered by --seed, and not at all with --no-dither") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("free.json", kFreeField);
    // Samples of the 480 before the direct sound that are not 0.
    const auto noise = [&](std::vector<std::string> options) {
        const std::string out = folder.path() / "out.wav";
        options.insert(options.begin(), {AULA_PROGRAM, scene, "--offline", out, "--output", "mono",
                                         "--format", "pcm16"});
        require_ok(run_program(options));
        auto samples = aula::read_sound(out, 48000).samples;
        samples.resize(470);
        return samples;
    };
    const std::vector<float> silence(470);
    REQUIRE(noise({"--no-dither"}) == silence);
    REQUIRE(noise({}) != silence);
    REQUIRE(noise({}) == noise({"--seed", "1"}));
    REQUIRE(noise({}) != noise({"--seed", "2"}));
}

TEST_CASE("An interrupted program leaves no file and exits with 128 + signal number") {
    const TemporaryFolder scenes;
    const std::string scene = scenes.write("room.json", kSmallRoom);
    const auto interrupt = [&](const std::vector<std::string>& options, int signal) {
        const TemporaryFolder outputs;
        std::vector<std::string> command{AULA_PROGRAM, scene};
        for (const std::string& option : options)
            command.push_back(option == "OUT" ? (outputs.path() / "out").string() : option);
        Program program(command);
        REQUIRE(file_appears(outputs.path(), program));
        program.signal(signal);
        const ProgramResult result = program.wait();
        INFO(result.err);
        CHECK(names_in(outputs.path()).empty());
        return result.status;
    };
    const std::vector<std::string> render{"--offline", "OUT", "--duration", "100000"};
    CHECK(interrupt(render, SIGINT) == 130);
    CHECK(interrupt(render, SIGTERM) == 143);
    CHECK(interrupt(render, SIGXCPU) == 152);  // the limit of CPU time
    CHECK(interrupt({"--echogram", "OUT", "--frames", "1000000"}, SIGINT) == 130);
}

TEST_CASE("One signal ends the program within a frame, and leaves no file") {
    const TemporaryFolder folder;
    const TemporaryFolder outputs;
    // Lossless walls: a frame of 200,000 rays takes minutes.
    std::string lossless = kSmallRoom;
    const std::string absorption = R"("absorption": 0.3)";
    lossless.replace(lossless.find(absorption), absorption.size(), R"("absorption": 0)");
    const std::string scene = folder.write("room.json", lossless);
    for (const std::vector<std::string>& options :
         {std::vector<std::string>{"--offline", "out.wav"}, {"--echogram", "out.csv"}}) {
        for (const int signal : {SIGINT, SIGTERM}) {
            Program program({AULA_PROGRAM, scene, options[0], outputs.path() / options[1], "--rays",
                             "200000", "--estimator", "pt", "--threads", "1", "--ir-length", "10"});
            REQUIRE(file_appears(outputs.path(), program));
            program.signal(signal);
            const auto sent = std::chrono::steady_clock::now();
            REQUIRE(eventually([&] { return !program.running(); }));
            // A second; more only on a busy machine.
            CHECK(std::chrono::steady_clock::now() - sent < std::chrono::seconds(5));
            const ProgramResult result = program.wait();
            INFO(result.err);
            CHECK(result.status == 128 + signal);
            CHECK_FALSE(result.by_signal);
            CHECK(names_in(outputs.path()).empty());
        }
    }
}

TEST_CASE("One signal ends a program that is reading its scene") {
    const TemporaryFolder folder;
    const TemporaryFolder outputs;
    const std::string out = outputs.path() / "out.wav";
    const std::string scene = std::filesystem::canonical(folder.write("room.json", kSmallRoom));
    const std::string blocked = scene + ".blocked";
    for (const std::vector<std::string>& arguments : {std::vector<std::string>{"check", scene},
                                                      {"info", scene},
                                                      {scene, "--offline", out},
                                                      {scene, "--ir", out},
                                                      {scene, "--no-window", "--device", "none"}}) {
        // The file's disk does not answer.
        std::vector<std::string> command{"env", "LD_PRELOAD=" AULA_BLOCKED_READ,
                                         "AULA_BLOCKED_FILE=" + scene, AULA_PROGRAM};
        command.insert(command.end(), arguments.begin(), arguments.end());
        Program program(command);
        REQUIRE(eventually([&] { return std::filesystem::exists(blocked); }));
        program.signal(SIGTERM);
        const auto sent = std::chrono::steady_clock::now();
        CHECK(eventually([&] { return !program.running(); }));
        CHECK(std::chrono::steady_clock::now() - sent < std::chrono::seconds(5));
        const ProgramResult result = program.wait();
        INFO(arguments[0] << " " << arguments[1] << ": " << result.err);
        CHECK(result.status == 128 + SIGTERM);
        CHECK(names_in(outputs.path()).empty());
        REQUIRE(std::filesystem::remove(blocked));
    }
}

TEST_CASE("A closed pipe and the file size limit end the program with one line") {
    const TemporaryFolder folder;
    const TemporaryFolder outputs;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::string out = outputs.path() / "out.wav";
    const auto in_shell = [&](const std::string& script) {
        const ProgramResult result = run_program({"bash", "-c", script, AULA_PROGRAM, scene, out});
        INFO(result.err);
        CHECK(result.status == 1);
        CHECK(result.err.rfind("aula: ", 0) == 0);
        CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
        CHECK(names_in(outputs.path()).empty());
    };
    // More rows than a pipe holds.
    in_shell(R"(set -o pipefail
                "$0" "$1" --frames 1 --ir "$2" --echogram /dev/stdout --bin-ms 0.1 | head -1 >/dev/null)");
    in_shell(R"(ulimit -f 8; exec "$0" "$1" --offline "$2")");
}

TEST_CASE("An output file does not take the number of a closed standard descriptor") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const auto response = [&](const std::string& name, const std::string& closed) {
        const std::string out = folder.path() / name;
        require_ok(run_program({"bash", "-c", "exec \"$0\" \"$1\" --frames 1 --ir \"$2\" " + closed,
                                AULA_PROGRAM, scene, out}));
        return read_file(out);
    };
    const std::string expected = response("open.wav", "");
    CHECK(expected.size() > 1000);
    CHECK((response("out.wav", "1>&-") == expected));
    CHECK((response("all.wav", "0<&- 1>&- 2>&-") == expected));
    // A table for a closed standard output is lost.
    const ProgramResult lost = run_program(
        {"bash", "-c", "exec \"$0\" \"$1\" --frames 1 --report 1>&-", AULA_PROGRAM, scene});
    CHECK(lost.status == 1);
    CHECK(lost.err.find("standard output: cannot write") != std::string::npos);
}

// The address sanitizer needs more address space than the limit allows.
#ifndef __SANITIZE_ADDRESS__
TEST_CASE("A refused thread is reported with one line, and leaves no file") {
    const TemporaryFolder folder;
    const TemporaryFolder outputs;
    const std::string scene = folder.write("room.json", kSmallRoom);
    for (const std::string mode : {"--offline", "--ir"}) {
        // Stacks of 8 MB: 1024 threads need 8 GB.
        const ProgramResult result =
            run_program({"bash", "-c",
                         "ulimit -s 8192; ulimit -v 4000000; exec \"$0\" \"$1\" \"$2\" \"$3\" "
                         "--threads 1024 --frames 1",
                         AULA_PROGRAM, scene, mode, outputs.path() / "out.wav"});
        INFO(result.err);
        CHECK(result.status == 1);
        CHECK(result.err.starts_with("aula: thread "));
        CHECK(
            result.err.ends_with(" of 1024 cannot be started: Resource temporarily unavailable; "
                                 "expected fewer threads\n"));
        CHECK(names_in(outputs.path()).empty());
    }
}
#endif
