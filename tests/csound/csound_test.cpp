#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <string>
#include <tuple>
#include <vector>

#include "tests/pd/two_sounds.h"
#include "tests/plugin/host_commands.h"
#include "tests/support/program.h"

// Runs the opcodes in Csound.

namespace {

using namespace aula::test;

const std::string kRoom = R"(giRoom aularoom "room.json")";
const std::string kPlay = R"(
    aVoice soundin "a.wav"
    aRadio soundin "b.wav"
    aLeft, aRight aula giRoom, aVoice, aRadio
    outs aLeft, aRight)";

/// A piece of an instrument and its notes.
std::string piece(const std::string& header, const std::string& instrument, int channels = 2,
                  const std::string& notes = "i 1 0 0.6") {
    return "<CsoundSynthesizer>\n<CsInstruments>\nsr = 48000\nksmps = 64\nnchnls = " +
           std::to_string(channels) + "\n" + header + "\ninstr 1\n" + instrument +
           "\nendin\n</CsInstruments>\n<CsScore>\n" + notes +
           "\n</CsScore>\n</CsoundSynthesizer>\n";
}

/// Plays a piece, by default to out.wav.
ProgramResult play(const TemporaryFolder& folder, const std::string& text,
                   const std::string& options = "-o out.wav") {
    folder.write("piece.csd", text);
    ProgramResult result =
        run_host(folder, "timeout 120 csound -d -m0 -W -f --opcode-lib='" AULA_CSOUND_OPCODES "' " +
                             options + " piece.csd");
    result.err = result.out + result.err;
    return result;
}

}  // namespace

TEST_CASE("A room in Csound gives the samples of aula --offline") {
    if (!has("csound")) return;
    const TemporaryFolder folder;
    write_two_sounds(folder);
    // Full scale is 32768 by default.
    for (const std::string full_scale : {"", "0dbfs = 1\n"}) {
        REQUIRE(play(folder, piece(full_scale + kRoom, kPlay)).status == 0);
        CHECK(difference_from_offline(folder, 2) < 1e-6F);
    }
    for (const auto& [output, channels, outputs] :
         {std::tuple{"binaural", 2, "a1, a2"}, std::tuple{"mono", 1, "a1"},
          std::tuple{"foa", 4, "a1, a2, a3, a4"},
          std::tuple{"toa", 16,
                     "a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a12, a13, a14, a15, a16"}}) {
        INFO(output);
        const std::string room = std::string(R"(giRoom aularoom "room.json", ")") + output + '"';
        // The outputs have the variables of the inputs.
        const std::string instrument = std::string("a1 soundin \"a.wav\"\na2 soundin \"b.wav\"\n") +
                                       outputs + " aula giRoom, a1, a2\noutc " + outputs;
        REQUIRE(play(folder, piece(room, instrument, channels)).status == 0);
        CHECK(difference_from_offline(folder, static_cast<std::size_t>(channels), output) < 1e-6F);
    }
}

TEST_CASE("A note begins and ends at a sample of a room in Csound") {
    if (!has("csound")) return;
    const TemporaryFolder folder;
    write_two_sounds(folder);
    REQUIRE(play(folder, piece(kRoom, kPlay, 2, "i 1 [100/48000] [26317/48000]"),
                 "--sample-accurate -o out.wav")
                .status == 0);
    const std::vector<float> late = wav_samples(folder.path() / "out.wav");
    REQUIRE(play(folder, piece(kRoom, kPlay)).status == 0);
    const std::vector<float> early = wav_samples(folder.path() / "out.wav");
    const std::size_t begin = 2 * 100;
    const std::size_t end = begin + std::size_t{2} * 26317;
    REQUIRE(late.size() >= end);
    CHECK(std::equal(late.begin() + begin, late.begin() + static_cast<std::ptrdiff_t>(end),
                     early.begin()));
    for (std::size_t n = 0; n < late.size(); ++n)
        if (n < begin || n >= end) REQUIRE(late[n] == 0);
}

TEST_CASE("aulasource and aulalistener move sources and the listener") {
    if (!has("csound")) return;
    const TemporaryFolder folder;
    write_two_sounds(folder);
    const std::string moves = R"(
        aulasource giRoom, "voice", 1, 1.5, 1.25
        kYaw init 45
        aulalistener giRoom, 3, 2, 1.5, kYaw
        aVoice soundin "a.wav"
        aRadio soundin "b.wav"
        aLeft, aRight aula giRoom, aVoice, aRadio * ampdb(-17)
        outs aLeft, aRight)";
    REQUIRE(play(folder, piece(kRoom, moves)).status == 0);
    CHECK(difference_from_offline(folder, 2) > 1e-3F);
    write_moved_sounds(folder);
    // Angles and gains are rounded elsewhere.
    CHECK(difference_from_offline(folder, 2) < 3e-5F);
}

TEST_CASE("A room in Csound waits for the propagation only where sound goes to a named file") {
    if (!has("csound")) return;
    const TemporaryFolder folder;
    write_two_sounds(folder);
    // The first frame takes about a tenth of a second: longer than the bound below, and less than
    // the whole piece where Csound does not wait.
    std::string scene = read_file(folder.path() / "room.json");
    const std::string rays = "\"rays\": 100,";
    scene.replace(scene.find(rays), rays.size(), "\"rays\": 10000,");
    folder.write("room.json", scene);
    // Until the sound is heard.
    const std::string heard = R"(
        aNoise noise 0.1, 0
        aLeft, aRight aula giRoom, aNoise, aNoise
        fout "heard.wav", 16, aLeft, aRight
        kPeak peak aLeft
        if kPeak > 0.01 then
            event "e", 0, 0
        endif
        outs aLeft, aRight)";
    for (const auto& [options, clock, waits] :
         {std::tuple{"-o out.wav", "-1", true}, std::tuple{"-o dac.wav", "-1", true},
          std::tuple{"-o out.wav", "0", false}, std::tuple{"-o dac -+rtaudio=null", "-1", false},
          std::tuple{"-o dac:1 -+rtaudio=null", "-1", false},
          std::tuple{"-o dac -+rtaudio=null", "1", true},
          std::tuple{"-o devaudio -+rtaudio=null", "-1", false},
          std::tuple{"-o out.wav -i adc -+rtaudio=null", "-1", false},
          // As in a host that plays the sound: no name.
          std::tuple{"", "-1", false}, std::tuple{"-n", "-1", false}}) {
        INFO(options << ", clock " << clock);
        const std::string room =
            std::string(R"(giRoom aularoom "room.json", "binaural", )") + clock;
        const ProgramResult result =
            play(folder, piece("0dbfs = 1\n" + room, heard, 2, "i 1 0 600"), options);
        INFO(result.err);
        CHECK(result.status == 0);
        const std::vector<float> sound = wav_samples(folder.path() / "heard.wav");
        REQUIRE(!sound.empty());
        CHECK(*std::max_element(sound.begin(), sound.end()) > 0.01F);
        // The sound of the voice, 2 m away, comes after 256 + 280 samples if they are waited for.
        CHECK((sound.size() < std::size_t{2} * 1024) == waits);
    }
}

TEST_CASE("Csound fails with a line about what its room cannot use") {
    if (!has("csound")) return;
    const TemporaryFolder folder;
    write_two_sounds(folder);
    for (const auto& [header, instrument, message] :
         {std::tuple{R"(giRoom aularoom "nowhere.json")", "", "nowhere.json: no such file"},
          std::tuple{R"(giRoom aularoom "room.json", "loud")", "", "unknown output \"loud\""},
          std::tuple{R"(giRoom aularoom "room.json", "mono", 2)", "", "unknown clock 2"},
          std::tuple{"", "a1, a2 aula 7, a(0), a(0)", "there is no room 7"},
          std::tuple{kRoom.c_str(), "a1, a2 aula giRoom, a(0)", "inputs is 1; expected 2"},
          std::tuple{kRoom.c_str(), "a1 aula giRoom, a(0), a(0)", "outputs is 1; expected 2"},
          std::tuple{kRoom.c_str(),
                     "a1, a2 aula giRoom, a(0), a(0)\na1, a2 aula giRoom, a(0), a(0)",
                     "another aula plays room 1"},
          std::tuple{kRoom.c_str(), "aulasource giRoom, \"nobody\", 1, 1, 1",
                     "no source \"nobody\""},
          std::tuple{kRoom.c_str(), "aulasource giRoom, \"voice\", 1e30, 1, 1",
                     "a position is not within"},
          std::tuple{kRoom.c_str(), "aulalistener giRoom + 1, 1, 1, 1", "there is no room 2"}}) {
        const ProgramResult result = play(folder, piece(header, instrument, 2, "i 1 0 0.1"));
        INFO(result.err);
        CHECK(result.status != 0);
        CHECK(result.err.find(message) != std::string::npos);
    }
}

TEST_CASE("Rooms in Csound end with the instruments that made them") {
    if (!has("csound")) return;
    const TemporaryFolder folder;
    write_two_sounds(folder);
    const std::string room =
        "iRoom aularoom \"room.json\"\nprint iRoom\n"
        "a1, a2 aula iRoom, a(0), a(0)\nouts a1, a2";
    const ProgramResult result =
        play(folder, piece("", room, 2, "i 1 0 0.1\ni 1 0.05 0.1\ni 1 0.3 0.1"));
    INFO(result.err);
    CHECK(result.status == 0);
    CHECK(result.err.find("iRoom = 3.000") != std::string::npos);
}

TEST_CASE("A note in Csound plays and ends its own room, whatever its variable has become") {
    if (!has("csound")) return;
    const TemporaryFolder folder;
    write_two_sounds(folder);
    const std::string overlapping = R"(
        giRoom aularoom "room.json"
        aulasource giRoom, "voice", 1, 1.5, 1.25
        aulalistener giRoom, 3, 2, 1.5
        a1, a2 aula giRoom, a(0), a(0)
        outs a1, a2)";
    ProgramResult result =
        play(folder, piece("giRoom init 0", overlapping, 2, "i 1 0 0.3\ni 1 0.1 0.4"));
    INFO(result.err);
    CHECK(result.status == 0);

    // Another instrument uses rooms that have ended: one error for each of its notes.
    const std::string look = "\nendin\ninstr 2\na1, a2 aula p4, a(0), a(0)\nouts a1, a2";
    const std::string overwritten = R"(
        iRoom aularoom "room.json"
        a1, a2 aula iRoom, a(0), a(0)
        iRoom = 99
        outs a1, a2)";
    result = play(folder, piece("", overwritten + look, 2, "i 1 0 0.1\ni 2 0.2 0.1 1"));
    INFO(result.err);
    CHECK(result.status == 1);
    CHECK(result.err.find("there is no room 1") != std::string::npos);

    const std::string again = R"(
        kPeriod init 0
        kPeriod += 1
        if kPeriod % 50 == 0 then
            reinit pass
        endif
        pass:
        iRoom aularoom "room.json"
        print iRoom
        a1, a2 aula iRoom, a(0), a(0)
        rireturn
        outs a1, a2)";
    // 0.2 s have 150 periods.
    result = play(folder, piece("", again + look, 2,
                                "i 1 0 0.2\ni 2 0.19 0.1 1\ni 2 0.19 0.1 2\ni 2 0.3 0.1 3"));
    INFO(result.err);
    CHECK(result.status == 3);
    CHECK(result.err.find("iRoom = 3.000") != std::string::npos);
    for (const char* number : {"1", "2", "3"})
        CHECK(result.err.find(std::string("there is no room ") + number) != std::string::npos);
}

TEST_CASE("The piece of docs/hosts.md plays") {
    if (!has("csound")) return;
    const TemporaryFolder folder;
    const std::string page = read_file(AULA_SOURCE_DIR "/docs/hosts.md");
    const std::size_t begin = page.find("<CsoundSynthesizer>");
    const std::string end = "</CsoundSynthesizer>\n";
    REQUIRE(begin != std::string::npos);
    const std::string text = page.substr(begin, page.find(end) + end.size() - begin);
    const ProgramResult result =
        play(folder, text, "--env:SSDIR='" AULA_SOURCE_DIR "/scenes' -o out.wav");
    INFO(result.err);
    REQUIRE(result.status == 0);
    const std::vector<float> sound = wav_samples(folder.path() / "out.wav");
    const float peak = *std::max_element(sound.begin(), sound.end());
    CHECK(peak > 0.05F);
    CHECK(peak < 1);
}

TEST_CASE("The opcodes of Csound export what Csound calls alone") {
    if (!has("nm")) return;
    const ProgramResult result =
        run_program({"nm", "-D", "--defined-only", "--format=just-symbols", AULA_CSOUND_OPCODES});
    CHECK(result.out == "csoundModuleInfo\ncsound_opcode_init\n");
}
