#include <catch2/catch.hpp>
#include <string>

#include "tests/support/program.h"

using namespace aula::test;
using Catch::Contains;

namespace {

ProgramResult check(const std::string& scene) {
    return run_program({AULA_PROGRAM, "check", AULA_SOURCE_DIR "/tests/cases/" + scene});
}

}  // namespace

TEST_CASE("The check tells which share of the reflections a scan with missing faces loses") {
    // A tenth of the triangles is missing; at most that share escapes.
    const ProgramResult scan = check("check/scan.json");
    CHECK(scan.status == 0);
    CHECK_THAT(scan.err, Contains(": 9.") && Contains("% of the reflections escape") &&
                             Contains("faces of its mesh are missing"));
    // Companion: the mesh without holes.
    const ProgramResult closed = check("check/closed.json");
    CHECK(closed.status == 0);
    CHECK(closed.err.empty());
}

TEST_CASE("The check names the first point of a path inside a closed pillar") {
    const ProgramResult pillar = check("check/pillar.json");
    CHECK(pillar.status == 0);
    // The path meets the pillar after 1.2 s; the positions on it are 0.5 m apart.
    CHECK_THAT(pillar.err, Contains("the source \"m\" is inside a closed body after 1.2 s, at (3"));
}

TEST_CASE("Meshes with uncompressed data beside compressed ones are read") {
    for (const std::string name : {"EXT", "KHR", "draco", "plain"}) {
        INFO(name);
        const ProgramResult result = check("models/" + name + ".json");
        CHECK(result.status == 0);
        CHECK(result.err.empty());
        CHECK_THAT(result.out, Contains("12 triangles"));
    }
}
