// What the command check says of faces that overlap in one plane.

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "tests/aula/aula_program.h"

using namespace aula::test;
using Catch::Contains;

TEST_CASE("A window drawn on a wall is named and heard, a cupboard at a wall is neither") {
    const TemporaryFolder folder;
    const std::string scene = R"({"aula": 1, "geometry": [
        {"box": [5, 4, 3], "material": "brick"},
        {"vertices": [[1,0,1], [3,0,1], [3,0,2], [1,0,2]], "faces": [[0,1,2,3]],
         "material": "glass"},
        {"box": [1, 0.5, 2], "min": [0, 1, 0], "material": "wood"}],
        "sources": [{"name": "s", "position": [4, 1, 1.5], "signal": "impulse"}],
        "listener": {"position": [3, 3, 1.5]}})";
    const std::string file = folder.write("window.json", scene);
    const ProgramResult check = run_program({AULA_PROGRAM, "check", file});
    CHECK(check.status == 0);
    CHECK(check.err == "aula: warning: " + file +
                           ": 2 m2 of \"glass\" are in the plane of \"brick\", as at (1.48, 0.00, "
                           "1.34): of faces that overlap, the smaller one is heard\n");
    CHECK(run_program({AULA_PROGRAM, "check", file, "--strict"}).status == 3);
    // Inside the cupboard its bottom is heard. A path that leads through it changes nothing.
    const std::string through =
        folder.write("through.json", with(scene, R"("position": [4, 1, 1.5])", R"("path": {
        "points": [{"t": 0, "position": [4, 1.2, 1.5]}, {"t": 4, "position": [0.5, 1.2, 1.5]}]})"));
    CHECK_THAT(run_program({AULA_PROGRAM, "check", through}).err,
               Contains("inside a closed body") && !Contains("\"wood\""));
    const ProgramResult info = run_program({AULA_PROGRAM, "info", file});
    // Without the window and the areas at the cupboard, which has 5.5 m2 in the room.
    CHECK_THAT(info.out, Contains("brick                         90.5 m2") &&
                             Contains("glass                          2.0 m2") &&
                             Contains("wood                           5.5 m2"));
}

TEST_CASE("Of three layers in contact two are named on the wall and on each other") {
    const TemporaryFolder folder;
    const std::string face =
        R"({"vertices": [[1,0,1], [3,0,1], [3,0,2], [1,0,2]], "faces": [[0,1,2,3]], "material": ")";
    const ProgramResult check =
        run_program({AULA_PROGRAM, "check",
                     folder.write("layers.json", R"({"aula": 1, "geometry": [
            {"box": [5, 4, 3], "material": "brick"},)" +
                                                     face + "glass\"}, " + face + R"(curtain"}],
            "sources": [{"position": [4, 1, 1.5]}], "listener": {"position": [3, 3, 1.5]}})")});
    CHECK_THAT(check.err, Contains(": 2 m2 of \"glass\" are in the plane of \"brick\""));
    CHECK_THAT(check.err, Contains(": 2 m2 of \"glass\" lie on equal faces of \"curtain\""));
    // The brick is heard nowhere below the second layer: that area is zero but for rounding.
    CHECK(std::count(check.err.begin(), check.err.end(), '\n') == 2);
}

TEST_CASE("A wall without thickness between two rooms is named if their materials differ") {
    const TemporaryFolder folder;
    // The second room has the common wall from the other side, by other triangles.
    const auto check = [&](const std::string& material, const std::string& face) {
        const ProgramResult result = run_program(
            {AULA_PROGRAM, "check",
             folder.write(
                 "rooms.json", R"({"aula": 1,
                "geometry": [{"box": [5, 4, 3], "material": "brick"},
                    {"vertices": [[5,0,0], [5,4,0], [5,4,3], [5,0,3],
                                  [9,0,0], [9,4,0], [9,4,3], [9,0,3]], "material": ")" +
                                   material +
                                   R"(",
                     "faces": [)" + face +
                                   R"(, [4,7,6,5], [0,4,5,1], [3,2,6,7], [0,3,7,4], [1,5,6,2]]}],
                "sources": [{"position": [4, 1, 1.5]}, {"name": "b", "position": [7, 1, 1.5]}],
                "listener": {"position": [3, 3, 1.5]}})")});
        return result.err;
    };
    for (const char* const face : {"[0,1,2,3]", "[1,2,3,0]", "[3,2,1,0]"}) {
        CAPTURE(face);
        const std::string error = check("glass", face);
        CHECK_THAT(
            error,
            Contains(": 12 m2 of \"brick\" lie on equal faces of \"glass\", as at (5.00, ") &&
                Contains("a wall with two materials needs a thickness"));
        CHECK_THAT(check("brick", face), !Contains("equal faces"));
    }
}
