#include "audio/dsp/band_filter.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

using namespace aula;

namespace {

using Gains = std::array<float, 8>;

std::complex<double> response_at(const std::vector<float>& taps, double frequency_hz,
                                 double rate_hz) {
    std::complex<double> sum = 0;
    for (std::size_t n = 0; n < taps.size(); ++n) {
        sum += double{taps[n]} * std::polar(1.0, -2 * std::numbers::pi * frequency_hz *
                                                     static_cast<double>(n) / rate_hz);
    }
    return sum;
}

/// Gain of the filter for white noise in an octave band, dB.
double octave_level_db(const std::vector<float>& taps, std::size_t band, double rate_hz) {
    const double centre_hz = 62.5 * std::exp2(static_cast<double>(band));
    double energy = 0;
    constexpr int kPoints = 200;
    for (int i = 0; i < kPoints; ++i) {
        const double share = (i + 0.5) / kPoints;
        energy += std::norm(
            response_at(taps, centre_hz * std::numbers::sqrt2 * (0.5 + 0.5 * share), rate_hz));
    }
    return 10 * std::log10(energy / kPoints);
}

std::vector<float> designed(const Gains& gains, double rate_hz, std::size_t taps) {
    BandFilterDesigner designer(rate_hz, taps);
    std::vector<float> response(taps);
    designer.design(gains, response);
    return response;
}

}  // namespace

TEST_CASE("Equal gains give exactly a scaled unit impulse, zero gains give silence") {
    std::vector<float> expected(1024);
    CHECK(designed(Gains{}, 48000, 1024) == expected);
    expected[0] = 0.3F;
    Gains flat;
    flat.fill(0.3F);
    CHECK(designed(flat, 48000, 1024) == expected);
}

TEST_CASE("Each octave has the gain of its band") {
    // Alternating, falling and rising gains, up to 6 dB between neighbours.
    const Gains gains = GENERATE(Gains{1, 0.5F, 1, 0.5F, 1, 0.5F, 1, 0.5F},
                                 Gains{0.5F, 1, 0.5F, 1, 0.5F, 1, 0.5F, 1},
                                 Gains{1, 0.8F, 0.6F, 0.4F, 0.2F, 0.1F, 0.05F, 0.025F},
                                 Gains{0.1F, 0.1F, 0.2F, 0.4F, 0.4F, 0.2F, 0.1F, 0.1F});
    const std::vector<float> taps = designed(gains, 48000, 1024);
    for (std::size_t b = 0; b < 8; ++b) {
        const double error_db = octave_level_db(taps, b, 48000) - 20 * std::log10(double{gains[b]});
        CAPTURE(b, error_db);
        // The crossovers cause up to 0.3 dB. 1024 taps resolve 47 Hz: half of the 63 Hz octave, a
        // quarter of the 250 Hz octave.
        CHECK(std::abs(error_db) < (b < 2 ? 1.0 : b < 4 ? 0.55 : 0.3));
    }
}

TEST_CASE("The filter has minimum phase: its energy is concentrated at the start") {
    const Gains gains{1, 0.9F, 0.7F, 0.6F, 0.5F, 0.4F, 0.2F, 0.1F};
    const std::vector<float> taps = designed(gains, 48000, 1024);
    double total = 0;
    double first = 0;
    for (std::size_t n = 0; n < taps.size(); ++n) {
        total += double{taps[n]} * double{taps[n]};
        if (n < 64) first += double{taps[n]} * double{taps[n]};
    }
    CHECK(first / total > 0.9);
    // The phase of a minimum-phase response is zero at 0 Hz and at the Nyquist frequency.
    CHECK(response_at(taps, 0, 48000).real() == Approx(1).epsilon(0.01));
    CHECK(response_at(taps, 24000, 48000).real() == Approx(0.1).epsilon(0.01));
}

TEST_CASE("A silent band is at least 40 dB down and the filter stays finite") {
    const Gains gains{0, 0, 0, 1, 1, 0, 0, 0};
    const std::vector<float> taps = designed(gains, 48000, 1024);
    for (const float x : taps) REQUIRE(std::isfinite(x));
    CHECK(20 * std::log10(std::abs(response_at(taps, 4000, 48000))) < -40);
    CHECK(20 * std::log10(std::abs(response_at(taps, 1000, 48000))) == Approx(0).margin(0.5));
}
