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
