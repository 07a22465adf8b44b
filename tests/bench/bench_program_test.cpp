#include <signal.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/program.h"
#include "tests/support/wait.h"

namespace {

using namespace aula::test;

/// Runs aula-bench with words that a space separates.
ProgramResult run(const std::string& arguments) {
    std::vector<std::string> command{AULA_BENCH_PROGRAM};
    std::istringstream words(arguments);
    for (std::string word; words >> word;) command.push_back(word);
    return run_program(command);
}

std::string json_in(const TemporaryFolder& folder) { return folder.path() / "rows.json"; }

/// Rows that a run wrote to the file.
nlohmann::json rows_in(const TemporaryFolder& folder) {
    return nlohmann::json::parse(read_file(json_in(folder)));
}

/// A small room in which the listener walks for a tenth of a second.
constexpr const char* kScene = R"({
  "aula": 1,
  "geometry": [{"box": [5, 4, 3], "material": "wall"}],
  "materials": {"wall": {"absorption": 0.3, "scattering": 0.5}},
  "sources": [{"name": "source", "position": [1.2, 1.1, 1.5], "signal": "impulse"}],
  "listener": {"position": [3.7, 2.9, 1.2], "path": {"points": [
      {"t": 0, "position": [3.7, 2.9, 1.2]}, {"t": 0.1, "position": [3.6, 2.9, 1.2]}]}},
  "simulation": {"rays": 50, "response_time_s": 0.1, "ir_length_s": 0.3, "threads": 1}
})";

void check_keys(const nlohmann::json& row, const std::vector<std::string>& keys) {
    for (const std::string& key : keys) {
        CAPTURE(key);
        CHECK(row.contains(key));
    }
}

}  // namespace

TEST_CASE("bench_smoke: noise prints a row for each estimator and writes the figures as JSON") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    const ProgramResult result =
        run("noise " + scene + " --restarts 3 --reference-rays 1 --json " + json_in(folder));
    REQUIRE(result.status == 0);
    const nlohmann::json document = rows_in(folder);
    CHECK(document.at("machine").is_string());
    REQUIRE(document.at("rows").size() == 8);
    for (const nlohmann::json& row : document["rows"]) {
        check_keys(row, {"bench", "scene", "basis", "estimator", "rays", "order", "tau_s", "frames",
                         "position", "frame_ms", "noise", "direction_noise_deg", "energy_ratio",
                         "memory_mb"});
        CHECK(row["bench"] == "noise");
        CHECK(row["scene"] == "room.json");
        CHECK(result.out.find(row["estimator"].get<std::string>()) != std::string::npos);
    }
    CHECK(document["rows"][0]["basis"] == "rays");
    CHECK(document["rows"][0]["frames"] == 1);
    CHECK(document["rows"][3]["frames"] == 3);
    CHECK(document["rows"][4]["basis"] == "cpu");
    CHECK(result.err.empty());
}

TEST_CASE("bench_smoke: waves prints the modes of a room, and that a half-open one has none") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    const std::string open = folder
                                 .write("open.json", R"({"aula": 1,
        "geometry": [{"vertices": [[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]],
                      "faces": [[0, 1, 2, 3]], "material": "wall"}],
        "materials": {"wall": {"absorption": 0.3, "scattering": 0.5}},
        "sources": [{"name": "a", "position": [1, 1, 1], "signal": "impulse"}],
        "listener": {"position": [3, 3, 1]}})")
                                 .string();
    REQUIRE(run("waves " + scene + " " + open + " --json " + json_in(folder)).status == 0);
    const nlohmann::json rows = rows_in(folder).at("rows");
    REQUIRE(rows.size() == 2);
    check_keys(rows[0],
               {"bench", "scene", "field", "volume_m3", "schroeder_hz", "highest_hz", "cells",
                "modes", "expected_modes", "memory_mb", "grid_s", "modes_s", "poles_s", "moved_s",
                "pair_ms", "frame_ms", "over_rays_db", "difference_db"});
    CHECK(rows[0]["volume_m3"].get<double>() == Approx(60).epsilon(1e-3));
    CHECK(rows[0]["difference_db"] < 0.5);
    CHECK(rows[0]["memory_mb"] < 100);
    CHECK(std::abs(rows[0]["over_rays_db"].get<double>()) < 6);
    CHECK(rows[1]["field"] == "open, no modes");
}

TEST_CASE("bench_smoke: a sweep has rows for five values of tau, then for five of lambda") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    REQUIRE(run("sweep " + scene + " --restarts 2 --reference-rays 1 --json " + json_in(folder))
                .status == 0);
    const nlohmann::json rows = rows_in(folder).at("rows");
    REQUIRE(rows.size() == 40);  // four estimators
    std::set<double> taus_s;
    std::set<double> sizes_m;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        CHECK(rows[i]["bench"] == "sweep");
        if (i < 20) taus_s.insert(rows[i]["tau_s"].get<double>());
        if (i >= 20) sizes_m.insert(rows[i]["patch_size_m"].get<double>());
    }
    CHECK(taus_s.size() == 5);
    CHECK(sizes_m.size() == 5);
}

TEST_CASE("bench_smoke: a command measures several scenes, and tracking several walks") {
    const TemporaryFolder folder;
    const std::string a = folder.write("a.json", kScene).string();
    const std::string b = folder.write("b.json", kScene).string();
    const ProgramResult result =
        run("tracking --estimator patch --quick --reference-rays 1 --walks 3 " + a + " " + b +
            " --json " + json_in(folder));
    REQUIRE(result.status == 0);
    std::map<std::string, int> rows_of;
    const nlohmann::json rows = rows_in(folder).at("rows");
    for (const nlohmann::json& row : rows) {
        ++rows_of[row["scene"]];
        CHECK(row["walks"] == 3);
        CHECK(row["energy_ratio_error"] > 0);
    }
    // One row for each end that moves, and none at equal CPU time without another estimator.
    CHECK(rows_of == std::map<std::string, int>{{"a.json", 3}, {"b.json", 3}});
}

TEST_CASE("bench_smoke: changes compares the worst frame of each change with the mean") {
    const TemporaryFolder folder;
    const std::string door = R"({"box": [0.1, 1, 2], "material": "wall", "path": {"points": [
        {"t": 0, "position": [2, 1, 0]}, {"t": 0.5, "position": [2, 2, 0]}]}}, )";
    for (const bool moving : {false, true}) {
        CAPTURE(moving);
        std::string text = kScene;
        if (moving) text.insert(text.find(R"({"box")"), door);
        const std::string scene = folder.write("room.json", text).string();
        const ProgramResult result = run("changes " + scene + " --json " + json_in(folder));
        REQUIRE(result.status == 0);
        const nlohmann::json rows = rows_in(folder).at("rows");
        std::set<std::string> names;
        for (const nlohmann::json& row : rows) {
            check_keys(row, {"bench", "scene", "change", "rays", "frames", "frame_cpu_ms",
                             "worst_cpu_ms", "worst_to_mean", "worst_frame"});
            CHECK(row["bench"] == "changes");
            CHECK(row["worst_to_mean"] >= 1);
            CHECK(row["worst_frame"] < row["frames"]);
            names.insert(row["change"].get<std::string>());
        }
        CHECK(names.contains("both jump"));
        // Objects are moved only where they have paths.
        CHECK(names.contains("objects move") == moving);
        CHECK(names.size() == rows.size());
        CHECK(rows.size() == (moving ? 8 : 7));
    }
}

TEST_CASE("bench_smoke: --markdown writes the printed figures under their command and machine") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    const std::string file = folder.path() / "measured.md";
    const std::string arguments =
        "all --restarts 2 --reference-rays 1 --quick --estimator patch "
        "--ir-length 0.05 --block 512 --rounds 1 --sources 2 --json " +
        json_in(folder) + " --markdown " + file + " " + scene;
    const ProgramResult result = run(arguments);
    REQUIRE(result.status == 0);
    const std::string document = read_file(file);
    CHECK(document.rfind("# Measurements by `aula-bench " + arguments + "`\n", 0) == 0);
    for (const char* fact : {"| processor | ", "| commit | ", "| date | 20", "| compiler | "}) {
        CAPTURE(fact);
        CHECK(document.find(fact) != std::string::npos);
    }
    for (const char* section :
         {"\n## noise of room.json: 12 triangles", "\n## 10 s at rest in ", "\n## tracking in ",
          "\n## fluctuation during a walk in ", "\n## tracing in ", "\n## many sources in ",
          "\n## receivers of a measurement in ", "\n## changes in ", "\n## diffraction in ",
          "\n## convolution", "\n## preparing"}) {
        CAPTURE(section);
        CHECK(document.find(section) != std::string::npos);
    }
    // One line per row of all tables, two lines above each of the eleven tables, one line per fact
    // of the head.
    std::istringstream lines(document);
    std::size_t table_lines = 0;
    for (std::string line; std::getline(lines, line);) table_lines += line.rfind('|', 0) == 0;
    const nlohmann::json rows = rows_in(folder).at("rows");
    CHECK(table_lines == rows.size() + 2 * 11 + 2 + 7);
    // --quick sets the sizes that are not given.
    for (const nlohmann::json& row : rows) {
        if (row["bench"] == "noise") CHECK(row["restarts"] == 2);
        if (row["bench"] == "tracking") CHECK(row["positions"] == 3);
    }
}

TEST_CASE("bench_smoke: in a scene without paths all measurements but those of movement are made") {
    const TemporaryFolder folder;
    const std::string scene =
        folder
            .write("still.json",
                   R"({"aula": 1, "geometry": [{"box": [5, 4, 3], "material": "wood"}],
          "sources": [{"position": [1, 1, 1]}], "listener": {"position": [3, 2, 1]},
          "simulation": {"rays": 50, "response_time_s": 0.1, "ir_length_s": 0.3, "threads": 1}})")
            .string();
    REQUIRE(run("all --quick --restarts 2 --reference-rays 1 --estimator patch --ir-length 0.05 "
                "--json " +
                json_in(folder) + " --rounds 1 --block 512 " + scene)
                .status == 0);
    std::set<std::string> benches;
    const nlohmann::json rows = rows_in(folder).at("rows");
    for (const nlohmann::json& row : rows) benches.insert(row["bench"]);
    CHECK(benches == std::set<std::string>{"noise", "trace", "receivers", "rest", "changes",
                                           "diffraction", "convolve", "prepare"});
}

TEST_CASE(
    "bench_smoke: diffraction prints a row for one source, for eight and for loading, and skips a "
    "missing level") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    const ProgramResult result =
        run("diffraction " + scene + " --level missing.obj --json " + json_in(folder));
    REQUIRE(result.status == 0);
    CHECK(result.out.find("skipped, no missing.obj") != std::string::npos);
    const nlohmann::json rows = rows_in(folder).at("rows");
    REQUIRE(rows.size() == 3);
    for (const std::size_t i : {0U, 1U}) {
        const nlohmann::json& row = rows[i];
        check_keys(row, {"bench", "scene", "basis", "sources", "edges", "frame_ms",
                         "diffraction_ms", "diffraction_share"});
        CHECK(row["edges"] == 12);
        CHECK(row["diffraction_share"].get<double>() > 0);
        CHECK(row["diffraction_share"].get<double>() < 1);
    }
    CHECK(rows[0]["sources"] == 1);
    CHECK(rows[1]["sources"] == 8);
    CHECK(rows[2]["triangles"] == 100'008);  // copies of twelve
    CHECK(rows[2]["edges"] == 100'008);
    CHECK(rows[2]["edges_s"].get<double>() > 0);
}

TEST_CASE("bench_smoke: tracking prints a row for each mover and estimator") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    REQUIRE(run("tracking " + scene +
                " --estimator pt --estimator patch --positions 2 --reference-rays 1 "
                "--json " +
                json_in(folder))
                .status == 0);
    const nlohmann::json document = rows_in(folder);
    REQUIRE(document.at("rows").size() == 12);
    for (const nlohmann::json& row : document["rows"]) {
        check_keys(row, {"bench", "scene", "basis", "mover", "estimator", "rays", "frame_ms",
                         "tracking_error", "energy_ratio"});
    }
    CHECK(document["rows"][0]["mover"] == "listener");
    CHECK(document["rows"][4]["mover"] == "source");
    CHECK(document["rows"][8]["mover"] == "both");
}

TEST_CASE("bench_smoke: at rest the rays fill the time of a frame") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    REQUIRE(run("rest " + scene + " --frame-ms 2 --reference-rays 1 --json " + json_in(folder))
                .status == 0);
    const nlohmann::json document = rows_in(folder);
    REQUIRE(document.at("rows").size() == 1);
    const nlohmann::json& row = document["rows"][0];
    check_keys(row, {"bench", "scene", "basis", "estimator", "rays", "frames", "frame_cpu_ms",
                     "rest_error", "energy_ratio", "reference_error"});
    CHECK(row["energy_ratio"].get<double>() == Approx(1).margin(0.1));
    // 16,384 rays of the reference err by a few percent, the estimator by less.
    CHECK(row["rest_error"].get<double>() < 0.1);
}

TEST_CASE("bench_smoke: during a walk each octave has its fluctuation") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    const std::string few = "fluctuation " + scene + " --json " + json_in(folder);
    REQUIRE(run(few).status == 0);
    const nlohmann::json at_own_rays = rows_in(folder).at("rows");
    REQUIRE(run(few + " --rays 1").status == 0);
    const nlohmann::json at_few_rays = rows_in(folder).at("rows");
    REQUIRE(at_own_rays.size() == 7);
    double sum_db = 0;
    double sum_of_few_db = 0;
    for (std::size_t i = 0; i < at_own_rays.size(); ++i) {
        const nlohmann::json& row = at_own_rays[i];
        check_keys(row, {"bench", "scene", "octave_hz", "rays", "windows", "fluctuation_db",
                         "largest_db"});
        CHECK(row["octave_hz"] == 125 << i);
        CHECK(row["fluctuation_db"].get<double>() > 0);
        CHECK(row["largest_db"] >= row["fluctuation_db"]);
        sum_db += row["fluctuation_db"].get<double>();
        sum_of_few_db += at_few_rays[i]["fluctuation_db"].get<double>();
    }
    // The walk has two windows: a single octave may be close by chance.
    CHECK(sum_of_few_db > 1.5 * sum_db);
}

TEST_CASE("bench_smoke: many sources are compared with one") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    REQUIRE(run("sources " + scene + " --sources 3 --reference-rays 1 --json " + json_in(folder))
                .status == 0);
    const nlohmann::json document = rows_in(folder);
    REQUIRE(document.at("rows").size() == 6);
    CHECK(document["rows"][0]["mover"] == "none");
    CHECK(document["rows"][1]["sources"] == 3);
    CHECK(document["rows"][2]["cost_to_one"] == 1);
    CHECK(document["rows"][3]["tracking_error"].get<double>() > 0);
    CHECK(document["rows"][4]["mover"] == "all");
    CHECK(document["rows"][5]["tracking_error"].get<double>() > 0);
}

TEST_CASE("bench_smoke: a receiver is compared with the rays of a source") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    REQUIRE(run("receivers " + scene + " --rays 1000 --json " + json_in(folder)).status == 0);
    const nlohmann::json document = rows_in(folder);
    REQUIRE(document.at("rows").size() == 1);
    const nlohmann::json row = document["rows"][0];
    check_keys(row, {"bench", "scene", "rays", "receivers", "source_trace_ms", "receiver_ms",
                     "first_receiver_ms", "receiver_to_trace"});
    CHECK(row["receiver_to_trace"].get<double>() ==
          Approx(row["receiver_ms"].get<double>() / row["source_trace_ms"].get<double>()));
    CHECK(row["receiver_ms"].get<double>() > 0);
}

TEST_CASE("bench_smoke: heard has the figures of the reverberation near those of theory") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    REQUIRE(run("heard " + scene + " --json " + json_in(folder)).status == 0);
    const nlohmann::json document = rows_in(folder);
    REQUIRE(document.at("rows").size() == 1);
    const nlohmann::json& row = document["rows"][0];
    check_keys(row, {"bench", "scene", "density_5", "density_20", "density_50", "density_100",
                     "kurtosis_250", "kurtosis_1000", "kurtosis_4000", "spectrum_db",
                     "t20_error_percent", "t20_deviation_percent", "t20_error_hz",
                     "correlation_100", "correlation_1000", "tone_db", "tone_1500_db"});
    // Statistical, of one short response; T20 of the mean decay of many noises.
    CHECK(row["kurtosis_4000"].get<double>() == Approx(3).margin(2.5));
    CHECK(row["spectrum_db"].get<double>() == Approx(5.57).margin(2));
    CHECK(std::abs(row["t20_error_percent"].get<double>()) < 5);
}

TEST_CASE("bench_smoke: budget has the rays and the time of each quality") {
    const TemporaryFolder folder;
    // Nine renderings of 10 s.
    std::string text = kScene;
    text.insert(text.rfind("}\n}"), R"(, "frame_rate_hz": 5, "waves": false)");
    const std::string scene = folder.write("room.json", text).string();
    REQUIRE(run("budget " + scene + " --json " + json_in(folder)).status == 0);
    const nlohmann::json document = rows_in(folder);
    REQUIRE(document.at("rows").size() == 9);
    for (const nlohmann::json& row : document["rows"]) {
        check_keys(row, {"bench", "scene", "quality", "movement", "sources", "response_s", "rays",
                         "cpu_per_second", "counted_to_measured"});
        CHECK(row["cpu_per_second"].get<double>() > 0);
        CHECK(row["counted_to_measured"].get<double>() > 0);
    }
    CHECK(document["rows"][0]["quality"] == "draft");
    CHECK(document["rows"][2]["quality"] == "fine");
    CHECK(document["rows"][2]["rays"] == 1000);
    CHECK(document["rows"][8]["movement"] == "moving");
    CHECK(document["rows"][8]["sources"] == 16);
}

TEST_CASE("bench_smoke: trace compares whole frames with Embree alone") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kScene).string();
    REQUIRE(run("trace " + scene + " --json " + json_in(folder)).status == 0);
    const nlohmann::json document = rows_in(folder);
    REQUIRE(document.at("rows").size() == 4);
    for (const nlohmann::json& row : document["rows"]) {
        check_keys(row, {"bench", "scene", "basis", "triangles", "threads", "segments_per_s",
                         "raw_per_s", "ratio"});
        CHECK(row["triangles"] == 12);
        CHECK(row["segments_per_s"].get<double>() > 0);
        CHECK(row["raw_per_s"].get<double>() > 0);
    }
}

TEST_CASE("bench_smoke: convolve has a row for each library, with and without exchange") {
    const TemporaryFolder folder;
    REQUIRE(
        run("convolve --ir-length 0.05 --block 512 --rounds 1 --json " + json_in(folder)).status ==
        0);
    const nlohmann::json document = rows_in(folder);
    int exchanging = 0;
    int prepared = 0;
    for (const nlohmann::json& row : document.at("rows")) {
        check_keys(row, {"bench", "scene", "basis", "library", "sources", "channels", "ir_s",
                         "block", "mean_us", "ratio"});
        CHECK(row["basis"] == "cpu");
        CHECK(row["mean_us"].get<double>() > 0);
        if (row["bench"] == "prepare") {
            check_keys(row, {"changed", "fft_us"});
            ++prepared;
            continue;
        }
        check_keys(row, {"exchange_hz", "worst_us"});
        if (row["library"] == "aula") CHECK(row["ratio"] == 1);
        if (row["exchange_hz"] == 30) ++exchanging;
    }
    // Four numbers of sources and channels, two precisions; all, a fifth, nothing changed.
    CHECK(exchanging == 8);
    CHECK(prepared == 12);
}

TEST_CASE("bench_smoke: an interrupted measurement leaves no files") {
    const TemporaryFolder folder;
    const std::filesystem::path outputs = folder.path() / "outputs";
    std::filesystem::create_directory(outputs);
    Program program({AULA_BENCH_PROGRAM, "noise", folder.write("room.json", kScene).string(),
                     "--restarts", "1000000", "--json", (outputs / "rows.json").string(),
                     "--markdown", (outputs / "tables.md").string()});
    REQUIRE(eventually([&] { return names_in(outputs).size() == 2; }));
    program.signal(SIGTERM);
    CHECK(program.wait().status == 143);
    CHECK(names_in(outputs).empty());
}

TEST_CASE("bench_smoke: invalid input gives one line and exit status 2") {
    const TemporaryFolder folder;
    const std::string still =
        folder
            .write("still.json", R"({"aula": 1, "listener": {"position": [1, 0, 0]},
          "sources": [{"name": "a", "position": [0, 0, 0], "signal": "impulse"}]})")
            .string();
    const std::string nowhere = folder.path() / "no" / "rows.json";
    const std::string one = folder.path() / "one";
    for (const std::string& arguments :
         {"noise " + (folder.path() / "absent.json").string(), std::string("noise"),
          "noise --restarts 1 " + still, "noise --estimator best " + still, "tracking " + still,
          "noise " + still + " --json " + nowhere, "noise " + still + " --markdown " + nowhere,
          "noise " + still + " --json " + one + " --markdown " + one}) {
        CAPTURE(arguments);
        const ProgramResult result = run(arguments);
        CHECK(result.status == 2);
        CAPTURE(result.err);
        CHECK(result.err.rfind("aula-bench: ", 0) == 0);
        CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
        CHECK(result.out.empty());
    }
}
