// Parameters in third octaves against transport with interpolated surfaces and exact air.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/room/offline/measurement_text.h"
#include "aula/engine/room_acoustics.h"
#include "aula/measurement.h"
#include "engine/response/third_octave_model.h"
#include "engine/scene/air.h"
#include "tests/support/test_scenes.h"

using namespace aula;

namespace {

constexpr std::array<double, kBandCount> kAbsorption{0.1, 0.12, 0.2, 0.3, 0.2, 0.15, 0.1, 0.1};

/// The absorption linear in log f between the centres of octaves.
double absorption_at(std::size_t third) {
    const double octave = std::clamp((static_cast<double>(third) - 1) / 3, 0.0, 7.0);
    const auto below = std::min(static_cast<std::size_t>(octave), kBandCount - 2);
    const double share = octave - static_cast<double>(below);
    return (1 - share) * kAbsorption[below] + share * kAbsorption[below + 1];
}

/// The small room with the absorption `of` a band on all surfaces.
template <typename Of>
Scene room(const Of& of) {
    Scene scene = test::small_room();
    for (std::size_t b = 0; b < kBandCount; ++b)
        scene.materials[0].absorption[b] = static_cast<float>(of(b));
    scene.materials[0].scattering = Bands::filled(1);
    scene.medium = Medium{};
    scene.simulation.ir_length_s = 1;
    return scene;
}

}  // namespace

TEST_CASE("Parameters in third octaves are those of transport with interpolated surfaces") {
    MeasurementOptions options{.frames = 40, .third_octaves = true};
    const auto measured = measure(room([](std::size_t b) { return kAbsorption[b]; }), options);
    REQUIRE(measured);
    const auto& thirds = measured->parameters[0].third_octaves;
    REQUIRE(thirds.size() == kThirdOctaveParameterCount);
    // Eight third octaves at a time in place of octaves, without air, which is added afterwards.
    for (const std::size_t first : {2U, 10U, 18U}) {
        Scene scene = room([&](std::size_t b) { return absorption_at(first + b); });
        scene.medium.air_absorption = false;
        const auto transport = measure(scene, {.frames = 40, .parameters = false});
        REQUIRE(transport);
        EnergyResponse exact = transport->response(0);
        const auto add_air = [&](double length_m, Bands& energy) {
            for (std::size_t b = 0; b < kBandCount; ++b) {
                const double m =
                    air_attenuation_per_m(measured->medium, ThirdOctaveModel::centre_hz(first + b));
                energy[b] *= static_cast<float>(std::exp(-m * length_m));
            }
        };
        for (std::size_t i = 0; i < exact.bins.count(); ++i)
            add_air(0.5 * (exact.bins.begin_s(i) + exact.bins.end_s(i)) *
                        double{exact.speed_of_sound_m_s},
                    exact.energy[i]);
        for (SoundPath& path : exact.paths) add_air(double{path.length_m}, path.energy);
        const RoomParameters wanted = room_parameters(exact);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const std::size_t t = first + b;
            CAPTURE(third_octave_name(t));
            const auto value = [&](AcousticParameter p) {
                return thirds[static_cast<std::size_t>(p)][t].value.value_or(0);
            };
            // Of the interpolation in dB; the noise of both is below 1 %.
            CHECK(value(AcousticParameter::t20) ==
                  Approx(wanted[b].t20_s.value_or(1)).epsilon(0.05));
            CHECK(value(AcousticParameter::edt) ==
                  Approx(wanted[b].edt_s.value_or(1)).epsilon(0.05));
            CHECK(value(AcousticParameter::g) == Approx(wanted[b].g_db.value_or(1)).margin(0.2));
            // Companion: the octave that contains it decays at another rate.
            if (t == 25)
                CHECK(measured->parameters[0].octave(AcousticParameter::t20, 7).value.value_or(0) >
                      1.1 * wanted[b].t20_s.value_or(1));
        }
    }
}

TEST_CASE("Reports have third octaves, with those of the centres near octaves") {
    const auto scene = room([](std::size_t b) { return kAbsorption[b]; });
    const auto measured = measure(scene, {.third_octaves = true});
    REQUIRE(measured);
    const auto json = nlohmann::json::parse(report_json(*measured))["sources"][0];
    const auto& thirds = json["third_octaves"];
    CHECK(thirds.size() == kThirdOctaveCount);
    CHECK(json["standard_errors"]["third_octaves"]["16000"]["G"].is_number());
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const std::string name = band_name(b);
        for (const auto& [parameter, value] : thirds[name].items()) {
            CAPTURE(name, parameter);
            // The mean over a third octave differs from its centre by less than this.
            CHECK(value.template get<double>() ==
                  Approx(json["bands"][name][parameter].template get<double>())
                      .epsilon(0.01)
                      .margin(0.05));
        }
    }
    const std::string table = report_table(*measured);
    CHECK(table.find("\n   12500") != std::string::npos);
    const auto octaves = measure(scene, {.frames = 1});
    REQUIRE(octaves);
    CHECK(report_table(*octaves).find("12500") == std::string::npos);
    CHECK(report_json(*octaves).find("third_octaves") == std::string::npos);
}
