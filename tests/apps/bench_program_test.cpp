#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

namespace {

/// A folder of its own, gone at the end.
class Folder {
 public:
    Folder() {
        std::string name = std::filesystem::temp_directory_path() / "aula_bench_XXXXXX";
        REQUIRE(mkdtemp(name.data()) != nullptr);
        path_ = name;
    }
    ~Folder() { std::filesystem::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    std::string file(const std::string& name) const { return path_ / name; }

    std::string read(const std::string& name) const {
        std::ifstream in(path_ / name);
        std::ostringstream text;
        text << in.rdbuf();
        return text.str();
    }

    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(path_ / name) << text;
        return file(name);
    }

 private:
    std::filesystem::path path_;
};

/// Runs aula-bench; its exit code. Its outputs are in the folder's files "out" and "err".
int run(const Folder& folder, const std::string& arguments) {
    const std::string command = std::string(AULA_BENCH_PROGRAM) + " " + arguments + " >" +
                                folder.file("out") + " 2>" + folder.file("err");
    const int status = std::system(command.c_str());
    REQUIRE(WIFEXITED(status));
    return WEXITSTATUS(status);
}

/// A small room through which the listener walks a tenth of a second.
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

TEST_CASE("bench_smoke: noise prints a row an estimator and writes the figures as JSON") {
    const Folder folder;
    const std::string scene = folder.write("room.json", kScene);
    REQUIRE(run(folder, "noise " + scene + " --restarts 3 --reference-rays 1 --json " +
                            folder.file("rows.json")) == 0);
    const nlohmann::json document = nlohmann::json::parse(folder.read("rows.json"));
    CHECK(document.at("machine").is_string());
    REQUIRE(document.at("rows").size() == 8);
    const std::string table = folder.read("out");
    for (const nlohmann::json& row : document["rows"]) {
        check_keys(row, {"bench", "scene", "basis", "estimator", "rays", "order", "tau_s", "frames",
                         "position", "frame_ms", "noise", "direction_noise_deg", "energy_ratio",
                         "memory_mb"});
        CHECK(row["bench"] == "noise");
        CHECK(row["scene"] == "room.json");
        CHECK(table.find(row["estimator"].get<std::string>()) != std::string::npos);
    }
    CHECK(document["rows"][0]["basis"] == "rays");
    CHECK(document["rows"][0]["frames"] == 1);
    CHECK(document["rows"][3]["frames"] == 3);
    CHECK(document["rows"][4]["basis"] == "cpu");
    CHECK(folder.read("err").empty());
}

TEST_CASE("bench_smoke: a sweep has rows for every tau and lambda and draws them") {
    const Folder folder;
    const std::string scene = folder.write("room.json", kScene);
    REQUIRE(run(folder, "sweep " + scene + " --restarts 2 --reference-rays 1 --plot " +
                            folder.file("") + " --json " + folder.file("rows.json")) == 0);
    const nlohmann::json rows = nlohmann::json::parse(folder.read("rows.json")).at("rows");
    REQUIRE(rows.size() == 40);  // four estimators at five of each
    std::set<double> taus_s;
    std::set<double> sizes_m;
    for (const nlohmann::json& row : rows) {
        CHECK(row["bench"] == "sweep");
        taus_s.insert(row["tau_s"].get<double>());
        sizes_m.insert(row["patch_size_m"].get<double>());
    }
    CHECK(taus_s.size() >= 5);
    CHECK(sizes_m.size() == 5);
    for (const char* file : {"sweep_tau_room.svg", "sweep_lambda_room.svg"}) {
        const std::string drawing = folder.read(file);
        CHECK(drawing.find("</svg>") != std::string::npos);
        for (const char* text : {"dpc-published", "patch", "energy over the reference's"}) {
            CHECK(drawing.find(text) != std::string::npos);
        }
        CHECK(drawing.find("nan") == std::string::npos);
        CHECK(drawing.find("inf") == std::string::npos);
    }
}

TEST_CASE("bench_smoke: tracking prints a row for each mover and estimator") {
    const Folder folder;
    const std::string scene = folder.write("room.json", kScene);
    REQUIRE(run(folder, "tracking " + scene +
                            " --estimator pt --estimator patch --positions 2 --reference-rays 1 "
                            "--json " +
                            folder.file("rows.json")) == 0);
    const nlohmann::json document = nlohmann::json::parse(folder.read("rows.json"));
    REQUIRE(document.at("rows").size() == 12);
    for (const nlohmann::json& row : document["rows"]) {
        check_keys(row, {"bench", "scene", "basis", "mover", "estimator", "rays", "frame_ms",
                         "tracking_error", "energy_ratio"});
    }
    CHECK(document["rows"][0]["mover"] == "listener");
    CHECK(document["rows"][4]["mover"] == "source");
    CHECK(document["rows"][8]["mover"] == "both");
}

TEST_CASE("bench_smoke: many sources are compared with one") {
    const Folder folder;
    const std::string scene = folder.write("room.json", kScene);
    REQUIRE(run(folder, "sources " + scene + " --sources 3 --reference-rays 1 --json " +
                            folder.file("rows.json")) == 0);
    const nlohmann::json document = nlohmann::json::parse(folder.read("rows.json"));
    REQUIRE(document.at("rows").size() == 4);
    CHECK(document["rows"][0]["listener"] == "stands");
    CHECK(document["rows"][1]["sources"] == 3);
    CHECK(document["rows"][2]["cost_to_one"] == 1);
    CHECK(document["rows"][3]["tracking_error"].get<double>() > 0);
}

TEST_CASE("bench_smoke: trace compares whole frames with Embree alone") {
    const Folder folder;
    const std::string scene = folder.write("room.json", kScene);
    REQUIRE(run(folder, "trace " + scene + " --json " + folder.file("rows.json")) == 0);
    const nlohmann::json document = nlohmann::json::parse(folder.read("rows.json"));
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
    const Folder folder;
    REQUIRE(run(folder, "convolve --ir-length 0.05 --block 512 --rounds 1 --json " +
                            folder.file("rows.json")) == 0);
    const nlohmann::json document = nlohmann::json::parse(folder.read("rows.json"));
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

TEST_CASE("bench_smoke: bad input is one line and exit code 2") {
    const Folder folder;
    const std::string still =
        folder.write("still.json", R"({"aula": 1, "listener": {"position": [1, 0, 0]},
          "sources": [{"name": "a", "position": [0, 0, 0], "signal": "impulse"}]})");
    for (const std::string& arguments :
         {std::string("noise ") + folder.file("absent.json"), std::string("noise"),
          "noise --restarts 1 " + still, "noise --estimator best " + still, "tracking " + still}) {
        CAPTURE(arguments);
        CHECK(run(folder, arguments) == 2);
        const std::string error = folder.read("err");
        CAPTURE(error);
        CHECK(error.rfind("aula-bench: ", 0) == 0);
        CHECK(std::count(error.begin(), error.end(), '\n') == 1);
        CHECK(folder.read("out").empty());
    }
}
