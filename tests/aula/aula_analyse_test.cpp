#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "aula/audio/sound_file.h"
#include "tests/aula/aula_program.h"
#include "tests/support/shared_data.h"
#include "tests/support/small_scenes.h"

namespace {

using namespace aula::test;
using nlohmann::json;

/// A file of noise that decays by 60 dB in 0.5 s, above a floor.
std::string decay_file(const TemporaryFolder& folder, const std::string& name, double floor_db) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::vector<float> samples(48000);
    for (std::size_t i = 0; i < samples.size(); ++i)
        samples[i] = static_cast<float>(
            0.1 * normal(random) * std::pow(10, -3 * static_cast<double>(i) / 48000 / 0.5) +
            0.1 * normal(random) * std::pow(10, floor_db / 20));
    aula::WavWriter writer(folder.path() / name, 48000, 1, aula::SampleFormat::float32);
    writer.write(samples);
    writer.commit();
    return folder.path() / name;
}

/// analyse --out OUT.json of a file, the first response.
json analysed(const TemporaryFolder& folder, const std::string& file,
              std::vector<std::string> options = {}) {
    const std::string out = folder.path() / "analysis.json";
    std::vector<std::string> arguments{"analyse", file, "--out", out};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProgramResult result = aula_with(arguments);
    INFO(result.err);
    REQUIRE(result.status == 0);
    return json::parse(read_file(out))["responses"][0];
}

}  // namespace

TEST_CASE("analyse prints a table of each file and says what is missing and why") {
    const TemporaryFolder folder;
    const std::string good = decay_file(folder, "good.wav", -70);
    const std::string noisy = decay_file(folder, "noisy.wav", -40);
    const ProgramResult result = aula_with({"analyse", good, noisy});
    INFO(result.out << result.err);
    CHECK(result.status == 0);
    CHECK(result.out.find("good: 48000 Hz, 1.00 s, time zero 0.0000 s\n") == 0);
    CHECK(result.out.find("\n\nnoisy: 48000 Hz") != std::string::npos);
    CHECK(result.out.find("     STI") != std::string::npos);
    CHECK(result.err.find("aula: warning: " + noisy + ": octaves of ") != std::string::npos);
    CHECK(result.err.find("no T30, the decay range is ") != std::string::npos);
    CHECK(result.err.find("good.wav") == std::string::npos);
    CHECK(aula_with({"analyse", noisy, "--quiet"}).err.empty());
}

TEST_CASE("analyse writes JSON and CSV, with third octaves") {
    const TemporaryFolder folder;
    const std::string file = decay_file(folder, "a.wav", -70);
    const json a = analysed(folder, file, {"--third-octaves"});
    CHECK(a["bands"]["1000"]["T30"].get<double>() == Approx(0.5).epsilon(0.15));
    CHECK(a["third_octaves"]["16000"]["T30"].get<double>() == Approx(0.5).epsilon(0.1));
    CHECK(a["third_octaves"].size() == 26);
    CHECK_FALSE(analysed(folder, file).contains("third_octaves"));

    // Levels at the microphone lower STI.
    const json noisy = analysed(folder, file, {"--speech-level", "60", "--noise-level", "50"});
    CHECK(noisy["STI"].get<double>() < a["STI"].get<double>() - 0.1);

    const std::string csv = folder.path() / "a.csv";
    REQUIRE(aula_with({"analyse", file, "--out", csv}).status == 0);
    const std::string text = read_file(csv);
    CHECK(text.find("response,bands,parameter,unit,63,125,250,500,1000,2000,4000,8000,mean\n") ==
          0);
    CHECK(text.find("\na,octave,T30,s,") != std::string::npos);
}

TEST_CASE("analyse refuses what is no response with one line and status 2") {
    const TemporaryFolder folder;
    const std::string file = decay_file(folder, "a.wav", -70);
    aula::WavWriter writer(folder.path() / "silent.wav", 48000, 2, aula::SampleFormat::float32);
    writer.write(std::vector<float>(9600));
    writer.commit();
    const std::string silent = folder.path() / "silent.wav";
    const std::string text = folder.write("text.wav", "no sound");
    std::filesystem::create_directory(folder.path() / "b");
    const std::string same = decay_file(folder, "b/a.wav", -70);
    const std::vector<Refused> all = {
        {{"analyse"}, {"aula analyse FILE.wav"}},
        {{"analyse", silent}, {"silent.wav", "is silent"}},
        {{"analyse", text}, {"text.wav", "unknown format"}},
        {{"analyse", folder.path() / "none.wav"}, {"none.wav"}},
        {{"analyse", file, "--out", folder.path() / "a.txt"}, {"--out", "FILE.csv or FILE.json"}},
        {{"analyse", file, "--out", folder.path() / "none/a.csv"}, {"none/a.csv"}},
        {{"analyse", file, same, "--out", folder.path() / "a.csv"}, {"--out", "have the name a"}},
        {{"analyse", file, "--rays", "10"}, {"--rays", "aula analyse"}},
        {{"analyse", file, "--ir", "a.wav"}, {"--ir", "aula analyse"}},
        {{"analyse", file, "--noise-level", "30"}, {"--noise-level", "--speech-level"}},
        {{"info", file, "--third-octaves"}, {"--third-octaves", "--report", "aula analyse"}},
    };
    for (const Refused& bad : all) require_refused(folder, bad.arguments, bad.parts);
}

TEST_CASE("the analysis of --ir has the parameters of --report") {
    const TemporaryFolder folder;
    const std::string scene = std::string(AULA_SOURCE_DIR) + "/scenes/shoebox.json";
    const std::string ir = folder.path() / "ir.wav";
    const std::string report = folder.path() / "report.json";
    const ProgramResult measured = aula_with({scene, "--ir", ir, "--report=" + report, "--output",
                                              "mono", "--frames", "8", "--rays", "300"});
    INFO(measured.err);
    REQUIRE(measured.status == 0);
    const json expected = json::parse(read_file(report))["sources"][0];
    // Speech of 60 dB at 1 m has the level 60 dB - 20 dB + G at the receiver.
    const double level_db = 40 + expected["broadband"]["G"].get<double>();
    const json found = analysed(folder, ir, {"--speech-level", std::to_string(level_db)});
    // The impulse response is one realisation of noise with this energy: T20 and T30 have standard
    // deviations of 0.6 to 1.2 / sqrt(B T), 3 % at 1 kHz and 1 s.
    for (const char* const octave : {"1000", "2000", "4000"}) {
        INFO(octave);
        const json& a = found["bands"][octave];
        const json& b = expected["bands"][octave];
        const auto value = [](const json& of, const char* name) { return of[name].get<double>(); };
        CHECK(value(a, "T30") == Approx(value(b, "T30")).epsilon(0.08));
        CHECK(value(a, "T20") == Approx(value(b, "T20")).epsilon(0.12));
        CHECK(value(a, "C80") == Approx(value(b, "C80")).margin(1));
        CHECK(value(a, "C50") == Approx(value(b, "C50")).margin(1));
        CHECK(value(a, "D50") == Approx(value(b, "D50")).margin(0.06));
        CHECK(value(a, "Ts") == Approx(value(b, "Ts")).margin(0.01));
    }
    CHECK(found["STI"].get<double>() == Approx(expected["STI"].get<double>()).margin(0.03));
}

TEST_CASE("measured responses of halls have the decay times of their measurement") {
    // T20 at 1 kHz as evaluated independently (shared/data/SOURCES.md).
    const std::vector<std::pair<std::string, double>> halls = {
        {"openair_Arthur_Sykes_Rymer_Auditorium.wav", 0.370},
        {"openair_Jack_Lyons_Hall_University_of_York.wav", 1.79},
        {"openair_St_Margarets_Church.wav", 1.21}};
    for (const auto& [name, t20_s] : halls) {
        const std::filesystem::path file = shared_data("measured_rirs/" + name);
        if (file.empty()) {
            WARN("skipped: the measured responses are absent");
            return;
        }
        const TemporaryFolder folder;
        INFO(name);
        CHECK(analysed(folder, file)["bands"]["1000"]["T20"].get<double>() ==
              Approx(t20_s).epsilon(0.01));
    }
}
