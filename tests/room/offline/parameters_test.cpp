#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/room/offline/acoustic_parameters.h"
#include "apps/room/offline/measurement_text.h"
#include "aula/measurement.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace aula;

/// An exponential decay of the given reverberation time and energy, in all bands.
EnergyResponse decay(double time_s, double energy) {
    EnergyResponse response = EnergyResponse::silent(TimeBins(2.0));
    const double rate = 6 * std::log(10.0) / time_s;
    for (std::size_t i = 0; i < response.bins.count(); ++i)
        response.energy[i] =
            Bands::filled(static_cast<float>(energy * (std::exp(-rate * response.bins.begin_s(i)) -
                                                       std::exp(-rate * response.bins.end_s(i)))));
    return response;
}

const MeasuredValue& broadband(const PairParameters& p, AcousticParameter parameter) {
    return p.broadband[static_cast<std::size_t>(parameter)];
}

}  // namespace

TEST_CASE("single numbers are the means of their octaves, of L_J the level of the mean energy") {
    EnergyResponse response = decay(1, 0.01);
    // Band b has the energy 2^b.
    for (Bands& energy : response.energy)
        for (std::size_t b = 0; b < kBandCount; ++b) energy[b] *= static_cast<float>(1 << b);
    WindowedMean mean;
    mean.add(response);
    const PairParameters p = acoustic_parameters(mean, {});
    const auto octave = [&](AcousticParameter parameter, std::size_t band) {
        return *p.octave(parameter, band).value;
    };
    using enum AcousticParameter;
    CHECK(*broadband(p, g).value == Approx((octave(g, 3) + octave(g, 4)) / 2));
    CHECK(octave(g, 4) - octave(g, 3) == Approx(10 * std::log10(2.0)).margin(1e-5));
    CHECK(*broadband(p, t30).value == Approx(1).epsilon(0.01));
    CHECK(*broadband(p, jlf).value == Approx(octave(jlf, 2)));
    // 125 to 1000 Hz: the mean of 2, 4, 8 and 16 is 7.5.
    CHECK(*broadband(p, lj).value == Approx(octave(lj, 1) + 10 * std::log10(7.5 / 2)));
    CHECK_FALSE(broadband(p, g).standard_error);
    REQUIRE(p.sti.value);
    CHECK_FALSE(p.sti.standard_error);
}

TEST_CASE("an octave without a sufficient decay leaves its single numbers and STI empty") {
    EnergyResponse response = decay(1, 0.01);
    for (Bands& energy : response.energy) energy[3] = 0;
    WindowedMean mean;
    mean.add(response);
    const PairParameters p = acoustic_parameters(mean, {});
    for (std::size_t i = 0; i < kAcousticParameterCount; ++i) {
        CHECK_FALSE(p.octaves[i][3].value);
        if (i < static_cast<std::size_t>(AcousticParameter::iacc_early))
            CHECK(p.octaves[i][4].value);
        CHECK_FALSE(p.broadband[i].value);
    }
    CHECK_FALSE(p.sti.value);
}

TEST_CASE("the axis of the figure of eight is horizontal and perpendicular to the source") {
    const Pose receiver{.position = {1, 1, 1}, .yaw_rad = 0.3F};
    const Vec3 axis = lateral_axis(receiver, {4, 5, 3});
    CHECK(axis.x == Approx(-0.8));
    CHECK(axis.y == Approx(0.6));
    CHECK(axis.z == 0);
    // Below the source there is no such axis: it is the receiver's left.
    const Vec3 left = lateral_axis(receiver, {1, 1, 3});
    CHECK(left.x == Approx(-std::sin(0.3)));
    CHECK(left.y == Approx(std::cos(0.3)));
}

TEST_CASE("the level of speech is that on the axis of a source") {
    const Directivity talker = *Directivity::find("talker");
    const SpeechConditions speech{.speech_db = SpeechConditions::male_speech_db(60)};
    const Bands omnidirectional_db = with_power_of(speech, talker).speech_db;
    for (std::size_t b = 0; b < kBandCount; ++b)
        CHECK(omnidirectional_db[b] + talker.on_axis_db()[b] == Approx(speech.speech_db[b]));
    CHECK(omnidirectional_db[4] < speech.speech_db[4] - 1);
    CHECK(with_power_of(speech, {}) == speech);
    // Nothing goes to the front: the level is the mean over directions.
    std::vector<Bands> back(3 * 4, Bands{});
    back[4 + 2] = Bands::filled(1);
    CHECK(with_power_of(speech, Directivity::table(3, 4, back)) == speech);
    // In the open a talker has the same index in front as an omnidirectional source.
    Scene scene = test::free_field({0, 0, 0});
    scene.listener.pose.position = {1, 0, 0};
    scene.speech.noise_db = Bands::filled(50);
    const double expected = *measure(scene, {.frames = 1})->parameters[0].sti.value;
    scene.sources[0].directivity = talker;
    CHECK(*measure(scene, {.frames = 1})->parameters[0].sti.value == Approx(expected).margin(1e-4));
    scene.sources[0].yaw_rad = 3.14F;
    CHECK(*measure(scene, {.frames = 1})->parameters[0].sti.value < expected - 0.05);
}

TEST_CASE("noise lowers STI and nothing else, and every parameter has a standard error") {
    Scene scene = test::small_room();
    scene.simulation.rays = 100;
    MeasurementOptions options{
        .limits = {.level_db = 0.2, .c80_db = 0.4, .t30 = 0.04, .edt = 0.04}};
    const auto quiet = measure(scene, options);
    scene.speech.noise_db = Bands::filled(60);
    const auto noisy = measure(scene, options);
    const PairParameters& p = quiet->parameters[0];
    const PairParameters& n = noisy->parameters[0];
    CHECK(*p.sti.value > 0.5);
    CHECK(*n.sti.value < *p.sti.value - 0.1);
    CHECK(*p.sti.standard_error > 0);
    CHECK(*p.sti.standard_error < 0.02);
    for (std::size_t i = 0; i < static_cast<std::size_t>(AcousticParameter::iacc_early); ++i) {
        CHECK(p.broadband[i].value == n.broadband[i].value);
        REQUIRE(p.broadband[i].standard_error);
        CHECK(*p.broadband[i].standard_error > 0);
        // The mean of octaves has at most the error of its octaves.
        double largest = 0;
        for (std::size_t band = 1; band < 5; ++band)
            largest = std::max(largest, *p.octaves[i][band].standard_error);
        CHECK(*p.broadband[i].standard_error <= 1.5 * largest);
    }
    // A diffuse field has a third of the early reflected energy from the sides, a real one less or
    // more; with direct sound in the denominator the fraction is lower.
    const double jlf = *broadband(p, AcousticParameter::jlf).value;
    CHECK(jlf > 0.02);
    CHECK(jlf < 0.4);
    CHECK(*broadband(p, AcousticParameter::jlfc).value > jlf);
}

TEST_CASE("a report has octaves, single numbers, STI and the standard errors of all") {
    Scene scene = test::small_room();
    scene.simulation.rays = 100;
    const auto measured =
        measure(scene, {.limits = {.level_db = 0.2, .c80_db = 0.4, .t30 = 0.04, .edt = 0.04}});
    const auto report = nlohmann::json::parse(report_json(*measured));
    REQUIRE(report.at("sources").size() == 1);
    const auto& source = report["sources"][0];
    const PairParameters& p = measured->parameters[0];
    const auto check = [&](const nlohmann::json& values, const nlohmann::json& errors,
                           const auto& of) {
        for (std::size_t i = 0; i < kAcousticParameterCount; ++i) {
            const std::string name(acoustic_parameter_name(static_cast<AcousticParameter>(i)));
            INFO(name);
            const MeasuredValue& expected = of(i);
            REQUIRE(expected.value.has_value() == values.at(name).is_number());
            // Six digits.
            if (expected.value)
                CHECK(values[name].get<double>() == Approx(*expected.value).epsilon(1e-5));
            if (expected.value)
                CHECK(errors.at(name).get<double>() ==
                      Approx(*expected.standard_error).epsilon(1e-5));
        }
    };
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const std::string band = std::to_string(std::lround(kBandCentres_hz[b]));
        check(source.at("bands").at(band), source.at("standard_errors").at("bands").at(band),
              [&](std::size_t i) { return p.octaves[i][b]; });
    }
    check(source.at("broadband"), source.at("standard_errors").at("broadband"),
          [&](std::size_t i) { return p.broadband[i]; });
    CHECK(source.at("STI").get<double>() == Approx(*p.sti.value).epsilon(1e-5));
    CHECK(source.at("standard_errors").at("STI").get<double>() > 0);
    // The table has a row for each parameter and one for STI.
    const std::string table = report_table(*measured);
    for (const char* row : {"T20 s", "J_LF", "J_LFC", "L_J dB", "STI", "  class "})
        CHECK(table.find(row) != std::string::npos);
    const std::string given = report_json(*measure(scene, {.frames = 2}));
    CHECK(given.find("nan") == std::string::npos);
    CHECK(given.find("standard_errors") == std::string::npos);
}
