// Models in place of scenes, and the command import.

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/aula/aula_program.h"

using namespace aula::test;
using Catch::Contains;

namespace {

/// A box of 5 x 4 x 3 m, in millimetres.
constexpr const char* kBox = R"(v 0 0 0
v 5000 0 0
v 5000 4000 0
v 0 4000 0
v 0 0 3000
v 5000 0 3000
v 5000 4000 3000
v 0 4000 3000
usemtl Putz.001
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
f 5 6 7 8
usemtl Teppich
f 1 2 3 4
)";

}  // namespace

TEST_CASE("A model is measured and rendered as a scene") {
    const TemporaryFolder folder;
    const std::string model = folder.write("room.obj", kBox);
    const ProgramResult info = aula_with({"info", model});
    CHECK(info.status == 0);
    CHECK_THAT(info.out, Contains("5.00, 4.00, 3.00 m"));
    CHECK_THAT(info.err, Contains("room.obj: guessed unit: millimetres"));
    CHECK_THAT(info.err, Contains("guessed material \"Putz.001\": plaster, \"putz\" is in"));
    CHECK_THAT(info.err, Contains("guessed source \"clap\" at ("));
    const ProgramResult report = aula_with({model, "--report", "--frames", "2", "--quiet"});
    CHECK(report.status == 0);
    CHECK(report.err.empty());
    CHECK_THAT(report.out, Contains("source clap"));
    const std::string out = folder.path() / "out.wav";
    CHECK(aula_with({model, "--offline", out, "--duration", "0.2", "--quiet"}).status == 0);
    CHECK(std::filesystem::file_size(out) > 0);
}

TEST_CASE("The scene that import writes sounds as the model, with its guesses as comments") {
    const TemporaryFolder folder;
    const std::string model = folder.write("room.obj", kBox);
    std::filesystem::create_directory(folder.path() / "scenes");
    const std::string scene = folder.path() / "scenes" / "room.json";
    const ProgramResult written = aula_with({"import", model, "--out", scene});
    CHECK(written.status == 0);
    CHECK(written.out.empty());
    CHECK_THAT(written.err, Contains("aula: guessed unit: millimetres"));
    const std::string text = read_file(scene);
    CHECK_THAT(text, Contains("// * unit: millimetres"));
    CHECK_THAT(text, Contains("\"../room.obj\""));
    CHECK_THAT(text, Contains("\"Teppich\": \"carpet\""));
    const auto sound_of = [&](const std::string& file) {
        const std::string out = folder.path() / "out.wav";
        REQUIRE(aula_with({file, "--offline", out, "--duration", "0.2", "--quiet"}).status == 0);
        return read_file(out);
    };
    CHECK(sound_of(scene) == sound_of(model));

    // Without --out the scene is on standard output, for the working directory.
    const ProgramResult printed = aula_with({"import", model, "--quiet"});
    CHECK(printed.status == 0);
    CHECK(printed.err.empty());
    CHECK_THAT(printed.out, Contains("room.obj\""));
    const ProgramResult given = aula_with({"import", model, "--scale", "0.002", "--up", "y"});
    CHECK_THAT(given.out, Contains("\"scale\": 0.002"));
    CHECK_THAT(given.out, Contains("\"up\": \"y\""));
    CHECK(given.err.find("unit") == std::string::npos);
    // An earlier scene may have been edited.
    require_refused(folder, {"import", model, "--out", scene}, {"--out", "exists"});
    CHECK(read_file(scene) == text);
}

TEST_CASE("Wrong arguments of import are refused") {
    const TemporaryFolder folder;
    const std::string model = folder.write("room.obj", kBox);
    require_refused(folder, {"import"}, {"SCENE"});
    require_refused(folder, {"import", folder.write("a.step", "")}, {"a.step", ".glb", "assimp"});
    require_refused(folder, {"import", model, "--scale", "0"}, {"--scale"});
    require_refused(folder, {"import", model, "--up", "x"}, {"--up", "y, z"});
    require_refused(folder, {"info", model, "--scale", "1"}, {"--scale", "import"});
    require_refused(folder, {"import", model, "--height", "1"}, {"--height", "map"});
    require_refused(folder, {"import", folder.write("empty.obj", "")}, {"empty.obj"});
}

TEST_CASE("The scene of an OBJ file in Latin-1 is UTF-8 and opens") {
    const TemporaryFolder folder;
    // As programs for Windows write it.
    const std::string model = folder.write("Süd raum.obj", with(with(kBox, "Putz.001",
                                                                     "W\xe4nde S\xfc"
                                                                     "d"),
                                                                "\n", "\r\n"));
    const std::string scene = folder.path() / "süd.json";
    const ProgramResult written = aula_with({"import", model, "--out", scene});
    INFO(written.err);
    CHECK(written.status == 0);
    CHECK_THAT(written.err, Contains("material \"Wände Süd\": plaster, \"wande\" is in"));
    CHECK_THAT(read_file(scene), Contains("\"Wände Süd\": \"plaster\""));
    CHECK(aula_with({"check", scene}).status == 0);
}

TEST_CASE("A sound inside a model sounds as its file") {
    const TemporaryFolder folder;
    const std::filesystem::path corpus = AULA_SOURCE_DIR "/tests/fuzz/corpus/sound";
    const auto rendered = [&](const std::string& signal) {
        const std::string out = folder.path() / "out.wav";
        const std::string scene = folder.write("room.json", R"({"aula": 1,
            "geometry": [{"box": [5, 4, 3], "material": "plaster"}],
            "sources": [{"position": [1, 1, 1], "loop": true, "signal": ")" +
                                                                signal + R"("}],
            "listener": {"position": [3, 2, 1.5]},
            "simulation": {"rays": 100, "ir_length_s": 0.2}})");
        const ProgramResult result =
            aula_with({scene, "--offline", out, "--duration", "0.1", "--quiet"});
        INFO(result.err);
        REQUIRE(result.status == 0);
        return read_file(out);
    };
    for (const char* const name : {"wav_pcm16", "mp3", "vorbis"}) {
        CAPTURE(name);
        const std::string file = corpus / name;
        const std::string base64 = run_program({"base64", "-w0", file}).out;
        folder.write("sounds.gltf", R"({"asset": {"version": "2.0"}, "extensions":
            {"KHR_audio_emitter": {"audio": [{"uri": "data:audio/x;base64,)" +
                                        base64 + R"("}]}}})");
        CHECK(rendered("sounds.gltf#0") == rendered(file));
    }
    // Companion: the sounds differ.
    CHECK(rendered(corpus / "wav_pcm16") != rendered(corpus / "vorbis"));
    const std::string missing = folder.write("missing.json", R"({"aula": 1, "sources":
        [{"position": [1, 1, 1], "signal": "sounds.gltf#1"}], "listener": {"position": [3, 2, 1]}})");
    const ProgramResult check = aula_with({"check", missing});
    CHECK(check.status == 2);
    CHECK_THAT(check.err, Contains("sounds.gltf#1: has no sound 1; expected"));
}
