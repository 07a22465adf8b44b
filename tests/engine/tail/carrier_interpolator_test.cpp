#include "engine/tail/carrier_interpolator.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/response/third_octave_model.h"
#include "engine/tail/noise_carriers.h"

namespace carrier_interpolator_test {

using namespace aula;

namespace {

constexpr std::size_t kDecimation = 8;
constexpr double kRate_hz = 44100;  // the lowest rate of the low carriers, 5512 Hz

/// The error of an interpolated tone of amplitude 1, rms re that of the tone, dB.
double error_db(double frequency_hz) {
    constexpr std::size_t kCount = 1000;
    const CarrierInterpolator interpolator(kDecimation);
    const double turn = 2 * std::numbers::pi * frequency_hz / kRate_hz;
    std::vector<float> low(kCount + CarrierInterpolator::kTaps - 1);
    for (std::size_t n = 0; n < low.size(); ++n) {
        const double at =
            static_cast<double>(n) - static_cast<double>(CarrierInterpolator::kBefore);
        low[n] = static_cast<float>(std::sin(turn * double{kDecimation} * at));
    }
    std::vector<float> out(kCount * kDecimation);
    interpolator.process(low.data(), kCount, out.data());
    double error = 0;
    for (std::size_t n = 0; n < out.size(); ++n) {
        const double difference = double{out[n]} - std::sin(turn * static_cast<double>(n));
        error += difference * difference;
    }
    return 10 * std::log10(2 * error / static_cast<double>(out.size()));
}

/// The level of the highest low carrier, which ends in a crossover.
double carrier_db(double frequency_hz) {
    const double begin_hz = ThirdOctaveModel::centre_hz(NoiseCarriers::kHigh - 1);
    const double position = std::max(10 * std::log10(frequency_hz / begin_hz), 0.0);
    return 20 * std::log10(std::cos(std::numbers::pi / 2 * position));
}

}  // namespace

TEST_CASE("interpolation of the low carriers has errors and images below -74 dB") {
    const double end_hz = ThirdOctaveModel::centre_hz(NoiseCarriers::kHigh);
    for (double hz = 40; hz < end_hz; hz *= 1.02) {
        CAPTURE(hz);
        CHECK(error_db(hz) + carrier_db(hz) < -74);
    }
    // Companion: a tone beyond the crossover.
    CHECK(error_db(2300) > -60);
}

}  // namespace carrier_interpolator_test
