#include <sys/prctl.h>
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/aula/aula_program.h"
#include "tests/support/small_scenes.h"

namespace {

using namespace aula::test;
using Catch::Contains;

}  // namespace

TEST_CASE("A damaged file of an unsupported format prints one line, nothing on stdout") {
    const TemporaryFolder folder;
    // libsndfile's reader of SDS prints each block whose first byte is wrong.
    std::string sds = read_file(AULA_SOURCE_DIR "/tests/fuzz/corpus/sound/sds");
    sds.at(21) = '!';
    const std::string tag = std::string("ID3\4\0\0\0\0\0\4", 10) + "none";
    for (const std::string& bytes : {sds, tag + sds, tag + tag + sds}) {
        folder.write("voice.wav", bytes);
        const ProgramResult check = aula_with(
            {"check", folder.write("a.json", with(kSmallRoom, "\"noise\"", "\"voice.wav\""))});
        CHECK(check.status == 2);
        CHECK(check.out.empty());
        CHECK(check.err == "aula: " + (folder.path() / "voice.wav").string() +
                               ": has an unknown format; expected WAV, RF64, W64, AIFF, AU, CAF, "
                               "FLAC, Ogg, MP3 or NIST SPHERE\n");
    }
}

TEST_CASE("A sound file whose decoder crashes, loops or is taken over is one line and status 2") {
    const TemporaryFolder folder;
    const std::string scene =
        folder.write("a.json", with(kSmallRoom, "\"noise\"", "\"voice.wav\""));
    const auto check = [&](const std::string& decoder) {
        folder.write("voice.wav", "fLaC" + decoder);
        return run_program({"/usr/bin/env", "LD_LIBRARY_PATH=" AULA_HOSTILE_DECODER, AULA_PROGRAM,
                            "check", scene});
    };
    std::vector<std::pair<std::string, std::string>> ends{
        {"fail", "crashes"},
        {"loop", "computes for 5 s without an answer"},
        {"grow", "needs more than 1 GiB of memory"}};
    if (prctl(PR_GET_SECCOMP) >= 0)
        ends.emplace_back("call", "makes a system call that is forbidden to it");
    for (const auto& [decoder, end] : ends) {
        const ProgramResult result = check(decoder);
        CHECK(result.status == 2);
        CHECK(result.out.empty());
        CHECK(result.err == "aula: " + (folder.path() / "voice.wav").string() +
                                ": is damaged and cannot be read: the process that reads it " +
                                end + "; expected a sound file\n");
    }
    // A decoder that refuses the file.
    CHECK_THAT(check("none").err, Contains("voice.wav: cannot be read as sound; expected WAV,"));
}

TEST_CASE("Of a damaged MP3 file only the program's own lines are printed") {
    const TemporaryFolder folder;
    const std::string whole = read_file(AULA_SOURCE_DIR "/tests/fuzz/corpus/sound/mp3");
    std::string junk;  // headers of frames without data
    for (int i = 0; i < 100000; ++i) junk += std::string("\xFF\xFB\x90\0", 4);
    std::vector<std::string> all{junk};
    for (std::size_t at = 0; at + 8 < whole.size(); at += whole.size() / 12) {
        all.push_back(whole);
        for (std::size_t i = at; i < at + 8; ++i) all.back()[i] = static_cast<char>(~whole[i]);
    }
    const std::string scene =
        folder.write("a.json", with(kSmallRoom, "\"noise\"", "\"voice.mp3\""));
    int refused = 0;
    for (const std::string& bytes : all) {
        folder.write("voice.mp3", bytes);
        const ProgramResult check = aula_with({"check", scene});
        CHECK((check.status == 0 || check.status == 2));
        refused += check.status == 2 ? 1 : 0;
        std::istringstream lines(check.err);
        for (std::string line; std::getline(lines, line);) CHECK(line.starts_with("aula: "));
    }
    CHECK(refused > 0);
}

TEST_CASE("Under limits of the system the one line has the true reason") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const auto under = [&](const std::string& limit) {
        return run_program(
            {"bash", "-c",
             "ulimit " + limit + "; exec \"$0\" \"$1\" --offline \"$2\" --duration 0.1",
             AULA_PROGRAM, scene, folder.path() / "out.wav"});
    };
    const auto check = [&](const ProgramResult& result, const std::string& reason) {
        INFO(result.err);
        CHECK((result.status == 1 || result.status == 2));
        CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
        CHECK_THAT(result.err, Contains(reason));
        CHECK(names_in(folder.path()) == std::vector<std::string>{"room.json"});
    };
    // The fewest descriptors with which the program's libraries can be loaded.
    constexpr int kNotStarted = 127;
    int descriptors = 4;
    ProgramResult result = under("-n 4");
    while (result.status == kNotStarted && descriptors < 64)
        result = under("-n " + std::to_string(++descriptors));
    check(result, "Too many open files");
    // The address sanitizer needs more address space.
#ifndef __SANITIZE_ADDRESS__
    check(under("-v 200000"), "memory");
#endif
}

TEST_CASE("A name too long for an output is refused before anything is computed") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::string name = folder.path() / std::string(256, 'n');
    for (const auto& output :
         std::vector<std::vector<std::string>>{{"--offline", name, "--duration", "100000"},
                                               {"--ir", name, "--frames", "1000000"},
                                               {"--echogram", name, "--frames", "1000000"},
                                               {"--report=" + name, "--frames", "1000000"}}) {
        std::vector<std::string> arguments{scene};
        arguments.insert(arguments.end(), output.begin(), output.end());
        require_refused(folder, arguments, {"too long"});
    }
}

TEST_CASE("Invalid arguments are refused with one line and status 2") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::string out = folder.path() / "out.wav";
    struct Bad {
        std::vector<std::string> arguments;
        std::vector<std::string> parts;
    };
    const std::vector<Bad> all = {
        {{}, {"SCENE"}},
        {{scene, scene}, {"one argument too many"}},
        {{"check"}, {"SCENE"}},
        {{scene, "--no-such-option"}, {"\"--no-such-option\" is not known"}},
        {{scene, "--rays"}, {"--rays: has no value"}},
        {{scene, "--rays", "5", "--rays", "6"}, {"--rays: is given more than once"}},
        {{scene, "--report="}, {"--report", "name of a file"}},
        {{scene, "--report", "--speech-level", "60,70"}, {"--speech-level", "60,70", "8"}},
        {{scene, "--report", "--noise-level", "loud"}, {"--noise-level", "loud", "octave"}},
        {{scene, "--offline", out, "--quality", "best"},
         {"--quality", "\"best\"", "draft, normal, fine"}},
        {{scene, "--offline", out, "--rays", "0"}, {"--rays", "\"0\"", "from 1"}},
        {{scene, "--offline", out, "--rays", "many"}, {"--rays", "\"many\"", "whole number"}},
        {{scene, "--offline", out, "--rays", "10.5"}, {"--rays", "10.5"}},
        {{scene, "--offline", out, "--seed", "-1"}, {"--seed", "-1"}},
        {{scene, "--offline", out, "--response-time", "nan"}, {"--response-time"}},
        {{scene, "--offline", out, "--ir-length", "11"}, {"--ir-length", "at most 10"}},
        {{scene, "--offline", out, "--duration", "0"}, {"--duration", "above 0"}},
        {{scene, "--offline", out, "--estimator", "magic"}, {"--estimator", "dpc-published"}},
        {{scene, "--offline", out, "--output", "stereo"}, {"--output", "binaural"}},
        {{scene, "--offline", out, "--format", "mp3"}, {"--format", "pcm24"}},
        {{scene, "--offline", out, "--no-dither"}, {"--no-dither", "pcm16"}},
        {{scene, "--offline", out, "--block", "100"}, {"--block", "power of two"}},
        {{scene, "--offline", out, "--ambisonic-order", "4"}, {"--ambisonic-order"}},
        {{scene, "--offline", out, "--position", "1,2"}, {"--position", "x,y,z"}},
        {{scene, "--offline", out, "--source-position", "hiss"}, {"NAME=x,y,z"}},
        {{scene, "--offline", out, "--source-position", "bell=1,1,1"}, {"bell", "hiss"}},
        {{scene, "--offline", out, "--report"}, {"--offline", "--report"}},
        {{scene, "--offline", folder.path() / "none/out.wav"}, {"none/out.wav"}},
        {{scene, "--echogram", folder.path() / "none/out.csv"}, {"none/out.csv"}},
        {{scene, "--echogram", folder.path()}, {folder.path()}},
        {{scene, "--offline", out, "--hrtf", folder.path() / "none.sofa"}, {"none.sofa"}},
        {{scene, "--offline", out, "--hrtf", AULA_SOURCE_DIR "/tests/fuzz/corpus/sofa/nan.sofa"},
         {"nan.sofa", "is not finite"}},
        {{scene, "--offline", out, "--headphones", ""}, {"--headphones", "a sound file"}},
        {{scene, "--offline", out, "--headphones", folder.path() / "none.wav"}, {"none.wav"}},
        {{scene, "--offline", out, "--headphones", scene}, {"room.json"}},
        {{scene, "--offline", out, "--headphones", "h.wav", "--output", "foa"},
         {"--headphones: is for binaural output; expected no --output"}},
        {{scene, "--report", "--headphones", "h.wav"}, {"--headphones: is not used by", "--ir"}},
        {{"map", scene, "--out", folder.path(), "--headphones", "h.wav"},
         {"--headphones", "aula map"}},
    };
    for (const Bad& bad : all) require_refused(folder, bad.arguments, bad.parts);
}

TEST_CASE("Invalid scenes are refused with one line that names the place, and status 2") {
    const TemporaryFolder folder;
    folder.write("words.wav", "these are words, not sound");
    struct Bad {
        std::string text;
        std::string place;
    };
    const std::vector<Bad> all = {
        {"{\"aula\": 1,, }", "bad.json: line 1"},
        {with(kSmallRoom, "\"aula\": 1", "\"aula\": 9"), "bad.json: /aula"},
        {with(kSmallRoom, "\"simulation\"", "\"simulatoin\""), "simulatoin"},
        {with(kSmallRoom, "\"absorption\": 0.3", "\"absorption\": 1.3"),
         "bad.json: /materials/wall/absorption"},
        {with(kSmallRoom, "\"material\": \"wall\"", "\"material\": \"jelly\""),
         "bad.json: /geometry/0/material"},
        {with(kSmallRoom, "[1.2, 1.1, 1.5]", "[1.2, 1.1]"), "bad.json: /sources/0/position"},
        {with(kSmallRoom, "\"t\": 1", "\"t\": -1"), "bad.json: /listener/path/points/1/t"},
        {with(kSmallRoom, "\"noise\"", "\"none.wav\""), "bad.json: /sources/0/signal"},
        {with(kSmallRoom, "\"noise\"", "\"words.wav\""), "words.wav"},
        {with(kSmallRoom, "\"rays\": 200", "\"rays\": 0"), "bad.json: /simulation/rays"},
        {with(kSmallRoom, "\"rays\": 200", "\"quality\": \"best\""),
         "bad.json: /simulation/quality: unknown quality \"best\"; expected \"draft\", \"normal\" "
         "or "
         "\"fine\""},
    };
    for (const Bad& bad : all) {
        const std::string scene = folder.write("bad.json", bad.text);
        require_refused(folder, {scene, "--offline", folder.path() / "out.wav"}, {bad.place});
    }
}

TEST_CASE("Meshes that are pipes, devices, broken or of other formats are refused") {
    const TemporaryFolder folder;
    REQUIRE(mkfifo((folder.path() / "pipe.obj").c_str(), 0600) == 0);
    std::filesystem::create_symlink("/dev/zero", folder.path() / "zero.ply");
    folder.write("endless.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty\r\r\r");
    folder.write("capitals.ply", "PLY\nformat ascii 1.0\nelement vertex 3\n");
    folder.write("deep.gltf", std::string(200'000, '['));
    folder.write("mesh.fbx", "no FBX");
    folder.write(
        "face.obj", "v 0 0 0\nf" + [] {
            std::string corners;
            for (int i = 0; i < 2'000'000; ++i) corners += " 1";
            return corners;
        }());
    for (const char* name : {"pipe.obj", "zero.ply", "endless.ply", "capitals.ply", "deep.gltf",
                             "mesh.fbx", "face.obj"}) {
        const std::string scene =
            folder.write("bad.json", R"({"aula": 1, "geometry": [{"file": ")" + std::string(name) +
                                         R"(", "material": "wood"}],
            "sources": [{"position": [0, 0, 0]}], "listener": {"position": [1, 0, 0]}})");
        require_refused(folder, {"check", scene}, {"bad.json: /geometry/0/file", name});
    }
}

TEST_CASE("A scene file that does not exist, or is a folder, is refused") {
    const TemporaryFolder folder;
    require_refused(folder, {folder.path() / "none.json"}, {"none.json"});
    require_refused(folder, {folder.path()}, {folder.path()});
}

TEST_CASE("Help and version go to standard output with status 0") {
    const ProgramResult help = aula_with({"--help"});
    REQUIRE(help.status == 0);
    REQUIRE(help.err.empty());
    for (const char* option : {"--offline",
                               "--ir",
                               "--echogram",
                               "--report",
                               "--frames",
                               "--position",
                               "--source-position",
                               "--estimator",
                               "--rays",
                               "--order",
                               "--specular-order",
                               "--response-time",
                               "--patch-size",
                               "--listener-radius",
                               "--frame-rate",
                               "--ir-length",
                               "--seed",
                               "--threads",
                               "--memory-mb",
                               "--duration",
                               "--output",
                               "--ambisonic-order",
                               "--half-precision-tail",
                               "--hrtf",
                               "--headphones",
                               "--format",
                               "--sample-rate",
                               "--block",
                               "--device",
                               "--list-devices",
                               "--no-window",
                               "--quiet",
                               "--version",
                               "--bin-ms"}) {
        INFO(option);
        CHECK(help.out.find(option) != std::string::npos);
    }
    // Of a command only what concerns it.
    const ProgramResult map = aula_with({"map", "--help"});
    CHECK(map.status == 0);
    for (const char* const part : {"aula map SCENE", "--spacing", "--rays", "--position"})
        CHECK(map.out.find(part) != std::string::npos);
    for (const char* const part : {"--hrtf", "--html", "--osc", "aula info"})
        CHECK(map.out.find(part) == std::string::npos);
    for (const char* const command :
         {"report", "info", "check", "import", "materials", "dataset"}) {
        const ProgramResult of_command = aula_with({command, "--help"});
        CHECK(of_command.out.find(std::string("aula ") + command) != std::string::npos);
        CHECK(of_command.out.size() < help.out.size() / 2);
    }
    const ProgramResult version = aula_with({"--version"});
    REQUIRE(version.status == 0);
    CHECK(std::regex_match(version.out,
                           std::regex("aula " AULA_VERSION R"( with Embree [34]\.\d+\.\d+\n)")));
}

TEST_CASE("The manual page, the AppStream data and the changelog name the version of the program") {
    const auto first = [](const std::string& file, const std::string& before) {
        const std::string text = read_file(AULA_SOURCE_DIR "/" + file);
        const std::size_t begin = text.find(before) + before.size();
        return text.substr(begin, text.find_first_not_of("0123456789.", begin) - begin);
    };
    CHECK(first("docs/aula.1", "\"aula ") == AULA_VERSION);
    CHECK(first("apps/aula/desktop/aula.metainfo.xml", "release version=\"") == AULA_VERSION);
    // Its first section may be that of changes after this version.
    CHECK_THAT(read_file(AULA_SOURCE_DIR "/CHANGELOG.md"), Contains("\n## [" AULA_VERSION "] - "));
}

TEST_CASE("The manual page has the options that --help lists, and no others") {
    const auto options_in = [](const std::string& text) {
        static const std::regex option("--[a-z][a-z-]*");
        return std::set<std::string>(std::sregex_token_iterator(text.begin(), text.end(), option),
                                     {});
    };
    const std::string manual =
        std::regex_replace(read_file(AULA_SOURCE_DIR "/docs/aula.1"), std::regex(R"(\\-)"), "-");
    const std::set<std::string> listed = options_in(aula_with({"--help"}).out);
    CHECK(listed.size() > 30);
    CHECK(options_in(manual) == listed);
}

TEST_CASE(
    "Output files that are inputs, or the same file twice, are refused under any name or link") {
    const TemporaryFolder folder;
    folder.write("box.obj",
                 "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nv 0 0 9\nv 9 0 9\nv 9 9 9\nv 0 9 9\n"
                 "f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 4 8 5\nf 2 3 7 6\n");
    folder.write("voice.wav", read_file(AULA_SOURCE_DIR "/scenes/sounds/guitar.wav"));
    const std::string scene = folder.write("room.json", R"({"aula": 1,
        "geometry": [{"file": "box.obj", "material": "plaster"}],
        "sources": [{"name": "a", "position": [1, 1, 1], "signal": "voice.wav"},
                    {"name": "b", "position": [2, 1, 1]}],
        "listener": {"position": [5, 5, 2]}})");
    const std::filesystem::path path = folder.path();
    std::filesystem::create_directory(path / "sub");
    std::filesystem::create_hard_link(path / "voice.wav", path / "hard.wav");
    std::filesystem::create_symlink("box.obj", path / "soft.csv");
    std::filesystem::create_symlink("sub", path / "link");
    folder.write("same-a.wav", "kept");
    std::filesystem::create_hard_link(path / "same-a.wav", path / "same.csv");
    const auto files = [&] {
        std::string all;
        for (const std::string& name : names_in(path))
            if (std::filesystem::is_regular_file(path / name)) all += read_file(path / name);
        return all;
    };
    const std::string before = files();
    const auto refused = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), scene);
        arguments.insert(arguments.end(), {"--frames", "1", "--duration", "0.1"});
        require_refused(folder, arguments, {"expected"});
        CHECK(names_in(path / "sub").empty());
        CHECK((files() == before));
    };
    const std::string in = path.string() + "/";
    refused({"--offline", scene});
    refused({"--offline", in + "sub/../room.json"});
    refused({"--offline", in + "voice.wav"});
    refused({"--offline", in + "hard.wav"});
    refused({"--echogram", in + "box.obj"});
    refused({"--echogram", in + "soft.csv"});
    refused({"--report=" + scene});
    // New files under two names.
    refused({"--echogram", in + "new.csv", "--report=" + in + "sub/../new.csv"});
    refused({"--echogram", in + "sub/new.csv", "--report=" + in + "link/new.csv"});
    refused({"--ir", in + "same.wav", "--echogram", in + "same.csv"});
    // The same new file behind a link.
    std::filesystem::create_symlink("sub/new.csv", path / "late.csv");
    refused({"--echogram", in + "sub/new.csv", "--report=" + in + "late.csv"});
    for (const std::string option : {"--offline", "--ir", "--echogram", "--screenshot"})
        refused({option, "-"});
    refused({"--report=-"});
    // Companion: files with different names and folders are written.
    const ProgramResult written = aula_with(
        {scene, "--frames", "1", "--ir", in + "ir.wav", "--echogram", in + "sub/new.csv"});
    INFO(written.err);
    CHECK(written.status == 0);
    CHECK(names_in(path / "sub") == std::vector<std::string>{"new.csv"});
    CHECK(std::filesystem::exists(path / "ir-b.wav"));
}

TEST_CASE("Names in files are printed without control characters") {
    const TemporaryFolder folder;
    const std::string scene = folder.write(
        "room.json", R"({"aula": 1, "sources": [{"name": "a\u001b[31m", "position": [1, 1, 1]}],
                         "listener": {"position": [5, 5, 2]}})");
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"info", scene},
          {scene, "--report", "--frames", "1"},
          {scene, "--report", "--source-position", "b=1,1,1"}}) {
        const ProgramResult result = aula_with(arguments);
        CHECK((result.out + result.err).find("\x1b") == std::string::npos);
        CHECK((result.out + result.err).find("a\\x1b[31m") != std::string::npos);
    }
}

TEST_CASE("A full disk is reported with status 1") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kFreeField);
    const ProgramResult result = aula_with({scene, "--frames", "1", "--echogram", "/dev/full"});
    INFO(result.err);
    REQUIRE(result.status == 1);
    REQUIRE(result.err.rfind("aula: ", 0) == 0);
}

TEST_CASE("Words in place of the scene are commands, and ./info opens a file of that name") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const ProgramResult info = aula_with({"info", scene});
    INFO(info.err);
    REQUIRE(info.status == 0);
    // 5 x 4 x 3 m
    CHECK(info.out.find("94.0 m2") != std::string::npos);
    CHECK(info.out.find("60.0 m3\n") != std::string::npos);
    const ProgramResult check = aula_with({"check", scene});
    CHECK(check.status == 0);
    CHECK(check.out.find("ok, 12 triangles") != std::string::npos);
    const ProgramResult materials = aula_with({"materials"});
    CHECK(materials.status == 0);
    for (const char* name : {"plaster", "wood", "concrete", "brick", "glass", "carpet", "water"})
        CHECK(materials.out.find(name) != std::string::npos);
    folder.write("info", kSmallRoom);
    const ProgramResult file = aula_with({"check", (folder.path() / "info").string()});
    CHECK(file.status == 0);
}

TEST_CASE("A material is printed with its curves, and an unknown one is an error that names it") {
    const ProgramResult shown = aula_with({"materials", "show", "curtain"});
    CHECK(shown.status == 0);
    CHECK(shown.out.find("absorption") != std::string::npos);
    CHECK(shown.out.find("1000 Hz") != std::string::npos);
    CHECK(shown.out.find("sound reduction") == std::string::npos);
    const ProgramResult partition = aula_with({"materials", "show", "partition_brick_100"});
    CHECK(partition.out.find("sound reduction index") != std::string::npos);
    CHECK(partition.out.find("1000 Hz  47 dB") != std::string::npos);
    const ProgramResult list = aula_with({"materials", "list"});
    CHECK(list.status == 0);
    std::istringstream lines(list.out);
    for (std::string line; std::getline(lines, line);) CHECK(line.size() <= 80);
    const ProgramResult unknown = aula_with({"materials", "show", "gras"});
    CHECK(unknown.status == 2);
    CHECK(unknown.err.find("\"gras\", did you mean \"grass\"?") != std::string::npos);
    // A part of names, and a word of another language.
    const ProgramResult seats = aula_with({"materials", "Seats"});
    CHECK(seats.out.find("\nleather_seats ") != std::string::npos);
    CHECK(seats.out.find("\nupholstered_seats ") != std::string::npos);
    CHECK(seats.out.find("carpet") == std::string::npos);
    CHECK(aula_with({"materials", "Teppich"}).out.find("\ncarpet ") != std::string::npos);
    CHECK(aula_with({"materials", "schaum"}).out.find("\nfoam") != std::string::npos);
    CHECK(aula_with({"materials", "xyz"}).status == 2);
    CHECK(aula_with({"materials", "show"}).status == 2);
}

TEST_CASE("Invalid options of the window and of remote control are refused") {
    const std::string scene = AULA_SOURCE_DIR "/scenes/shoebox.json";
    CHECK(aula_with({scene, "--after", "3"}).err.find("--screenshot") != std::string::npos);
    CHECK(aula_with({scene, "--after", "0", "--screenshot", "x.png"}).status == 2);
    CHECK(aula_with({scene, "--screenshot", "x.jpg"}).err.find("x.jpg") != std::string::npos);
    CHECK(aula_with({scene, "--screenshot", "x.png", "--no-window"}).err.find("--no-window") !=
          std::string::npos);
    for (const char* address : {"nonsense", "65536", "1.2.3:9000", "host:9000"}) {
        const ProgramResult refused = aula_with({"info", scene, "--osc", address});
        CHECK(refused.status == 2);
        CHECK(refused.err.starts_with("aula: --osc: "));
    }
    CHECK(aula_with({scene, "--adm-origin", "1,2", "--osc", "0"}).status == 2);
    CHECK(aula_with({scene, "--adm-radius", "0", "--osc", "0"}).status == 2);
    const std::vector<std::vector<std::string>> alone{
        {"--adm-origin", "1,2,3"}, {"--adm-radius", "2"}, {"--head-invert"}};
    for (std::vector<std::string> arguments : alone) {
        const std::string option = arguments[0];
        arguments.insert(arguments.begin(), scene);
        const ProgramResult refused = aula_with(arguments);
        CHECK(refused.status == 2);
        CHECK(refused.err.find(option + ": is used without --osc") != std::string::npos);
    }
}

TEST_CASE("The program is hardened: addresses are bound at the start, stacks are protected") {
    const std::string sections = run_program({"readelf", "-dW", AULA_PROGRAM}).out;
    CHECK_THAT(sections, Contains("BIND_NOW"));
    const std::string symbols = run_program({"readelf", "-sW", AULA_PROGRAM}).out;
    CHECK_THAT(symbols, Contains("__stack_chk_fail"));
}
