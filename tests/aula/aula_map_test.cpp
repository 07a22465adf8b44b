#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <sstream>
#include <thread>

#include "tests/aula/aula_program.h"
#include "tests/support/small_scenes.h"

namespace {

using namespace aula::test;

const std::vector<std::string> kSymbols{"C50",   "C80", "D50", "EDT", "G",   "J_LF",
                                        "J_LFC", "L_J", "STI", "T20", "T30", "Ts"};

/// kSmallRoom with few rays and a second source of that name.
std::string two_sources(const std::string& name) {
    const std::string source = "\"sources\": [";
    return with(with(kSmallRoom, "\"rays\": 200", "\"rays\": 50"), source,
                source + "{\"name\": \"" + name + "\", \"position\": [4.2, 0.8, 1.4]}, ");
}

ProgramResult mapped(const std::string& scene, const std::string& out,
                     const std::vector<std::string>& options) {
    std::vector<std::string> command{AULA_PROGRAM, "map", scene, "--out", out};
    command.insert(command.end(), options.begin(), options.end());
    ProgramResult result = run_program(command);
    INFO(result.err);
    REQUIRE(result.status == 0);
    return result;
}

/// [row][column] of a CSV file without quotes.
std::vector<std::vector<std::string>> read_csv(const std::filesystem::path& file) {
    std::vector<std::vector<std::string>> rows;
    std::istringstream text(read_file(file));
    for (std::string line; std::getline(text, line);) {
        std::vector<std::string> row;
        std::istringstream fields(line + ",");
        for (std::string field; std::getline(fields, field, ',');) row.push_back(field);
        rows.push_back(row);
    }
    return rows;
}

}  // namespace

TEST_CASE("A map has a picture and a table of each parameter, of the same bytes again") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::filesystem::path out = folder.path() / "deep/maps";
    const std::vector<std::string> options{"--spacing", "2", "--frames", "3", "--rays", "50"};
    mapped(scene, out, options);
    std::vector<std::string> expected;
    for (const std::string& symbol : kSymbols)
        for (const char* const end : {".csv", ".png"}) expected.push_back(symbol + end);
    std::sort(expected.begin(), expected.end());
    CHECK(names_in(out) == expected);
    std::vector<std::string> threads = options;
    threads.insert(threads.end(), {"--threads", "2"});
    mapped(scene, folder.path() / "again", threads);
    for (const std::string& name : expected) {
        INFO(name);
        CHECK((read_file(out / name) == read_file(folder.path() / "again" / name)));
    }
}

TEST_CASE("A map with IACC has its pictures and tables, too") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::filesystem::path out = folder.path() / "maps";
    mapped(scene, out,
           {"--interaural", "--spacing", "2", "--frames", "2", "--rays", "50", "--threads", "2"});
    CHECK(names_in(out).size() == 2 * kSymbols.size() + 4);
    CHECK(std::filesystem::exists(out / "IACC_L.png"));
    const auto rows = read_csv(out / "IACC_E.csv");
    REQUIRE(rows.size() == 5);
    for (std::size_t row = 1; row < rows.size(); ++row) {
        REQUIRE(rows[row].size() == 21);
        // At 63 Hz both ears hear the same; the single number is the mean of 500 to 2000 Hz.
        CHECK(std::stod(rows[row][4]) > 0.9);
        const double mean =
            (std::stod(rows[row][7]) + std::stod(rows[row][8]) + std::stod(rows[row][9])) / 3;
        CHECK(std::stod(rows[row][3]) == Approx(mean).epsilon(1e-5));
        CHECK(mean < 0.95);
        CHECK(std::stod(rows[row][12]) > 0);
    }
}

TEST_CASE("Maps of several sources have their names, and must differ in them") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", two_sources("a/b"));
    mapped(scene, folder.path() / "maps", {"--spacing", "4", "--frames", "1"});
    const auto names = names_in(folder.path() / "maps");
    CHECK(names.size() == 4 * kSymbols.size());
    CHECK(std::count(names.begin(), names.end(), "T30-a_b.png") == 1);
    CHECK(std::count(names.begin(), names.end(), "T30-hiss.csv") == 1);
    const std::string twice = with(two_sources("hi/s"), "\"hiss\"", "\"hi:s\"");
    const ProgramResult result = run_program(
        {AULA_PROGRAM, "map", folder.write("twice.json", twice), "--out", folder.path() / "none"});
    CHECK(result.status == 2);
    CHECK(result.err.find("-hi_s.csv") != std::string::npos);
}

TEST_CASE("The table of a map has positions, octaves and standard errors") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::filesystem::path out = folder.path();
    folder.write("T30.csv", "replaced");
    mapped(scene, out, {"--spacing", "2", "--height", "1.5", "--rays", "50"});
    const auto rows = read_csv(out / "T30.csv");
    REQUIRE(rows.size() == 5);  // two columns of two
    REQUIRE(rows[0].size() == 21);
    CHECK(rows[0][3] == "value");
    CHECK(rows[0][4] == "63");
    CHECK(rows[0][12] == "value_error");
    CHECK(rows[0][20] == "8000_error");
    CHECK(rows[1][0] == "1.5");
    CHECK(rows[1][1] == "1");
    CHECK(rows[1][2] == "1.5");
    for (std::size_t row = 1; row < rows.size(); ++row) {
        REQUIRE(rows[row].size() == 21);
        // The single number is the mean of 500 and 1000 Hz; six digits.
        const double mean = (std::stod(rows[row][7]) + std::stod(rows[row][8])) / 2;
        CHECK(std::stod(rows[row][3]) == Approx(mean).epsilon(1e-5));
        CHECK(std::stod(rows[row][12]) > 0);
        CHECK(std::stod(rows[row][12]) < 0.05 * mean);
    }
    CHECK(read_csv(out / "STI.csv")[0].size() == 5);
    // Third octaves take the place of octaves, but for lateral parameters.
    mapped(scene, out, {"--spacing", "2", "--frames", "2", "--rays", "50", "--third-octaves"});
    CHECK(read_csv(out / "G.csv")[0].size() == 4 + 26 + 1 + 26);
    CHECK(read_csv(out / "G.csv")[0][29] == "16000");
    CHECK_FALSE(read_csv(out / "G.csv")[1][29].empty());
    CHECK(read_csv(out / "J_LF.csv")[0].size() == 21);
    // A given number of frames has no errors.
    mapped(scene, out, {"--spacing", "2", "--frames", "2", "--rays", "50"});
    CHECK(read_csv(out / "C80.csv")[1].back().empty());
}

TEST_CASE("A map of a surface has receivers above it") {
    const TemporaryFolder folder;
    const std::string raked = R"("geometry": [{"name": "seats", "material": "audience",
        "vertices": [[1, 1, 0.2], [4, 1, 0.8], [4, 3, 0.8], [1, 3, 0.2]], "faces": [[0, 1, 2, 3]]},
        )";
    const std::string scene = folder.write("room.json", with(kSmallRoom, "\"geometry\": [", raked));
    const std::filesystem::path out = folder.path() / "maps";
    mapped(
        scene, out,
        {"--surface", "seats", "--offset", "1", "--spacing", "1", "--frames", "2", "--rays", "50"});
    const auto rows = read_csv(out / "C80.csv");
    REQUIRE(rows.size() == 7);  // 3 x 2
    for (std::size_t row = 1; row < rows.size(); ++row)
        CHECK(std::stod(rows[row][2]) == Approx(1 + 0.2 * std::stod(rows[row][0])));
    CHECK(std::filesystem::exists(out / "C80.png"));
}

TEST_CASE("Bad options of a map are refused with one line and status 2, without a folder") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::string out = folder.path() / "maps";
    const std::string file = folder.write("file", "");
    std::filesystem::create_directories(folder.path() / "taken/STI.png");
    std::filesystem::create_directory(folder.path() / "linked");
    std::filesystem::create_symlink(scene, folder.path() / "linked/C50.csv");
    const std::filesystem::path dangling = folder.path() / "dangling";
    std::filesystem::create_symlink("nothing", dangling);
    const std::string hidden = folder.write(".aula-hindered.part", "mine");
    const std::string yard = folder.write("yard.json", R"({"aula": 1, "geometry": [
        {"vertices": [[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], "faces": [[0, 1, 2, 3]],
         "material": "concrete"}],
        "sources": [{"position": [0, 0, 0]}], "listener": {"position": [2, 0, 0]}})");
    const std::vector<Refused> all = {
        {{"map"}, {"SCENE"}},
        {{"map", scene, "--out", folder.path() / "taken"}, {"STI.png", "is a folder"}},
        {{"map", scene, "--out", folder.path() / "linked"}, {"would replace the input"}},
        {{"map", scene, "--out", out, "--ir", "ir.wav"}, {"--ir", "aula map"}},
        {{"map", scene, "--out", out, "--list-devices"}, {"--list-devices", "aula map"}},
        {{"map", scene}, {"--out"}},
        {{"map", scene, "--out", file}, {"is not a folder"}},
        {{"map", scene, "--out", file + "/maps"}, {"is not a folder"}},
        {{"map", scene, "--out", dangling}, {"is not a folder"}},
        {{"map", scene, "--out", dangling / "maps"}, {"is not a folder"}},
        {{"map", scene, "--out", folder.path() / "hindered"}, {hidden, "is not a folder"}},
        {{"map", scene, "--out", out, "--spacing", "0"}, {"--spacing", "above 0"}},
        {{"map", scene, "--out", out, "--spacing", "-1"}, {"--spacing"}},
        {{"map", scene, "--out", out, "--spacing", "nan"}, {"--spacing"}},
        {{"map", scene, "--out", out, "--spacing", "1e-6"}, {"--spacing", "points"}},
        {{"map", scene, "--out", out, "--spacing", "0.02"}, {"--spacing", "pairs"}},
        {{"map", scene, "--out", out, "--height", "inf"}, {"--height"}},
        {{"map", scene, "--out", out, "--height", "3.5"}, {"--height", "below 3"}},
        {{"map", scene, "--out", out, "--height", "2.99"}, {"no receiver"}},
        {{"map", yard, "--out", out}, {"the geometry has no height; expected a room to map"}},
        {{scene, "--height", "1"}, {"--height", "aula map"}},
        {{scene, "--surface", "wall"}, {"--surface", "aula map"}},
        {{"map", scene, "--out", out, "--surface", "seats"}, {"--surface", "seats", "expected"}},
        {{"map", scene, "--out", out, "--surface", "wall", "--height", "1"}, {"--height"}},
        {{"map", scene, "--out", out, "--offset", "1"}, {"--offset", "--surface"}},
        {{"map", scene, "--out", out, "--surface", "wall", "--offset", "0"}, {"--offset"}},
        {{scene, "--out", out}, {"--out", "aula map"}},
        {{"info", scene, "--spacing", "1"}, {"--spacing", "aula map"}},
        {{scene, "--interaural"}, {"--interaural", "aula map"}},
    };
    for (const Refused& bad : all) require_refused(folder, bad.arguments, bad.parts);
    CHECK(names_in(folder.path() / "taken") == std::vector<std::string>{"STI.png"});
    CHECK(read_file(scene) == kSmallRoom);
    CHECK(read_file(hidden) == "mine");
}

TEST_CASE("A map creates a folder whose name ends with a dot") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    mapped(scene, folder.path() / "maps/.", {"--spacing", "4", "--frames", "1", "--rays", "50"});
    CHECK(names_in(folder.path()) == std::vector<std::string>{"maps", "room.json"});
    CHECK(std::filesystem::exists(folder.path() / "maps/STI.png"));
}

TEST_CASE("A map that cannot be written to its end leaves only what was there before") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    // No file may exceed 1024 bytes, as pictures do.
    const std::string limited = std::string("trap '' XFSZ; ulimit -f 1; exec '") + AULA_PROGRAM +
                                "' map " + scene + " --spacing 2 --frames 3 --rays 50 --out ";
    const auto out = folder.path() / "maps";
    const ProgramResult result =
        run_program({"/bin/bash", "-c", limited + (out / "deep/").string()});
    CHECK(result.status == 1);
    CHECK(result.err.find((out / "deep/").string()) != std::string::npos);
    CHECK(result.err.find(": cannot write") != std::string::npos);
    CHECK(result.err.find(".part") == std::string::npos);
    CHECK_FALSE(std::filesystem::exists(out));
    std::filesystem::create_directory(out);
    folder.write("maps/notes", "mine");
    CHECK(run_program({"/bin/bash", "-c", limited + out.string()}).status == 1);
    CHECK(names_in(out) == std::vector<std::string>{"notes"});
}

TEST_CASE("An interrupted map leaves no folder") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    Program program(
        {AULA_PROGRAM, "map", scene, "--out", folder.path() / "maps", "--frames", "1000000"});
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    program.signal(SIGINT);
    const ProgramResult result = program.wait();
    INFO(result.err);
    CHECK(result.status == 130);
    CHECK(names_in(folder.path()) == std::vector<std::string>{"room.json"});
}
