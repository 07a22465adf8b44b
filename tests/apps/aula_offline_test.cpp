#include <signal.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "audio/sound_file.h"
#include "tests/support/program.h"
#include "tests/support/small_scenes.h"
#include "tests/support/wait.h"

namespace {

using namespace aula::test;

void require_ok(const ProgramResult& result) {
    INFO(result.err);
    REQUIRE(result.status == 0);
}

/// Whether a file is being written in a folder.
bool file_comes(const std::filesystem::path& folder, Program& program) {
    return comes([&] { return !names_in(folder).empty() || !program.running(); }) &&
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

TEST_CASE("A rendered walk lasts as long as the walk and the tail, or exactly as long as asked") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::string out = folder.path() / "out.wav";
    require_ok(run_program({AULA_PROGRAM, scene, "--offline", out, "--output", "mono"}));
    // The walk, the fade of the noise, and the response's length.
    REQUIRE(aula::sound_info(out).frames == Approx(48000 * (1 + 0.02 + 0.5)).margin(1));
    REQUIRE(aula::sound_info(out).channels == 1);
    require_ok(run_program({AULA_PROGRAM, scene, "--offline", out, "--output", "foa", "--duration",
                            "0.25", "--sample-rate", "44100"}));
    REQUIRE(aula::sound_info(out).frames == 11025);
    REQUIRE(aula::sound_info(out).channels == 4);
    REQUIRE(aula::sound_info(out).sample_rate_hz == 44100);
}

TEST_CASE("Rendered PCM starts with the sound, not with the limiter's delay") {
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

TEST_CASE("A program that is interrupted leaves no file and says so in its status") {
    const TemporaryFolder scenes;
    const std::string scene = scenes.write("room.json", kSmallRoom);
    const auto interrupt = [&](const std::vector<std::string>& options, int signal) {
        const TemporaryFolder outputs;
        std::vector<std::string> command{AULA_PROGRAM, scene};
        for (const std::string& option : options)
            command.push_back(option == "OUT" ? (outputs.path() / "out").string() : option);
        Program program(command);
        REQUIRE(file_comes(outputs.path(), program));
        program.signal(signal);
        const ProgramResult result = program.wait();
        INFO(result.err);
        CHECK(names_in(outputs.path()).empty());
        return result.status;
    };
    const std::vector<std::string> render{"--offline", "OUT", "--duration", "100000"};
    CHECK(interrupt(render, SIGINT) == 130);
    CHECK(interrupt(render, SIGTERM) == 143);
    CHECK(interrupt({"--echogram", "OUT", "--frames", "1000000"}, SIGINT) == 130);
}

TEST_CASE("A second signal ends the program in the middle of a frame, and no file is left either") {
    const TemporaryFolder folder;
    const TemporaryFolder outputs;
    const std::string scene = folder.write("room.json", kSmallRoom);
    for (const std::vector<std::string>& options :
         {std::vector<std::string>{"--offline", "out.wav"}, {"--echogram", "out.csv"}}) {
        // A frame takes seconds.
        Program program({AULA_PROGRAM, scene, options[0], outputs.path() / options[1], "--rays",
                         "200000", "--estimator", "pt", "--threads", "1"});
        REQUIRE(file_comes(outputs.path(), program));
        // Two at once may be taken for one.
        REQUIRE(comes([&] {
            program.signal(SIGINT);
            return !program.running();
        }));
        const ProgramResult result = program.wait();
        INFO(result.err);
        CHECK(result.by_signal);
        CHECK(result.status == 128 + SIGINT);
        CHECK(names_in(outputs.path()).empty());
    }
}
