#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "aula/measurement.h"
#include "engine/scene/air.h"
#include "tests/support/test_scenes.h"

namespace air_absorption_test {

namespace {

using namespace aula;

constexpr double kRate_hz = 48000;

/// The level of a response at a frequency, dB.
double level_db(const std::vector<float>& samples, double frequency_hz) {
    std::complex<double> sum = 0;
    for (std::size_t n = 0; n < samples.size(); ++n) {
        if (samples[n] == 0) continue;
        sum += double{samples[n]} * std::polar(1.0, -2 * std::numbers::pi * frequency_hz *
                                                        static_cast<double>(n) / kRate_hz);
    }
    return 20 * std::log10(std::abs(sum));
}

/// The largest error of the direct sound at a distance, dB, from the loss in `expected` air.
double worst_error_db(const Medium& medium, const Medium& expected, float distance_m) {
    Scene scene = test::free_field({distance_m, 0, 0});
    scene.medium = medium;
    const auto measurement = measure(scene, {.frames = 1, .parameters = false});
    REQUIRE(measurement);
    const ImpulseResponses responses(*measurement,
                                     {.sample_rate_hz = kRate_hz, .output = OutputFormat::mono});
    const std::vector<float> samples = responses.response(0)[0];
    double worst = 0;
    // Third octaves from 50 Hz to 20 kHz.
    for (int k = -13; k <= 13; ++k) {
        const double frequency_hz = 1000 * std::pow(10.0, 0.1 * k);
        const double wanted_db = -20 * std::log10(double{distance_m}) -
                                 10 * std::log10(std::numbers::e) * double{distance_m} *
                                     air_attenuation_per_m(expected, frequency_hz);
        worst = std::max(worst, std::abs(level_db(samples, frequency_hz) - wanted_db));
    }
    return worst;
}

}  // namespace

TEST_CASE("Direct sound has the loss of ISO 9613-1 from 50 Hz to 20 kHz within half a decibel") {
    for (const float temperature_c : {-10.0F, 0.0F, 20.0F, 40.0F}) {
        for (const float humidity_percent : {20.0F, 50.0F, 90.0F}) {
            Medium medium;
            medium.temperature_c = temperature_c;
            medium.humidity_percent = humidity_percent;
            for (const float distance_m : {1.0F, 10.0F, 40.0F, 100.0F}) {
                const double error_db = worst_error_db(medium, medium, distance_m);
                CAPTURE(temperature_c, humidity_percent, distance_m, error_db);
                CHECK(error_db < 0.5);
            }
        }
    }
    // Companion: air of another humidity is detected.
    Medium dry;
    dry.humidity_percent = 40;
    CHECK(worst_error_db(dry, Medium{}, 40) > 0.5);
}

}  // namespace air_absorption_test
