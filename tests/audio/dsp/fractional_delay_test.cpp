#include "audio/dsp/fractional_delay.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

using namespace aula;

namespace {

/// The largest error in reading a tone, whose frequency is a share of the Nyquist frequency.
double error_at(const FractionalDelay& interpolator, double share) {
    const double step_rad = share * std::numbers::pi;
    double worst = 0;
    for (int start = 0; start < 8; ++start) {
        std::array<float, kInterpolationTaps> x;
        for (std::size_t k = 0; k < x.size(); ++k)
            x[k] = static_cast<float>(std::cos(step_rad * static_cast<double>(k) + 0.8 * start));
        for (int i = 0; i < 1000; ++i) {
            const double fraction = i / 1000.0;
            const double expected =
                std::cos(step_rad * (FractionalDelay::kBefore + fraction) + 0.8 * start);
            const double read{interpolator.read(x.data(), fraction)};
            worst = std::max(worst, std::abs(read - expected));
        }
    }
    return worst;
}

}  // namespace

TEST_CASE("Samples themselves are read exactly") {
    const FractionalDelay interpolator;
    std::array<float, kInterpolationTaps> x{};
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = std::sin(static_cast<float>(k * k));
    CHECK(interpolator.read(x.data(), 0) == x[FractionalDelay::kBefore]);
    const auto taps = interpolator.impulse(0);
    for (std::size_t k = 0; k < taps.size(); ++k)
        CHECK(taps[k] == (k == FractionalDelay::kBefore ? 1.0F : 0.0F));
}

TEST_CASE(
    "The interpolation error is below -90 dB up to 0.6 of the Nyquist frequency, -83 dB to 0.8") {
    const FractionalDelay interpolator;
    for (int percent = 0; percent <= 80; ++percent) {
        CAPTURE(percent);
        const double error_db = 20 * std::log10(error_at(interpolator, percent / 100.0));
        CHECK(error_db < (percent <= 60 ? -90 : -83));
    }
    // Companion: in the transition band the error is larger.
    CHECK(20 * std::log10(error_at(interpolator, 0.85)) > -60);
}

TEST_CASE("Reading equals the sum with the impulse response, reversed in time") {
    const FractionalDelay interpolator;
    std::array<float, kInterpolationTaps> x;
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = std::sin(static_cast<float>(k * k));
    for (const double fraction : {0.0, 0.1, 0.25, 0.333, 0.5, 0.875, 0.9999}) {
        // read() looks ahead by `fraction`, impulse() delays by it: the two are mirrored.
        const auto taps = interpolator.impulse(fraction);
        double sum = 0;
        for (std::size_t k = 0; k < taps.size(); ++k) sum += double{taps[k]} * double{x[k]};
        CAPTURE(fraction);
        CHECK(double{interpolator.read(x.data(), fraction)} == Approx(sum).margin(2e-6));
    }
}

TEST_CASE("A fraction and its complement have mirrored responses") {
    const FractionalDelay interpolator;
    for (const double fraction : {0.125, 0.25, 0.4375, 0.5}) {
        const auto taps = interpolator.impulse(fraction);
        const auto mirrored = interpolator.impulse(1 - fraction);
        CAPTURE(fraction);
        for (std::size_t k = 0; k < taps.size(); ++k)
            CHECK(taps[k] == Approx(mirrored[taps.size() - 1 - k]).margin(1e-7));  // rounding
    }
}
