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
    designer.design(gains, 0, response);
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
        CHECK(std::abs(error_db) < 0.1);
    }
}

TEST_CASE("Each octave has the level of any material within half a decibel") {
    // Reflections from walls of independent absorption in each octave, from a bass trap and from a
    // resonant panel.
    std::vector<Gains> materials{{0.2F, 0.316F, 0.632F, 0.949F, 0.949F, 0.949F, 0.949F, 0.949F},
                                 {0.949F, 0.316F, 0.837F, 0.949F, 0.975F, 0.975F, 0.975F, 0.975F}};
    std::mt19937 random(1);
    std::uniform_real_distribution<float> absorption(0, 0.97F);
    for (int i = 0; i < 40; ++i) {
        Gains& gains = materials.emplace_back();
        for (float& gain : gains) gain = std::sqrt(1 - absorption(random));
    }
    const double rate_hz = GENERATE(48000.0, 44100.0);
    const auto samples = [&](double at_48_khz) {
        return fast_fft_size(static_cast<std::size_t>(at_48_khz * rate_hz / 48000));
    };
    BandFilterDesigner short_filters(rate_hz, samples(256));
    BandFilterDesigner long_filters(rate_hz, samples(1024));
    double worst_db = 0;
    double worst_short_db = 0;
    std::size_t resolved = 0;
    for (const Gains& gains : materials) {
        const auto worst_of = [&](BandFilterDesigner& designer, float& left_db) {
            std::vector<float> taps(designer.taps());
            left_db = designer.design(gains, 0, taps);
            double worst = 0;
            for (std::size_t b = 0; b < 8; ++b)
                worst = std::max(worst, std::abs(octave_level_db(taps, b, rate_hz) -
                                                 20 * std::log10(double{gains[b]})));
            return worst;
        };
        float left_db = 0;
        const double short_db = worst_of(short_filters, left_db);
        worst_short_db = std::max(worst_short_db, short_db);
        // As the renderer chooses the length.
        if (left_db <= 0.25F) {
            ++resolved;
            worst_db = std::max(worst_db, short_db);
        } else {
            worst_db = std::max(worst_db, worst_of(long_filters, left_db));
        }
    }
    CAPTURE(worst_db, worst_short_db, resolved);
    CHECK(worst_db < 0.5);
    CHECK(resolved > materials.size() / 2);
    // Companion: short filters do not suffice for all.
    CHECK(worst_short_db > 1);
}

TEST_CASE("Air attenuates each frequency by its own coefficient") {
    // In proportion to the square of the frequency, -30 dB at 16 kHz.
    const double scale = 30 / (10 * std::log10(std::numbers::e)) / (100 * 16000.0 * 16000.0);
    const AirAttenuation air = [scale](double f) { return scale * f * f; };
    constexpr double kLength_m = 100;
    Gains gains;
    for (std::size_t b = 0; b < 8; ++b) {
        const double centre_hz = 1000 * std::pow(10.0, 0.3 * (static_cast<double>(b) - 4));
        gains[b] = static_cast<float>(0.5 * std::exp(-0.5 * kLength_m * air(centre_hz)));
    }
    const auto worst_db = [&](const AirAttenuation& designed_for) {
        BandFilterDesigner designer(48000, 256, designed_for);
        std::vector<float> taps(256);
        designer.design(gains, kLength_m, taps);
        double worst = 0;
        for (double f = 50; f < 20500; f *= std::pow(10.0, 0.05)) {
            const double level_db = 20 * std::log10(std::abs(response_at(taps, f, 48000)));
            const double air_db = -10 * std::log10(std::numbers::e) * kLength_m * air(f);
            worst = std::max(worst, std::abs(level_db - 20 * std::log10(0.5) - air_db));
        }
        return worst;
    };
    CHECK(worst_db(air) < 0.1);
    // Companion: steps of octaves are 39 dB off at 20 kHz.
    CHECK(worst_db({}) > 30);
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
    // The highest band gives up 0.1 dB for what the crossover adds to its octave.
    CHECK(response_at(taps, 24000, 48000).real() == Approx(0.1).epsilon(0.02));
}

TEST_CASE("Gains of any magnitude give the same filter, scaled") {
    // Paths that fade out have energies down to the smallest of single precision.
    const Gains gains{1.2e-3F, 2.8e-3F, 6e-3F, 2e-2F, 4.6e-2F, 0.28F, 0.46F, 0.64F};
    BandFilterDesigner designer(48000, 256);
    std::vector<float> whole(256);
    designer.design(gains, 9, whole);
    for (const int exponent : {-60, -90, -105}) {
        Gains small = gains;
        for (float& gain : small) gain = std::ldexp(gain, exponent);
        std::vector<float> taps(256);
        designer.design(small, 9, taps);
        for (std::size_t n = 0; n < taps.size(); ++n)
            REQUIRE(std::ldexp(taps[n], -exponent) == Approx(whole[n]).margin(1e-6));
    }
}

TEST_CASE("A silent band is at least 40 dB down and the filter stays finite") {
    const Gains gains{0, 0, 0, 1, 1, 0, 0, 0};
    const std::vector<float> taps = designed(gains, 48000, 1024);
    for (const float x : taps) REQUIRE(std::isfinite(x));
    CHECK(20 * std::log10(std::abs(response_at(taps, 4000, 48000))) < -40);
    CHECK(20 * std::log10(std::abs(response_at(taps, 1000, 48000))) == Approx(0).margin(0.5));
}
