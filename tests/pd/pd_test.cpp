#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/pd/two_sounds.h"
#include "tests/plugin/host_commands.h"

// Runs aula~ in Pure Data.

namespace {

using namespace aula::test;

/// A patch that plays both sounds from its first sample on through an object of two outputs, which
/// first receives messages, and records 0.6 s of it in out.wav.
std::string patch(const std::string& object, const std::string& messages = "") {
    return "#N canvas 0 0 600 400 12;\n"
           "#X obj 10 10 loadbang;\n"                                        // 0
           "#X obj 10 40 t b b b b;\n"                                       // 1
           "#X msg 400 70 read -resize a.wav a \\, read -resize b.wav b;\n"  // 2
           "#X obj 400 100 soundfiler;\n"                                    // 3
           "#X obj 500 10 table a;\n"                                        // 4
           "#X obj 500 40 table b;\n"                                        // 5
           "#X msg 200 70 open -bytes 4 out.wav \\, start \\; pd dsp 1;\n"   // 6
           "#X obj 10 100 tabplay~ a;\n"                                     // 7
           "#X obj 100 100 tabplay~ b;\n"                                    // 8
           "#X obj 10 200 " +
           object +
           ";\n"                           // 9
           "#X obj 10 250 writesf~ 2;\n"   // 10
           "#X obj 10 70 del 600;\n"       // 11
           "#X msg 10 150 stop;\n"         // 12
           "#X obj 60 150 del 10;\n"       // 13
           "#X msg 60 180 \\; pd quit;\n"  // 14
           "#X msg 300 150 " +
           messages +
           ";\n"  // 15
           "#X connect 0 0 1 0;\n#X connect 1 3 2 0;\n#X connect 2 0 3 0;\n"
           "#X connect 1 2 15 0;\n#X connect 15 0 9 0;\n"
           "#X connect 1 1 6 0;\n#X connect 6 0 10 0;\n"
           "#X connect 1 0 7 0;\n#X connect 1 0 8 0;\n#X connect 1 0 11 0;\n"
           "#X connect 7 0 9 0;\n#X connect 8 0 9 1;\n"
           "#X connect 9 0 10 0;\n#X connect 9 1 10 1;\n"
           "#X connect 11 0 12 0;\n#X connect 12 0 10 0;\n#X connect 11 0 13 0;\n"
           "#X connect 13 0 14 0;\n";
}

/// What Pd says while it plays a patch; in real time without `batch`.
std::string play(const TemporaryFolder& folder, const std::string& text,
                 const std::string& batch = "-batch") {
    folder.write("patch.pd", text);
    const ProgramResult result =
        run_host(folder, "timeout 120 pd -nogui -noaudio " + batch +
                             " -stderr -r 48000 -path '" AULA_PD_FOLDER "' -open patch.pd");
    CHECK(result.status == 0);
    return result.out + result.err;
}

}  // namespace

TEST_CASE("aula~ with -exact gives the samples of aula --offline") {
    if (!has("pd")) return;
    const TemporaryFolder folder;
    write_two_sounds(folder);
    CHECK(play(folder, patch("aula~ -exact room.json voice radio")).find("aula~") ==
          std::string::npos);
    CHECK(difference_from_offline(folder, 2) < 1e-6F);
    // Without names, all sources of the scene.
    CHECK(play(folder, patch("aula~ -exact room.json")).find("aula~") == std::string::npos);
    CHECK(difference_from_offline(folder, 2) < 1e-6F);
    // Inlets in another order, and two of the four channels of ambisonics.
    play(folder, patch("aula~ -foa -exact room.json radio voice"));
    CHECK(difference_from_offline(folder, 2, "foa") > 1e-3F);
}

TEST_CASE("Messages to aula~ move sources and the listener, and set gains") {
    if (!has("pd")) return;
    const TemporaryFolder folder;
    write_two_sounds(folder);
    play(folder, patch("aula~ -exact room.json voice radio",
                       "source voice 1 1.5 1.25 \\, listener 3 2 1.5 45 0 0 \\, gain radio -20"));
    CHECK(difference_from_offline(folder, 2) > 1e-3F);
    write_moved_sounds(folder);
    // The rounding of the angle moves samples by less than the noise of 16 bits.
    CHECK(difference_from_offline(folder, 2) < 3e-5F);
}

TEST_CASE("aula~ plays in real time, and says what it cannot use") {
    if (!has("pd")) return;
    const TemporaryFolder folder;
    write_two_sounds(folder);
    const std::string said =
        play(folder,
             patch("aula~ room.json voice radio",
                   "source nobody 1 1 1 \\, source voice 1 \\, listener 1 2 x \\, gain voice \\, "
                   "source voice 1e30 0 0 \\, source voice 1.5 2 1.5"),
             "");
    INFO(said);
    CHECK(said.find("no inlet has the source \"nobody\"") != std::string::npos);
    CHECK(said.find("source: expected three coordinates") != std::string::npos);
    CHECK(said.find("listener: expected three coordinates") != std::string::npos);
    CHECK(said.find("gain: expected a number of decibels") != std::string::npos);
    const std::vector<float> sound = wav_samples(folder.path() / "out.wav");
    CHECK(*std::max_element(sound.begin(), sound.end()) > 0.01F);
    for (const auto& [object, message] :
         {std::pair{"aula~", "expected a scene file"},
          std::pair{"aula~ -exact", "expected a scene file"},
          std::pair{"aula~ nowhere.json voice", "nowhere.json"},
          std::pair{"aula~ room.json nobody", "no source \"nobody\""},
          std::pair{"aula~ room.json voice voice", "two inlets for the source voice"},
          std::pair{"aula~ -loud room.json voice", "unknown flag -loud"},
          std::pair{"aula~ 3", "a number among the arguments"}}) {
        const std::string errors = play(folder, patch(object));
        INFO(object << ": " << errors);
        CHECK(errors.find(message) != std::string::npos);
    }
}

TEST_CASE("The help of aula~ opens without an error") {
    if (!has("pd")) return;
    const TemporaryFolder folder;
    const ProgramResult result =
        run_host(folder, "timeout 120 pd -nogui -noaudio -batch -stderr -open '" AULA_PD_FOLDER
                         "/aula~-help.pd' -send '; pd quit'");
    INFO(result.err);
    CHECK(result.status == 0);
    CHECK((result.out + result.err).find("error") == std::string::npos);
    CHECK((result.out + result.err).find("create") == std::string::npos);
}
