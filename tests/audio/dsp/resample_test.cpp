#include "audio/dsp/resample.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/audio/convolution/signals.h"

namespace resample_test {

using namespace aula;
using namespace aula::test;

namespace {

struct Rates {
    double from_hz;
    double to_hz;
};

// soxr's HQ has a precision of 20 bits: -120 dB, here of a tone of amplitude 1, and rounding.
constexpr double kError = 2e-6;

// Its passband falls by at most 0.01 dB towards the end.
constexpr double kRollOff = 1.2e-3;

/// Samples at the ends, where the filter reads beyond the signal.
constexpr std::size_t kEnds = 600;

}  // namespace

TEST_CASE("At equal rates resampling returns the signal to the bit") {
    const Signal noise = random_signals(1, 999, 1)[0];
    CHECK(resample(noise, 1, 48000, 48000) == noise);
    CHECK(resample(noise, 3, 44100, 44100) == noise);
}

TEST_CASE("Resampling nothing gives nothing, one sample gives at least one") {
    CHECK(resample({}, 2, 44100, 48000).empty());
    const std::vector<float> one{0.5F, -0.5F};
    CHECK(resample(one, 2, 192000, 8000).size() == 2);
    CHECK(resample(one, 2, 8000, 192000).size() == 48);
}

TEST_CASE("The number of samples is that of the same duration, rounded to nearest") {
    for (const double from_hz : {8000.0, 22050.0, 44100.0, 48000.0, 96000.0}) {
        for (const double to_hz : {8000.0, 32000.0, 44100.0, 48000.0, 192000.0}) {
            for (const std::size_t samples : {10U, 101U, 1000U}) {
                const auto expected = static_cast<std::size_t>(
                    std::lround(static_cast<double>(samples) * to_hz / from_hz));
                CAPTURE(from_hz, to_hz, samples);
                CHECK(resample(Signal(2 * samples), 2, from_hz, to_hz).size() == 2 * expected);
            }
        }
    }
}

TEST_CASE("Tones of the passband keep level and phase at any rate") {
    const Rates rates = GENERATE(Rates{44100, 48000}, Rates{48000, 44100}, Rates{48000, 96000},
                                 Rates{96000, 48000}, Rates{8000, 48000}, Rates{48000, 16000});
    for (const double share : {0.1, 0.5, 0.85}) {
        const double tone_hz = share * 0.5 * std::min(rates.from_hz, rates.to_hz);
        const Signal in = sine(tone_hz, 6000, rates.from_hz);
        const Signal out = resample(in, 1, rates.from_hz, rates.to_hz);
        const Signal expected = sine(tone_hz, out.size(), rates.to_hz);
        const auto ends =
            static_cast<std::size_t>(kEnds * std::max(1.0, rates.to_hz / rates.from_hz));
        double worst = 0;
        double step = 0;
        REQUIRE(out.size() > 2 * ends);
        for (std::size_t n = ends; n + ends < out.size(); ++n) {
            worst = std::max(worst, double{std::abs(out[n] - expected[n])});
            step = std::max(step, double{std::abs(out[n] - expected[n - 1])});
        }
        CAPTURE(rates.from_hz, rates.to_hz, share);
        CHECK(worst < (share < 0.6 ? kError : kRollOff));
        // Companion: a delay of one sample is detected.
        CHECK(step > 10 * kRollOff);
    }
}

TEST_CASE("Tones above the lower Nyquist frequency leave no alias") {
    const Rates rates = GENERATE(Rates{48000, 44100}, Rates{96000, 48000}, Rates{48000, 8000});
    for (const double share : {1.01, 1.1}) {
        const double tone_hz = share * 0.5 * rates.to_hz;
        if (tone_hz > 0.5 * rates.from_hz) continue;
        const Signal out =
            resample(sine(tone_hz, 12000, rates.from_hz), 1, rates.from_hz, rates.to_hz);
        float largest = 0;
        for (std::size_t n = kEnds; n + kEnds < out.size(); ++n)
            largest = std::max(largest, std::abs(out[n]));
        CAPTURE(rates.from_hz, rates.to_hz, share);
        CHECK(double{largest} < kError);
    }
    // Companion: without the filter the alias has the tone's level.
    const Signal dense = sine(25000, 12000, 96000);
    float largest = 0;
    for (std::size_t n = 0; n < dense.size(); n += 2)
        largest = std::max(largest, std::abs(dense[n]));
    CHECK(largest > 0.99F);
}

TEST_CASE("Channels are resampled independently") {
    const Signals channels = random_signals(3, 2000, 2);
    Signal interleaved;
    for (std::size_t n = 0; n < 2000; ++n) {
        for (const Signal& channel : channels) interleaved.push_back(channel[n]);
    }
    const Signal out = resample(interleaved, 3, 44100, 48000);
    for (std::size_t c = 0; c < 3; ++c) {
        const Signal alone = resample(channels[c], 1, 44100, 48000);
        REQUIRE(out.size() == 3 * alone.size());
        bool same = true;
        for (std::size_t n = 0; n < alone.size(); ++n) same &= out[3 * n + c] == alone[n];
        CHECK(same);  // exact
    }
}

TEST_CASE("Resampling is linear, and its impulse response is symmetric") {
    Signal impulse(2001);
    impulse[1000] = 0.5F;
    const Signal out = resample(impulse, 1, 24000, 48000);
    for (std::size_t k = 0; k < 900; ++k) {
        // Rounding of 20 bits.
        CHECK(out[2000 + k] == Approx(out[2000 - k]).margin(1e-6));
    }
    // A product with a power of two is exact.
    for (float& x : impulse) x *= 4;
    const Signal louder = resample(impulse, 1, 24000, 48000);
    for (std::size_t n = 0; n < out.size(); ++n)
        if (louder[n] != 4 * out[n]) FAIL("sample " << n);
}

}  // namespace resample_test
