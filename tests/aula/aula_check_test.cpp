// What the commands check and info say of a scene.

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/aula/aula_program.h"
#include "tests/support/small_scenes.h"

using namespace aula::test;
using Catch::Contains;

TEST_CASE("Positions in a room without a ceiling are inside") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("yard.json", R"({
        "aula": 1,
        "geometry": [{"material": "brick",
            "vertices": [[0,0,0], [5,0,0], [5,4,0], [0,4,0], [0,0,3], [5,0,3], [5,4,3], [0,4,3]],
            "faces": [[0,1,2,3], [0,1,5,4], [1,2,6,5], [2,3,7,6], [3,0,4,7]]}],
        "sources": [{"name": "low", "position": [1, 1, 0.1], "signal": "impulse"},
                    {"name": "high", "position": [3, 3, 1.5], "signal": "impulse"}],
        "listener": {"position": [2, 2, 1]}})");
    const ProgramResult inside = run_program({AULA_PROGRAM, "check", scene});
    // More than a tenth of the reflections escape.
    CHECK(inside.status == 3);
    CHECK(inside.out.find("doubtful, 10 triangles") != std::string::npos);
    CHECK(inside.err.find("outside") == std::string::npos);
    // Companion: a position above the walls.
    const ProgramResult above =
        run_program({AULA_PROGRAM, "check", scene, "--source-position", "high=3,3,9"});
    CHECK(above.err.find("the source \"high\" is outside the bounds") != std::string::npos);
    const ProgramResult info =
        run_program({AULA_PROGRAM, "info", scene, "--source-position", "high=3,3,9"});
    CHECK(info.out.find("the source \"high\" is outside the room") != std::string::npos);
    // The floor alone is no room.
    const std::string floor = folder.write(
        "floor.json", with(read_file(scene), ", [0,1,5,4], [1,2,6,5], [2,3,7,6], [3,0,4,7]", ""));
    const ProgramResult open = run_program({AULA_PROGRAM, "check", floor, "--position", "2,2,0.5"});
    CHECK_THAT(open.out, Contains("% of the reflections escape: open air\n"));
    CHECK_THAT(open.err, !Contains("escape"));
}

TEST_CASE("A scene far from the origin is doubtful") {
    const TemporaryFolder folder;
    const auto check = [&](int from_m) {
        const auto at = [&](int x) { return "[" + std::to_string(from_m + x) + ", 1, 1]"; };
        return run_program({AULA_PROGRAM, "check",
                            folder.write("far.json", R"({"aula": 1, "geometry": [{"box": [6, 4, 3],
                "min": [)" + std::to_string(from_m) + R"(, 0, 0], "material": "plaster"}],
                "sources": [{"position": )" + at(2) + R"(}], "listener": {"position": )" +
                                                         at(4) + "}}")});
    };
    CHECK(check(2040).status == 0);
    CHECK(check(2050).status == 3);
    CHECK_THAT(check(2050).err, Contains("the geometry is 2056 m from the origin") &&
                                    Contains("\"translate\": [-2053, -2, -2]"));
}

TEST_CASE("Settings that cost ten times real time are warned of with what to set") {
    const TemporaryFolder folder;
    const auto check = [&](const std::string& settings) {
        const std::string scene = with(kSmallRoom, "\"rays\": 200,", settings);
        return run_program({AULA_PROGRAM, "check", folder.write("room.json", scene)});
    };
    // Two hundred times the default.
    const ProgramResult many = check("\"rays\": 200000, ");
    CHECK(many.status == 0);
    CHECK_THAT(many.err, Contains(" times real time on ") && Contains(": set \"rays\" to "));
    CHECK(std::count(many.err.begin(), many.err.end(), '\n') == 1);
    CHECK(check("\"rays\": 1500, \"specular_order\": 5, \"threads\": 1024, ").err.empty());
}

TEST_CASE(
    "A position outside the room is a warning, and a full disk behind standard output gives status "
    "1") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const ProgramResult outside =
        run_program({AULA_PROGRAM, "check", scene, "--position", "99,1,1"});
    CHECK(outside.status == 3);
    CHECK(outside.err.find("aula: warning: --position: the listener is outside") == 0);
    // One line only.
    CHECK(std::count(outside.err.begin(), outside.err.end(), '\n') == 1);
    // Of millimetres the metres are proposed.
    const ProgramResult unit =
        run_program({AULA_PROGRAM, "check", scene, "--position", "3000,2000,1500"});
    CHECK_THAT(unit.err, Contains("the listener is inside if its position is in millimetres: in "
                                  "metres it is [3, 2, 1.5]\n"));
    // Within the bounds of the geometry, between two rooms.
    const std::string two =
        folder.write("two.json", with(kSmallRoom, "[{\"box\"",
                                      R"([{"box": [5, 4, 3], "min": [20, 0, 0], "material": "wall"},
                                          {"box")"));
    CHECK(run_program({AULA_PROGRAM, "check", two, "--position", "12,1,1"}).err ==
          "aula: warning: " + two + ": the listener is outside the room, at (12, 1, 1)\n");
    // Rays from outside are no leaks.
    const ProgramResult info = run_program({AULA_PROGRAM, "info", scene, "--position", "99,1,1"});
    CHECK(info.out.find("none: tight\n                the listener is outside the room\n") !=
          std::string::npos);
    const ProgramResult inside = run_program({AULA_PROGRAM, "check", scene, "--position", "1,1,1"});
    CHECK(inside.err.empty());
    CHECK(inside.out.find("triangles, 1 material, 1 source\n") != std::string::npos);
    const ProgramResult full =
        run_program({"sh", "-c", "'" AULA_PROGRAM "' materials > /dev/full"});
    CHECK(full.status == 1);
    CHECK(full.err.find("cannot write") != std::string::npos);
    // The reader of a pipe may end before the last line: that needs no message.
    const ProgramResult head =
        run_program({"bash", "-c", "'" AULA_PROGRAM "' materials | true; echo ${PIPESTATUS[0]}"});
    CHECK(head.out == "141\n");
    CHECK(head.err.empty());
}

TEST_CASE("A room is the same from a listener on its wall") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    for (const char* const position : {"2,0,1", "5,2,1.5", "2,2,0"}) {
        CAPTURE(position);
        const ProgramResult info =
            run_program({AULA_PROGRAM, "info", scene, "--position", position});
        CHECK(info.out.find("none: tight") != std::string::npos);
        CHECK(info.out.find("60.0 m3") != std::string::npos);
        CHECK(run_program({AULA_PROGRAM, "check", scene, "--position", position}).err.empty());
    }
}

TEST_CASE("A source in a closed box is a warning, and its rendered silence another") {
    const TemporaryFolder folder;
    const auto scene = [&](const char* path) {
        return folder.write("boxed.json",
                            with(kSmallRoom, "[{\"box\"",
                                 std::string(R"([{"box": [1, 1, 1], "min": [1, 0.9, 1],)") + path +
                                     R"( "material": "wall"}, {"box")"));
    };
    const std::string boxed = scene("");
    CHECK(run_program({AULA_PROGRAM, "check", boxed}).err ==
          "aula: warning: " + boxed +
              ": the source \"hiss\" is never audible: closed surfaces separate it from the "
              "listener\n");
    CHECK(run_program({AULA_PROGRAM, "check", boxed}).status == 3);
    const std::string file = folder.path() / "out.wav";
    const ProgramResult rendered =
        run_program({AULA_PROGRAM, boxed, "--offline", file, "--duration", "0.2"});
    CHECK(rendered.status == 0);
    CHECK(rendered.err.find("warning: " + file + ": is silent; aula check tells") !=
          std::string::npos);
    // Companions: a box that moves away, and a source that leaves it, of which the first point is
    // named.
    CHECK(run_program(
              {AULA_PROGRAM, "check", scene(R"("path": {"points": [{"t": 0, "position": [0, 0, 0]},
                                                    {"t": 1, "position": [2, 0, 0]}]},)")})
              .err.empty());
    const std::string leaving = folder.write(
        "leaving.json", with(with(kSmallRoom, "[{\"box\"",
                                  R"([{"box": [1, 1, 1], "min": [1, 0.9, 1], "material": "wall"},
                                     {"box")"),
                             "\"position\": [1.2, 1.1, 1.5]", R"("path": {"points": [
                                 {"t": 0, "position": [1.2, 1.1, 1.5]},
                                 {"t": 1, "position": [3, 1.1, 1.5]}]})"));
    CHECK(run_program({AULA_PROGRAM, "check", leaving}).err ==
          "aula: warning: " + leaving +
              ": the source \"hiss\" is inside a closed body, at (1.2, 1.1, 1.5): no sound passes "
              "its "
              "surfaces; lead the path around it\n");
}

TEST_CASE("The shipped scenes pass the check without a warning, and a room with a hole does not") {
    const TemporaryFolder folder;
    const std::filesystem::path scenes = std::filesystem::path(AULA_SOURCE_DIR) / "scenes";
    for (const auto& entry : std::filesystem::directory_iterator(scenes)) {
        if (entry.path().extension() != ".json" || entry.path().stem() == "dataset_manifest")
            continue;
        INFO(entry.path());
        const ProgramResult result = run_program({AULA_PROGRAM, "check", entry.path()});
        CHECK(result.status == 0);
        CHECK(result.err.empty());
    }
    // Companion: a slit 10 cm wide along one wall. A slit of 2 mm is negligible beside walls with
    // an absorption coefficient of 0.3.
    const auto slit = [&](const char* height) {
        const std::string faces = with(with(R"(
        {"vertices": [[0,0,0], [5,0,0], [5,4,0], [0,4,0], [0,0,3], [5,0,3], [5,4,3], [0,4,3],
                      [0,0,HEIGHT], [5,0,HEIGHT]],
         "faces": [[0,1,2,3], [4,5,6,7], [8,9,5,4], [1,2,6,5], [2,3,7,6], [3,0,4,7]])",
                                            "HEIGHT", height),
                                       "HEIGHT", height);
        return aula_with(
            {"check", folder.write("slit.json", with(kSmallRoom, "{\"box\": [5, 4, 3]", faces))});
    };
    CHECK(slit("0.1").err.find("the room has a hole") != std::string::npos);
    const std::string slit_file = folder.path() / "slit.json";
    CHECK(slit("0.1").status == 0);
    CHECK(aula_with({"check", slit_file, "--strict"}).status == 3);
    CHECK(slit("0.002").status == 0);
    CHECK(aula_with({"check", slit_file, "--strict"}).status == 0);
    require_refused(folder, {"info", slit_file, "--strict"}, {"--strict", "check"});
    CHECK(slit("0.002").err.empty());
    CHECK(slit("0.002").out.find("shorter: harmless\n") != std::string::npos);
}

TEST_CASE(
    "The command check prints all errors of a scene, one per line, other commands the first") {
    const TemporaryFolder folder;
    const std::string scene = folder.write(
        "room.json", with(with(with(kSmallRoom, "\"absorption\": 0.3", "\"absorption\": 3"),
                               "\"noise\"", "\"none.wav\""),
                          "\"rays\"", "\"ray\""));
    const ProgramResult check = aula_with({"check", scene});
    CHECK(check.status == 2);
    CHECK(check.out.empty());
    CHECK(std::count(check.err.begin(), check.err.end(), '\n') == 3);
    const std::string line = "aula: " + scene + ": ";
    CHECK(check.err.starts_with(line + "/materials/wall/absorption: 3 is out of range"));
    CHECK(check.err.find("\n" + line + "/sources/0/signal: no such file") != std::string::npos);
    CHECK(check.err.find("\n" + line + "/simulation/ray: unknown key") != std::string::npos);
    const ProgramResult info = aula_with({"info", scene});
    CHECK(info.status == 2);
    CHECK(info.err == check.err.substr(0, check.err.find('\n') + 1));
    // Unreadable sound files, one line for each, also if two sources play it.
    folder.write("none.wav", "no sound");
    folder.write("nor.wav", "no sound");
    const std::string mute = folder.write(
        "mute.json",
        with(kSmallRoom, "[{\"name\": \"hiss\"", R"([{"signal": "none.wav", "position": [1, 1, 1]},
                          {"signal": "none.wav", "name": "b", "position": [1, 2, 1]},
                          {"signal": "nor.wav", "name": "c", "position": [1, 2, 1]}, {"name": "hiss")"));
    const ProgramResult sounds = aula_with({"check", mute});
    CHECK(sounds.status == 2);
    CHECK(std::count(sounds.err.begin(), sounds.err.end(), '\n') == 2);
}

TEST_CASE("Each unknown material is one short line") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", R"({"aula": 1, "geometry": [
        {"box": [5, 4, 3], "material": "plastr"}, {"box": [1, 1, 1], "material": "Holz"}],
        "sources": [{"position": [1, 1, 1]}], "listener": {"position": [2, 2, 2]}})");
    const ProgramResult check = aula_with({"check", scene});
    CHECK(check.status == 2);
    const std::string line = "aula: " + scene + ": /geometry/";
    const std::string expected =
        "; expected a material of the scene, or one that \"aula materials\" lists\n";
    CHECK(check.err ==
          line + "0/material: unknown material \"plastr\", did you mean \"plaster\"?" + expected +
              line + "1/material: unknown material \"Holz\", did you mean \"wood\"?" + expected);
}

TEST_CASE("Positions in the notch of an L-shaped room are outside, also those on a path") {
    const TemporaryFolder folder;
    const auto check = [&](const std::string& listener) {
        return aula_with(
            {"check", folder.write("l.json", R"({"aula": 1, "geometry": [{"material": "brick",
            "vertices": [[0,0,0], [6,0,0], [6,3,0], [3,3,0], [3,6,0], [0,6,0],
                         [0,0,3], [6,0,3], [6,3,3], [3,3,3], [3,6,3], [0,6,3]],
            "faces": [[0,1,2,3,4,5], [6,7,8,9,10,11], [0,1,7,6], [1,2,8,7], [2,3,9,8], [3,4,10,9],
                      [4,5,11,10], [5,0,6,11]]}],
            "sources": [{"name": "a", "position": [1, 1, 1]}],
            "listener": {)" + listener + "}}")});
    };
    CHECK(check(R"("position": [2, 5, 1.5])").err.empty());
    CHECK(check(R"("position": [5, 5, 1.5])").status == 3);
    CHECK(check(R"("position": [5, 5, 1.5])")
              .err.find("the listener is outside the room, at (5, 5, 1.5)\n") != std::string::npos);
    // From arm to arm through the notch; both ends are inside.
    const std::string path =
        R"("path": {"points": [{"t": 0, "position": [2, 5, 1.5]}, {"t": 4, "position": [5, 2, 1.5]}]})";
    CHECK(check(path).err.find("the listener is outside the room after ") != std::string::npos);
    CHECK(check(path).status == 0);  // not at its start
    CHECK(check(with(path, "{\"t\": 4", R"({"t": 2, "position": [2, 2, 1.5]}, {"t": 4)"))
              .err.empty());
}

TEST_CASE("A unit or an axis that explains a scene's geometry is proposed") {
    const TemporaryFolder folder;
    // A room of 18 x 12 x 4.8 m with y up.
    const auto room = [&](const char* name, double unit) {
        std::string obj;
        for (int corner = 0; corner < 8; ++corner)
            obj += "v " + std::to_string((corner & 1) != 0 ? 18 * unit : 0) + " " +
                   std::to_string((corner & 4) != 0 ? 4.8 * unit : 0) + " " +
                   std::to_string((corner & 2) != 0 ? -12 * unit : 0) + "\n";
        folder.write(name, obj +
                               "usemtl brick\nf 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\n"
                               "f 1 3 7 5\nf 2 6 8 4\n");
        return std::string(name);
    };
    const auto check = [&](const std::string& keys) {
        return aula_with({"check", folder.write("room.json", R"({"aula": 1,
            "geometry": [{"file": )" + keys + R"(}],
            "sources": [{"position": [2, 6, 1.6]}], "listener": {"position": [11, 6, 2.2]}})")});
    };
    const std::string metres = room("metres.obj", 1);
    const std::string millimetres = room("millimetres.obj", 1000);
    CHECK(check('"' + metres + R"(", "up": "y")").status == 0);
    CHECK(check('"' + millimetres + R"(", "up": "y", "scale": 0.001)").status == 0);
    const auto proposes = [&](const std::string& keys, const std::string& proposal) {
        const ProgramResult result = check(keys);
        INFO(result.err);
        CHECK(result.status == 3);
        CHECK(result.err.find("m; with " + proposal + " beside \"file\" it is 18 x 12 x 4.8 m") !=
              std::string::npos);
    };
    proposes('"' + metres + '"', R"("up": "y")");
    proposes('"' + millimetres + '"', R"("scale": 0.001 and "up": "y")");
    proposes('"' + millimetres + R"(", "up": "y")", R"("scale": 0.001)");
}

TEST_CASE("A source behind a wall is reported as not audible, without parameters") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("two.json", R"({"aula": 1,
        "geometry": [{"box": [5, 4, 3], "material": "plaster"},
                     {"box": [4, 4, 3], "min": [5, 0, 0], "material": "plaster"}],
        "sources": [{"name": "next door", "position": [7.3, 1.2, 1.5]}],
        "listener": {"position": [3, 2, 1.5]}})");
    const std::string out = folder.path() / "out.json";
    const ProgramResult result =
        aula_with({scene, "--report=" + out, "--echogram", folder.path() / "e.csv"});
    CHECK(result.status == 0);
    CHECK(
        result.err.starts_with("aula: warning: source \"next door\": not audible at the listener"));
    const std::string json = read_file(out);
    CHECK(json.find("\"G\":null") != std::string::npos);
    CHECK(std::none_of(json.begin() + static_cast<std::ptrdiff_t>(json.find("\"T20\"")), json.end(),
                       [](char c) { return c == '.'; }));
    // Companion: a source in the listener's room has parameters.
    const ProgramResult audible = aula_with(
        {scene, "--report=" + out, "--frames", "2", "--source-position", "next door=1,1,1"});
    CHECK(audible.err.empty());
    CHECK(read_file(out).find("\"G\":null") == std::string::npos);
}

TEST_CASE("The command info leaves out what an open room does not have") {
    const TemporaryFolder folder;
    const auto info = [&](const std::string& ceiling) {
        const std::string scene = folder.write("hall.json", R"({"aula": 1,
            "geometry": [{"vertices": [[0,0,0], [9,0,0], [9,7,0], [0,7,0],
                                       [0,0,4], [9,0,4], [9,7,4], [0,7,4]], "material": "plaster",
                "faces": [[0,1,2,3], [0,1,5,4], [1,2,6,5], [2,3,7,6], [3,0,4,7])" +
                                                                ceiling + R"(]}],
            "sources": [{"position": [2, 2, 1]}], "listener": {"position": [6, 5, 1]}})");
        return run_program({AULA_PROGRAM, "info", scene}).out;
    };
    const std::string open = info("");
    CHECK_THAT(open, Contains("not closed"));
    for (const char* word : {"Sabine", "Eyring"}) {
        CHECK_THAT(open, !Contains(word));
        CHECK_THAT(info(", [4,5,6,7]"), Contains(word));
    }
}

TEST_CASE("The command info counts the edges that diffract sound") {
    // A closed box has twelve outside; the half plane in such a box has one more.
    const auto edges = [](const std::string& scene) {
        const ProgramResult info = aula_with({"info", AULA_SOURCE_DIR "/scenes/" + scene});
        const std::size_t line = info.out.find("\nedges ");
        REQUIRE(line != std::string::npos);
        return std::stoi(info.out.substr(line + 7));
    };
    CHECK(edges("shoebox.json") == 12);
    CHECK(edges("reference/half_plane.json") == 13);
    // Without diffraction none does.
    const TemporaryFolder folder;
    const std::string off = folder.write(
        "off.json",
        with(kSmallRoom, "\"ir_length_s\"", "\"diffraction_order\": 0, \"ir_length_s\""));
    CHECK(run_program({AULA_PROGRAM, "info", off}).out.find("\nedges           0 that") !=
          std::string::npos);
}

TEST_CASE("The command info counts paths around edges and through walls") {
    const auto paths = [](const std::string& scene) {
        const std::string out = aula_with({"info", AULA_SOURCE_DIR "/scenes/" + scene}).out;
        const std::size_t line = out.find("\ndirect paths");
        REQUIRE(line != std::string::npos);
        return out.substr(line + 17, out.find('\n', line + 1) - line - 17);
    };
    CHECK(paths("shoebox.json") == "0 bent, 0 through walls, from all sources");
    CHECK_THAT(paths("door.json"), Contains("bent, 1 through walls"));
    CHECK_THAT(paths("two_rooms.json"), Contains("bent, 0 through") && !Contains("0 bent"));
}

TEST_CASE("The command info knows the surface of a wall in the open") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("wall.json", R"({
        "aula": 1,
        "geometry": [{"vertices": [[0, -6, -4], [0, 6, -4], [0, 6, 4], [0, -6, 4]],
                      "faces": [[0, 1, 2, 3]], "material": "concrete"}],
        "sources": [{"position": [-5, 0, 0]}],
        "listener": {"position": [-5, 1, 0]}})");
    const std::string out = run_program({AULA_PROGRAM, "info", scene}).out;
    CHECK_THAT(out, Contains("surface         96.0 m2") && Contains("volume          not closed"));
}

TEST_CASE("The command info prints leaks, the number of patches and the materials") {
    const ProgramResult info = aula_with({"info", AULA_SOURCE_DIR "/scenes/shoebox.json"});
    CHECK(info.status == 0);
    CHECK(info.out.find("tight") != std::string::npos);
    CHECK(info.out.find("patches") != std::string::npos);
    CHECK(info.out.find("100.0 %") != std::string::npos);
}

TEST_CASE("Patches that the memory enlarges are named by info, and by a warning while rendering") {
    const TemporaryFolder folder;
    const std::string scene = folder.write(
        "room.json",
        with(with(kSmallRoom, "\"ir_length_s\": 0.5", "\"ir_length_s\": 2, \"memory_mb\": 2"),
             "\"rays\": 200", "\"rays\": 50"));
    // The size in m after the word "of" in a line that begins with `key`.
    const auto size_m = [](const std::string& text, const std::string& key) {
        const std::size_t at = text.find(" of ", text.find(key));
        REQUIRE(at != std::string::npos);
        return std::stod(text.substr(at + 4));
    };
    const double listed_m = size_m(run_program({AULA_PROGRAM, "info", scene}).out, "\npatches");
    CHECK(listed_m > 0.6);
    const std::string file = folder.path() / "out.wav";
    for (const std::vector<std::string>& what :
         {std::vector<std::string>{"--offline", file, "--duration", "0.1"}, {"--report"}}) {
        CAPTURE(what);
        std::vector<std::string> command{AULA_PROGRAM, scene};
        command.insert(command.end(), what.begin(), what.end());
        const ProgramResult result = run_program(command);
        CHECK(result.status == 0);
        CHECK(size_m(result.err, "patches of") == Approx(listed_m).epsilon(0.02));
        CHECK_THAT(result.err, Contains("in place of 0.50 m: \"memory_mb\" 2"));
    }
    // Companion: enough memory.
    const std::string ample = folder.write("ample.json", kSmallRoom);
    CHECK(size_m(run_program({AULA_PROGRAM, "info", ample}).out, "\npatches") ==
          Approx(0.5).epsilon(0.01));
    CHECK(run_program({AULA_PROGRAM, ample, "--offline", file, "--duration", "0.1"})
              .err.find("patches") == std::string::npos);
}
