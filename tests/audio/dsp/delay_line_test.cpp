#include "audio/dsp/delay_line.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

using namespace aula;

namespace {

// Interpolation error at 0.8 of the Nyquist frequency, -90 dB, and rounding.
constexpr double kError = 3.2e-5 + 1e-6;

constexpr double kStep_rad = 0.8 * std::numbers::pi;

double tone(double time_samples) { return std::sin(kStep_rad * time_samples); }

}  // namespace

TEST_CASE("A delay line delays its input by every delay, also across the end of its ring") {
    constexpr int kLongest = 200;
    constexpr int kHistory = 32;
    constexpr int kBlock = 48;
    const FractionalDelay interpolator;
    DelayLine line(interpolator, kLongest, kHistory, kBlock);
    int time = 0;
    double worst = 0;
    int reads = 0;
    // The ring of 512 samples is traversed eight times.
    for (int turn = 0; time < 4096; ++turn) {
        const int samples = turn % 3 == 0 ? kBlock : turn % 3 == 1 ? 1 : 17;
        std::vector<float> block;
        for (int n = 0; n < samples; ++n) block.push_back(static_cast<float>(tone(time + n)));
        line.write(block.data(), block.size());
        for (int offset = -kHistory; offset < samples; ++offset) {
            for (const double delay :
                 {DelayLine::kShortest_samples, 16.37, 63.5, 151.004, double{kLongest}}) {
                const double at = time + offset - delay;
                if (at < double{FractionalDelay::kBefore}) continue;
                worst = std::max(worst, std::abs(double{line.read(offset, delay)} - tone(at)));
                ++reads;
            }
        }
        line.advance(block.size());
        time += samples;
    }
    CHECK(reads > 40'000);
    CHECK(worst < kError);
}

TEST_CASE("The impulse response of a fractional delay has that delay") {
    const FractionalDelay interpolator;
    // On and between the phases of the table.
    for (const double fraction : {0.0, 0.001, 0.25, 0.3, 0.5021, 0.99707, 0.9987}) {
        const auto taps = interpolator.impulse(fraction);
        double worst = 0;
        for (int n = 0; n < 100; ++n) {
            double sum = 0;
            for (std::size_t k = 0; k < taps.size(); ++k)
                sum += double{taps[k]} * tone(n - static_cast<double>(k));
            worst = std::max(worst,
                             std::abs(sum - tone(n - double{FractionalDelay::kBefore} - fraction)));
        }
        CAPTURE(fraction);
        CHECK(worst < kError);
    }
}
