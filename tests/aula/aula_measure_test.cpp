#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "aula/audio/sound_file.h"
#include "tests/aula/aula_program.h"
#include "tests/support/small_scenes.h"

namespace {

using namespace aula::test;

ProgramResult measured(const std::string& scene, const std::vector<std::string>& options) {
    std::vector<std::string> command{AULA_PROGRAM, scene};
    command.insert(command.end(), options.begin(), options.end());
    ProgramResult result = run_program(command);
    INFO(result.err);
    REQUIRE(result.status == 0);
    REQUIRE(result.err.empty());
    return result;
}

struct Row {
    std::string source;
    double time_s = 0;
    std::array<double, 8> energy{};
};

std::vector<Row> read_echogram(const std::filesystem::path& file) {
    std::istringstream text(read_file(file));
    std::string line;
    std::getline(text, line);
    REQUIRE(line == "source,time_s,63,125,250,500,1000,2000,4000,8000");
    std::vector<Row> rows;
    while (std::getline(text, line)) {
        std::istringstream fields(line);
        std::string field;
        Row row;
        std::getline(fields, row.source, ',');
        std::getline(fields, field, ',');
        row.time_s = std::stod(field);
        for (double& energy : row.energy) {
            REQUIRE(std::getline(fields, field, ','));
            energy = std::stod(field);
        }
        REQUIRE(fields.eof());
        rows.push_back(row);
    }
    return rows;
}

std::size_t loudest(const std::vector<float>& samples) {
    return static_cast<std::size_t>(
        std::max_element(samples.begin(), samples.end(),
                         [](float a, float b) { return std::abs(a) < std::abs(b); }) -
        samples.begin());
}

}  // namespace

TEST_CASE("In free field the impulse response is 1/d at d/c, times the gain") {
    const TemporaryFolder folder;
    std::string text = kFreeField;
    text.replace(text.find("\"impulse\""), 9, "\"impulse\", \"gain_db\": 6.0206");
    const std::string scene = folder.write("free.json", text);
    const std::string out = folder.path() / "ir.wav";
    measured(scene, {"--ir", out, "--frames", "1", "--output", "mono"});
    const auto samples = aula::read_sound(out, 48000).samples;
    // 3.432 m at 343.2 m/s is 480 samples, 6.0206 dB a factor of 2.
    REQUIRE(loudest(samples) == 480);
    // Rounding of single precision in the filter and delay design: 0.1 dB.
    REQUIRE(static_cast<double>(samples[480]) == Approx(2 / 3.432).epsilon(0.0116));
}

TEST_CASE("The echogram's direct sound is 1/(4 pi d^2) in the bin of d/c, without the gain") {
    const TemporaryFolder folder;
    std::string text = kFreeField;
    text.replace(text.find("\"impulse\""), 9, "\"impulse\", \"gain_db\": 6.0206");
    text.replace(text.find("3.432"), 5, "3.6036");  // 10.5 ms: clear of the bins' edges
    const std::string scene = folder.write("free.json", text);
    const std::string out = folder.path() / "out.csv";
    measured(scene, {"--echogram", out, "--frames", "1"});
    const auto rows = read_echogram(out);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        REQUIRE(rows[i].source == "click");
        REQUIRE(rows[i].time_s == Approx(1e-3 * static_cast<double>(i)).margin(1e-9));
        for (const double energy : rows[i].energy)
            REQUIRE(energy ==
                    (i == 10 ? Approx(1 / (4 * std::numbers::pi * 3.6036 * 3.6036)) : Approx(0)));
    }
}

TEST_CASE("The sum of the echogram's bins is independent of their width") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const auto total = [&](const std::string& bin_ms, std::size_t rows_expected) {
        const std::string out = folder.path() / "out.csv";
        measured(scene, {"--echogram", out, "--frames", "3", "--bin-ms", bin_ms});
        const auto rows = read_echogram(out);
        REQUIRE(rows.size() == rows_expected);
        double sum = 0;
        for (const Row& row : rows) sum += row.energy[4];
        return sum;
    };
    // 0.5 s; rounding: nine digits in the file.
    const double fine = total("1", 500);
    REQUIRE(fine > 0);
    REQUIRE(total("10", 50) == Approx(fine).epsilon(1e-5));
    REQUIRE(total("250", 2) == Approx(fine).epsilon(1e-5));
}

TEST_CASE("The report is a table of all bands, and JSON with a number or null for each value") {
    const TemporaryFolder folder;
    std::string text = kSmallRoom;
    text.replace(text.find("\"hiss\""), 6, "\"he said \\\"hiss\\\"\"");
    const std::string scene = folder.write("room.json", text);
    const std::string out = folder.path() / "out.json";
    const ProgramResult result = measured(scene, {"--report=" + out, "--frames", "20"});
    for (const char* label : {"T20", "T30", "EDT", "C50", "C80", "D50", "Ts", "G", "63", "8000"})
        CHECK(result.out.find(label) != std::string::npos);
    const std::string json = read_file(out);
    CHECK(json.find("nan") == std::string::npos);
    CHECK(json.find("inf") == std::string::npos);
    const auto report = nlohmann::json::parse(json);
    REQUIRE(report["sources"].size() == 1);
    REQUIRE(report["sources"][0]["name"] == "he said \"hiss\"");
    const auto& bands = report["sources"][0]["bands"];
    REQUIRE(bands.size() == 8);
    for (const char* band : {"63", "125", "250", "500", "1000", "2000", "4000", "8000"}) {
        REQUIRE(bands.contains(band));
        for (const char* name : {"T20", "T30", "EDT", "C50", "C80", "D50", "Ts", "G"})
            CHECK((bands[band].at(name).is_number() || bands[band].at(name).is_null()));
        CHECK((bands[band]["EDT"] > 0.1 && bands[band]["EDT"] < 1));
        CHECK((bands[band]["D50"] > 0 && bands[band]["D50"] < 1));
    }
}

TEST_CASE("Parameters without enough decay are null in JSON and a dash in the table") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("free.json", kFreeField);
    const std::string out = folder.path() / "out.json";
    const ProgramResult result =
        run_program({AULA_PROGRAM, scene, "--report=" + out, "--frames", "1"});
    CHECK(result.status == 0);
    CHECK(result.err.find("no T30 at 63, 125") != std::string::npos);
    CHECK(read_file(out).find("\"T30\":null") != std::string::npos);
    CHECK(result.out.find(" -") != std::string::npos);
}

TEST_CASE("A report has the speech transmission index for given levels of speech and noise") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const auto sti = [&](std::vector<std::string> options) {
        const std::string out = folder.path() / "out.json";
        options.insert(options.end(), {"--report=" + out, "--frames", "20"});
        CHECK(measured(scene, options).out.find("STI") != std::string::npos);
        return nlohmann::json::parse(read_file(out))["sources"][0]["STI"].get<double>();
    };
    const double quiet = sti({});
    const double noisy = sti({"--noise-level", "60"});
    CHECK(noisy < quiet - 0.1);
    // Speech louder than noise by as much as without noise above 15 dB: no noise counts.
    CHECK(sti({"--noise-level", "60", "--speech-level", "80"}) > noisy + 0.1);
    const std::string levels = "0,62.9,62.9,59.2,53.2,47.2,41.2,35.2";
    CHECK(sti({"--speech-level", levels}) == Approx(quiet).epsilon(1e-5));
    // 63 Hz is not used.
    CHECK(sti({"--noise-level", "90,0,0,0,0,0,0,0"}) == Approx(quiet).margin(1e-3));
    // The levels of the scene, and options in their place.
    std::string text = kSmallRoom;
    text.insert(1, R"("speech": {"level_db": 70, "noise_level_db": 70}, )");
    folder.write("room.json", text);
    CHECK(sti({}) == Approx(noisy).margin(0.02));
    CHECK(sti({"--noise-level", "-100", "--speech-level", "60"}) == Approx(quiet).epsilon(1e-5));
}

TEST_CASE("Several sources give one response file each, with the source's name") {
    const TemporaryFolder folder;
    std::string text = kFreeField;
    const std::string second = R"({"name": "a b/c", "position": [6.864, 0, 0]}, )";
    text.insert(text.find("{\"name\": \"click\""), second);
    const std::string scene = folder.write("free.json", text);
    measured(scene, {"--ir", folder.path() / "ir.wav", "--frames", "1", "--output", "foa"});
    REQUIRE(names_in(folder.path()) ==
            std::vector<std::string>{"free.json", "ir-a_b_c.wav", "ir-click.wav"});
    REQUIRE(aula::sound_info(folder.path() / "ir-click.wav").channels == 4);
}

TEST_CASE("The options --position and --source-position set the positions of listener and source") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("free.json", kFreeField);
    const std::string out = folder.path() / "ir.wav";
    const auto delay = [&](const std::vector<std::string>& options) {
        std::vector<std::string> all{"--ir", out, "--frames", "1", "--output", "mono"};
        all.insert(all.end(), options.begin(), options.end());
        measured(scene, all);
        return loudest(aula::read_sound(out, 48000).samples);
    };
    REQUIRE(delay({"--position", "-3.432,0,0"}) == 960);
    REQUIRE(delay({"--source-position", "click=0,0,-6.864"}) == 960);
}

TEST_CASE("commands without sound do not need the sounds of a scene, those with sound do") {
    const TemporaryFolder folder;
    const std::string scene =
        folder.write("room.json", with(kSmallRoom, "\"noise\"", "\"none.wav\""));
    const std::string out = folder.path() / "out";
    for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
             {"info", scene},
             {scene, "--report=" + out + ".json", "--frames", "1", "--rays", "50"},
             {"report", scene, "--html", out + ".html", "--frames", "1", "--rays", "50"},
             {"map", scene, "--out", out, "--spacing", "4", "--frames", "1", "--rays", "50"}}) {
        const ProgramResult result = aula_with(arguments);
        INFO(result.err);
        CHECK(result.status == 0);
    }
    require_refused(folder, {"check", scene}, {"/sources/0/signal: no such file"});
    require_refused(folder, {scene, "--offline", out + ".wav"}, {"/sources/0/signal: no such"});
}
