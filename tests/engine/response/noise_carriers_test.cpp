#include "engine/response/noise_carriers.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "aula/engine/impulse_response.h"
#include "engine/base/sampling.h"
#include "engine/response/octave_bank.h"

using aula::kBandCount;
using aula::NoiseCarriers;

namespace {

const NoiseCarriers& carriers() {
    static const NoiseCarriers carriers(48000, 1);
    return carriers;
}

constexpr std::size_t kPeriod_samples = 8 * 48000;

int second_difference(const std::int16_t* x) { return std::abs(x[0] - 2 * x[1] + x[2]); }

}  // namespace

TEST_CASE("rooms of one sample rate and seed share their carriers") {
    const auto first = aula::make_noise_carriers(8000, 7);
    CHECK(aula::make_noise_carriers(8000, 7) == first);
    CHECK(aula::make_noise_carriers(8000, 8) != first);
    CHECK(aula::make_noise_carriers(8001, 7) != first);
}

TEST_CASE("the carriers are periodic without a discontinuity") {
    constexpr std::size_t kBefore = 100;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const std::int16_t* const over_end = carriers().read(b, kPeriod_samples - kBefore, 0);
        const std::int16_t* const start = carriers().read(b, 0, kPeriod_samples);
        CHECK(std::equal(start, start + NoiseCarriers::kMaxRead_samples - kBefore,
                         over_end + kBefore));
        // A discontinuity would be a step, whose second difference is far above those of the noise
        // in a low band.
        if (b > 2) continue;
        int at_end = 0;
        for (std::size_t n = 0; n < 2 * kBefore; ++n) {
            at_end = std::max(at_end, second_difference(over_end + n));
        }
        int elsewhere = 0;
        for (std::size_t n = 0; n + kBefore < kPeriod_samples; n += 500) {
            const std::int16_t* const x = carriers().read(b, 0, n);
            for (std::size_t k = 0; k < 500; ++k) {
                elsewhere = std::max(elsewhere, second_difference(x + k));
            }
        }
        CHECK(at_end <= elsewhere);
        // Companion: a splice of different positions is detected.
        int splices = 0;
        for (std::size_t n = 0; n < kPeriod_samples; n += 5000) {
            const std::int16_t* const x = carriers().read(b, 0, n);
            const std::int16_t* const y = carriers().read(b, 0, n + kPeriod_samples / 2);
            splices = std::max(splices, std::abs(x[0] - 2 * x[1] + y[2]));
        }
        CHECK(splices > 10 * elsewhere);
    }
}

TEST_CASE("the carriers have the power of their bands") {
    double sum = 0;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double power{carriers().power()[b]};
        sum += power;
        const double unit{carriers().step()[b]};
        double energy = 0;
        for (std::size_t n = 0; n < kPeriod_samples; ++n) {
            const double x = unit * *carriers().read(b, 0, n);
            energy += x * x;
        }
        // Levelling divides by a mean in which the sample itself weighs most, which lowers the
        // lowest octaves by some per cent. Responses are scaled to exact levels afterwards.
        CHECK(energy / kPeriod_samples == Approx(power).epsilon(0.05));
    }
    CHECK(sum == Approx(1).epsilon(1e-6));  // rounding
}

TEST_CASE("levelling makes the power constant over eight independent samples, not over four") {
    // At 1 kHz. A mean over V of the power has a variance of S / V, S the spectral density of the
    // power at low frequencies. Levelling over W subtracts the mean over W: for V = W / 2 the
    // variance becomes S / V (1 - 2 V / W + 5 / 6 V / W) = 5 / 12 S / V, for V = W S / V / 6.
    constexpr std::size_t kBand = 4;
    const double power{carriers().power()[kBand]};
    const auto window = static_cast<std::size_t>(2 * 4 / power);
    // The relative variance of means over that window.
    const auto variance_of = [&](const auto& sample) {
        double sum = 0;
        double squares = 0;
        const std::size_t count = kPeriod_samples / window;
        for (std::size_t i = 0; i < count; ++i) {
            double energy = 0;
            for (std::size_t n = i * window; n < (i + 1) * window; ++n)
                energy += sample(n) * sample(n);
            sum += energy;
            squares += energy * energy;
        }
        return static_cast<double>(count) * squares / (sum * sum) - 1;
    };
    const double levelled = variance_of([&](std::size_t n) {
        return double{carriers().step()[kBand]} * *carriers().read(kBand, 0, n);
    });
    // White noise in the same octave.
    aula::RandomStream random(3);
    std::vector<double> white(kPeriod_samples);
    for (double& x : white) x = double{random.uniform()} - 0.5;
    const auto octaves = aula::OctaveBank(48000).process(white);
    const double natural = variance_of([&](std::size_t n) { return octaves[n][kBand]; });
    CAPTURE(levelled, natural);
    // The standard errors of both variances are 3 %. The bounds are the geometric means of 5 / 12
    // and its neighbours: 1 / 6 if the window were half as long, 1 without levelling.
    CHECK(levelled / natural > std::sqrt(5.0 / 12 / 6));
    CHECK(levelled / natural < std::sqrt(5.0 / 12));
}

TEST_CASE("carriers of a noise that begins later in its period begin as much later") {
    // The windows of levelling extend over the end of the period.
    constexpr double kRate_hz = 8000;
    std::vector<double> noise(8192);
    aula::RandomStream random(5);
    for (double& x : noise) x = double{random.uniform()} - 0.5;
    const NoiseCarriers first(kRate_hz, noise);
    const std::size_t later = noise.size() / 2;
    std::rotate(noise.begin(), noise.begin() + static_cast<std::ptrdiff_t>(later), noise.end());
    const NoiseCarriers second(kRate_hz, noise);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        if (first.power()[b] == 0) continue;
        CHECK(second.step()[b] == Approx(first.step()[b]).epsilon(1e-3));
        int largest = 0;
        for (std::size_t n = 0; n < noise.size(); ++n) {
            largest = std::max(largest, std::abs(*first.read(b, later, n) - *second.read(b, 0, n)));
        }
        CAPTURE(b);
        CHECK(largest <= 33);  // 1e-3 of the largest value
    }
}

TEST_CASE("the offset of a source depends on its name and the seed only") {
    const NoiseCarriers again(48000, 1);
    const NoiseCarriers other(48000, 2);
    CHECK(carriers().offset("violin", 0) == again.offset("violin", 0));
    CHECK(carriers().offset("violin", 0) != carriers().offset("viola", 0));
    CHECK(carriers().offset("violin", 0) != other.offset("violin", 0));
    CHECK(carriers().offset("", 0) < kPeriod_samples);
}

TEST_CASE("the channels of a source are at least half a second apart") {
    std::vector<std::size_t> offsets;
    for (std::size_t c = 0; c < NoiseCarriers::kMaxChannels; ++c) {
        offsets.push_back(carriers().offset("violin", c));
        for (std::size_t d = 0; d < c; ++d) {
            const std::size_t apart = (offsets[c] + kPeriod_samples - offsets[d]) % kPeriod_samples;
            CHECK(std::min(apart, kPeriod_samples - apart) >= 24000);
            // Those of the first order are farther apart.
            if (c < 4) CHECK(std::min(apart, kPeriod_samples - apart) >= 48000);
        }
    }
}
