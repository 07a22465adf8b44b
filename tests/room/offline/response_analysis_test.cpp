#include "apps/room/offline/response_analysis.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "apps/room/offline/analysis_text.h"
#include "apps/room/offline/measured_values.h"
#include "apps/room/offline/measurement_text.h"
#include "aula/audio/sound_file.h"
#include "aula/engine/third_octaves.h"
#include "aula/exception.h"
#include "tests/support/program.h"

namespace response_analysis_test {

namespace {

using namespace aula;
using test::TemporaryFolder;

/// Noise that decays by 60 dB in 0.5 s from 10 ms on, above a floor.
std::vector<float> noise(double rate_hz, double floor_db, double length_s = 1) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<float> samples(static_cast<std::size_t>(length_s * rate_hz));
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double t = static_cast<double>(i) / rate_hz - 0.01;
        const double decay = t < 0 ? 0 : 0.1 * std::pow(10, -3 * t / 0.5);
        samples[i] = static_cast<float>(normal(random) * decay +
                                        normal(random) * 0.1 * std::pow(10, floor_db / 20));
    }
    return samples;
}

std::string joined(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + '\n';
    return text;
}

std::string error_of(const std::vector<float>& samples) {
    try {
        analyse_response("x", samples, 48000, {});
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

std::string csv_error(const TemporaryFolder& folder, const std::string& text) {
    std::vector<std::string> warnings;
    try {
        read_measured(folder.write("a.csv", text), warnings);
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

}  // namespace

TEST_CASE("a response has its octaves, single numbers and STI at any sample rate") {
    for (const double rate_hz : {22050.0, 44100.0, 96000.0}) {
        INFO(rate_hz << " Hz");
        const ResponseAnalysis a = analyse_response("x", noise(rate_hz, -80), rate_hz, {});
        CHECK(a.zero_s == Approx(0.01).margin(0.001));
        // Of one realisation: four standard deviations of 0.6 / sqrt(B T).
        for (std::size_t b = 2; b < 7; ++b)
            CHECK(a.parameters.octave(AcousticParameter::t30, b).value.value() ==
                  Approx(0.5).epsilon(2.4 / std::sqrt(0.7 * double{kBandCentres_hz[b]} * 0.5)));
        const bool has_8_khz = rate_hz > 2 * 11220;
        CHECK(a.parameters.octave(AcousticParameter::t30, 7).value.has_value() == has_8_khz);
        CHECK((joined(a.warnings).find("8000 Hz: above the range of the sample rate") !=
               std::string::npos) == !has_8_khz);
        CHECK(a.parameters.sti.value.has_value() == has_8_khz);
        CHECK(a.third_octaves.empty());
        CHECK_FALSE(a.parameters.octave(AcousticParameter::g, 4).value);
    }
}

TEST_CASE("STI of a response counts the levels that are given") {
    const std::vector<float> samples = noise(48000, -80);
    const double without = analyse_response("x", samples, 48000, {}).parameters.sti.value.value();
    // The closed form of a decay of 0.5 s is 0.736; of one realisation.
    CHECK(without == Approx(0.736).margin(0.02));
    const ReceivedLevels levels{.speech_db = SpeechConditions::male_speech_db(60),
                                .noise_db = Bands::filled(50)};
    CHECK(analyse_response("x", samples, 48000, {.speech = levels}).parameters.sti.value.value() <
          without - 0.1);
}

TEST_CASE("what a response lacks is said") {
    const ResponseAnalysis a =
        analyse_response("hall", noise(48000, -40), 48000, {.third_octaves = true});
    const std::string lines = joined(a.warnings);
    INFO(lines);
    CHECK(lines.find("hall: octaves of 63") == 0);
    CHECK(lines.find("no T30, the decay range is") != std::string::npos);
    CHECK(lines.find("expected 45 dB") != std::string::npos);
    CHECK(lines.find("hall: third octaves of ") != std::string::npos);
    CHECK_FALSE(a.parameters.octave(AcousticParameter::t30, 5).value);
    CHECK(a.parameters.octave(AcousticParameter::t20, 5).value);
    CHECK(a.range_db[5].value() == Approx(40).margin(1.5));
    REQUIRE(a.third_octaves.size() == kThirdOctaveCount);
    CHECK(a.third_octaves[16].parameters.t20_s);

    // A short room: the third octave of 50 Hz has a band of 11.6 Hz.
    std::vector<float> shorter = noise(48000, -90);
    for (std::size_t i = 480; i < shorter.size(); ++i)
        shorter[i] *= static_cast<float>(std::exp(-static_cast<double>(i - 480) / 48000 * 40));
    const ResponseAnalysis b = analyse_response("x", shorter, 48000, {.third_octaves = true});
    CHECK(joined(b.warnings).find("band width times T is below 4") != std::string::npos);
    CHECK_FALSE(b.third_octaves[0].parameters.t30_s);

    std::vector<float> clipped = noise(48000, -80);
    for (std::size_t i = 480; i < 490; ++i) clipped[i] = 0.999F;
    CHECK(joined(analyse_response("x", clipped, 48000, {}).warnings).find("is clipped") !=
          std::string::npos);
    // A quiet response of few bits has runs of its largest value.
    std::vector<float> quiet = clipped;
    for (float& sample : quiet) sample *= 1e-3F;
    for (const std::vector<float>& samples : {noise(48000, -80), quiet})
        CHECK(joined(analyse_response("x", samples, 48000, {}).warnings).find("clipped") ==
              std::string::npos);

    // The octave of 8 kHz is above the range.
    const ResponseAnalysis no_speech = analyse_response("x", noise(22000, -80), 22000, {});
    CHECK_FALSE(no_speech.parameters.sti.value);
    CHECK_FALSE(no_speech.transfers);
    CHECK(joined(no_speech.warnings).find("x: no STI, which needs C50 of the octaves of 8000 Hz") !=
          std::string::npos);
}

TEST_CASE("a click with faint noise has no decay times, and no range below 0 dB") {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<float> click(48000);
    for (float& sample : click) sample = static_cast<float>(1e-9 * normal(random));
    click[0] = 1;
    const ResponseAnalysis a = analyse_response("x", click, 48000, {.third_octaves = true});
    for (std::size_t b = 0; b < kBandCount; ++b) {
        INFO(band_name(b));
        CHECK_FALSE(a.parameters.octave(AcousticParameter::t20, b).value);
        CHECK_FALSE(a.parameters.octave(AcousticParameter::t30, b).value);
    }
    // Noise, whose decay is one by chance.
    for (int seed = 0; seed < 40; ++seed) {
        random.seed(static_cast<unsigned>(seed));
        std::vector<float> samples(12000);
        for (std::size_t i = 0; i < samples.size(); ++i)
            samples[i] = static_cast<float>(normal(random) * (i < 3000 ? 0.1 : 0.05));
        const ResponseAnalysis b = analyse_response("x", samples, 48000, {});
        for (const auto& range_db : b.range_db) CHECK(range_db.value_or(0) >= 0);
    }
}

TEST_CASE("silence after a response is no noise floor") {
    std::vector<float> samples = noise(48000, -60);
    const ResponseAnalysis alone = analyse_response("x", samples, 48000, {});
    samples.resize(4 * samples.size());
    const ResponseAnalysis padded = analyse_response("x", samples, 48000, {});
    CHECK(padded.parameters.octave(AcousticParameter::t30, 5).value ==
          alone.parameters.octave(AcousticParameter::t30, 5).value);
}

TEST_CASE("an offset of the samples is no sound") {
    std::vector<float> samples = noise(48000, -60);
    const ResponseAnalysis without = analyse_response("x", samples, 48000, {});
    for (float& sample : samples) sample += 0.01F;
    const ResponseAnalysis with = analyse_response("x", samples, 48000, {});
    // Companion: as a step at the start, the offset had the energy of the decay at 63 Hz.
    for (std::size_t b = 0; b < kBandCount; ++b)
        CHECK(with.range_db[b].value() == Approx(without.range_db[b].value()).margin(0.1));
    // Of 10 ms before the sound, a tenth of the largest sample or more is no arrival.
    for (float& sample : samples) sample += 0.1F;
    const ResponseAnalysis large = analyse_response("x", samples, 48000, {});
    CHECK(large.zero_s == without.zero_s);
    CHECK(large.parameters.octave(AcousticParameter::c50, 4).value.value() ==
          Approx(without.parameters.octave(AcousticParameter::c50, 4).value.value()).margin(0.1));
}

TEST_CASE("a response that is silent or too short is refused") {
    CHECK(error_of(std::vector<float>(4800)).find("is silent") != std::string::npos);
    CHECK(error_of({}).find("is silent") != std::string::npos);
    CHECK(error_of(std::vector<float>(480, 0.5F)).find("lasts 10.0 ms") != std::string::npos);
    // A click has no decay in any octave, and is no error.
    std::vector<float> click(9600, 1e-9F);
    click[100] = 1;
    CHECK(error_of(click).empty());
}

TEST_CASE("every channel of a file is a response, silent ones are empty") {
    const TemporaryFolder folder;
    const std::vector<float> samples = noise(48000, -80);
    std::vector<float> interleaved;
    for (const float x : samples) interleaved.insert(interleaved.end(), {x, 0, x / 2});
    const auto file = folder.path() / "hall.wav";
    WavWriter writer(file, 48000, 3, SampleFormat::float32);
    writer.write(interleaved);
    writer.commit();
    const std::vector<std::optional<ResponseAnalysis>> all = analyse_file(file, {});
    REQUIRE(all.size() == 3);
    CHECK(all[0]->name == "hall channel 1");
    CHECK_FALSE(all[1]);
    CHECK(all[2]->name == "hall channel 3");
    CHECK(joined(all[0]->warnings).find("hall.wav channel 2: is silent") != std::string::npos);
    CHECK(all[2]->parameters.octave(AcousticParameter::c80, 4).value.value() ==
          Approx(all[0]->parameters.octave(AcousticParameter::c80, 4).value.value()));

    std::vector<std::string> warnings;
    const auto read = read_measured(file, warnings);
    REQUIRE(read.size() == 2);
    // Its STI needs the levels at the receiver.
    CHECK_FALSE(read[0].parameters.sti.value);
    CHECK(speech_transmission_index(read[0].transfers.value(), std::nullopt) ==
          all[0]->parameters.sti.value);
}

TEST_CASE("an analysis is written as a table, JSON and CSV, and the CSV is read back") {
    const TemporaryFolder folder;
    const ResponseAnalysis a =
        analyse_response("a, \"hall\"", noise(48000, -70), 48000, {.third_octaves = true});
    const std::string table = analysis_table(a);
    CHECK(table.find("T30 s") != std::string::npos);
    CHECK(table.find("range dB") != std::string::npos);
    CHECK(table.find("class ") != std::string::npos);
    CHECK(table.find("\n   16000") != std::string::npos);

    const auto json = nlohmann::json::parse(analysis_json(std::vector{a}))["responses"][0];
    CHECK(json["name"] == "a, \"hall\"");
    CHECK(json["bands"]["1000"]["T30"].get<double>() ==
          Approx(a.parameters.octave(AcousticParameter::t30, 4).value.value()).epsilon(1e-5));
    CHECK(json["bands"]["1000"]["G"].is_null());
    CHECK(json["third_octaves"]["50"].contains("range_db"));
    CHECK(json["STI_class"].is_string());

    for (const bool third_octaves : {false, true}) {
        ResponseAnalysis one = a;
        if (!third_octaves) one.third_octaves.clear();
        std::vector<std::string> warnings;
        const auto read =
            read_measured(folder.write("m.csv", measured_csv(std::vector{one})), warnings);
        REQUIRE(read.size() == 1);
        CHECK(read[0].name == "a, \"hall\"");
        for (std::size_t p = 0; p < kAnalysedParameterCount; ++p) {
            const auto parameter = static_cast<AcousticParameter>(p);
            for (std::size_t b = 0; b < kBandCount; ++b) {
                const auto& value = a.parameters.octave(parameter, b).value;
                REQUIRE(read[0].parameters.octave(parameter, b).value.has_value() ==
                        value.has_value());
                if (value)
                    CHECK(*read[0].parameters.octave(parameter, b).value ==
                          Approx(*value).epsilon(1e-5));
            }
        }
        CHECK(read[0].parameters.sti.value.value() ==
              Approx(a.parameters.sti.value.value()).epsilon(1e-5));
    }
}

TEST_CASE("measured values need only parameters and octaves") {
    const TemporaryFolder folder;
    std::vector<std::string> warnings;
    const auto read = read_measured(
        folder.write("m.csv",
                     "\xEF\xBB\xBFparameter, 500, 1000\r\nT30, 1.5, 1.7\r\n\r\nG, -3.5,-\r\n"),
        warnings);
    REQUIRE(read.size() == 1);
    CHECK(read[0].name.empty());
    CHECK(read[0].parameters.octave(AcousticParameter::t30, 4).value == 1.7);
    CHECK(read[0].parameters.broadband[1].value == 1.6);  // of 500 and 1000 Hz
    CHECK(read[0].parameters.octave(AcousticParameter::g, 3).value == -3.5);
    CHECK_FALSE(read[0].parameters.octave(AcousticParameter::g, 4).value);
}

TEST_CASE("measured values may have semicolons and decimal commas") {
    const TemporaryFolder folder;
    std::vector<std::string> warnings;
    const auto read = read_measured(
        folder.write("m.csv", "response;parameter;500;1000\r\nfront, left;T30;1,5;1.7\r\n"),
        warnings);
    REQUIRE(read.size() == 1);
    CHECK(read[0].name == "front, left");
    CHECK(read[0].parameters.octave(AcousticParameter::t30, 3).value == 1.5);
    CHECK(read[0].parameters.octave(AcousticParameter::t30, 4).value == 1.7);
}

TEST_CASE("an error of measured values names the line and what is expected") {
    const TemporaryFolder folder;
    const auto has = [&](const std::string& text, std::vector<std::string> parts) {
        const std::string error = csv_error(folder, text);
        INFO(text << " -> " << error);
        for (const std::string& part : parts) CHECK(error.find(part) != std::string::npos);
        CHECK(error.find("expected") != std::string::npos);
    };
    has("", {"a.csv: is empty"});
    has("parameter,1000\n", {"no values"});
    has("quantity,1000\nT30,1\n", {"line 1", "\"parameter\""});
    has("parameter,1 kHz\nT30,1\n", {"line 1", "octave"});
    has("parameter,1000,1000\nT30,1,1\n", {"line 1", "two columns"});
    has("parameter,1000\nRT60,1\n", {"line 2", "RT60", "T30"});
    has("parameter,1000\nT30,one\n", {"line 2", "one"});
    has("parameter,1000\nT30,nan\n", {"line 2", "nan"});
    has("parameter,1000\nT30,-1\n", {"line 2", "seconds"});
    has("parameter,1000\nD50,55\n", {"line 2", "0 to 1"});
    has("parameter,1000\nT30,1,2\n", {"line 2", "cells"});
    has("parameter,1000\nT30,1\nT30,1\n", {"line 3", "has T30 again"});
    has("response,parameter,mean\na,STI,0.5\nb,STI,0.5\na,STI,0.5\n",
        {"line 4", "STI again of \"a\""});
    has("parameter,125,250\nSTI,0.5,0.6\n", {"line 2", "STI", "\"mean\""});
    std::vector<std::string> warnings;
    CHECK_THROWS_WITH(read_measured(folder.path() / "none.csv", warnings),
                      Catch::Contains("none.csv: no such file"));
    CHECK_THROWS_WITH(read_measured(folder.write("a.txt", "T30 is 1 s"), warnings),
                      Catch::Contains("FLAC") && Catch::Contains(".csv"));
}

}  // namespace response_analysis_test
