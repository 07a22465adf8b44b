#include "engine/tail/noise_carriers.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "aula/engine/impulse_response.h"
#include "engine/base/sampling.h"

using aula::NoiseCarriers;

namespace {

const NoiseCarriers& carriers() {
    static const NoiseCarriers carriers(48000, 1);
    return carriers;
}

constexpr std::size_t kPeriod_samples = 8 * 48000;

/// Samples of a carrier in a period.
std::size_t period_of(const NoiseCarriers& c, std::size_t carrier, std::size_t period_samples) {
    return carrier < NoiseCarriers::kHigh ? period_samples / c.decimation() : period_samples;
}

/// A period of a carrier.
std::vector<double> samples_of(const NoiseCarriers& c, std::size_t carrier,
                               std::size_t period_samples) {
    std::vector<double> samples;
    const std::size_t period = period_of(c, carrier, period_samples);
    for (std::size_t n = 0; n < period; ++n)
        samples.push_back(double{c.step()[carrier]} * *c.read(carrier, n));
    return samples;
}

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
    for (std::size_t k = 0; k < NoiseCarriers::kCount; ++k) {
        const std::size_t period = period_of(carriers(), k, kPeriod_samples);
        const std::int16_t* const over_end = carriers().read(k, period - kBefore);
        const std::int16_t* const start = carriers().read(k, 0);
        CHECK(std::equal(start, start + NoiseCarriers::kMaxRead_samples - kBefore,
                         over_end + kBefore));
        // A discontinuity would be a step, whose second difference is far above those of the noise
        // in a low band.
        if (k > 5) continue;
        int at_end = 0;
        for (std::size_t n = 0; n < 2 * kBefore; ++n)
            at_end = std::max(at_end, second_difference(over_end + n));
        int elsewhere = 0;
        for (std::size_t n = 0; n + kBefore < period; n += 100) {
            const std::int16_t* const x = carriers().read(k, n);
            for (std::size_t i = 0; i < 100; ++i)
                elsewhere = std::max(elsewhere, second_difference(x + i));
        }
        CHECK(at_end <= elsewhere);
        // Companion: a splice of different positions is detected.
        int splices = 0;
        for (std::size_t n = 0; n < period / 2; n += 500) {
            const std::int16_t* const x = carriers().read(k, n);
            const std::int16_t* const y = carriers().read(k, n + period / 2);
            splices = std::max(splices, std::abs(x[0] - 2 * x[1] + y[2]));
        }
        CHECK(splices > 3 * elsewhere);
    }
}

TEST_CASE("low carriers are sampled at more than 2.75 times their highest frequency") {
    for (const double rate_hz : {8000.0, 16000.0, 22050.0, 44100.0, 48000.0, 96000.0, 192000.0}) {
        const NoiseCarriers c(rate_hz, 1);
        CAPTURE(rate_hz, c.decimation());
        CHECK(rate_hz / static_cast<double>(c.decimation()) > 2.75 * 1995);
        CHECK(rate_hz / static_cast<double>(2 * c.decimation()) < 2.76 * 1995);
    }
}

TEST_CASE("the carriers have the power of their bands") {
    double sum = 0;
    for (std::size_t k = 0; k < NoiseCarriers::kCount; ++k) {
        const double power{carriers().power()[k]};
        sum += power;
        // A third octave of white noise; the outer carriers extend to 0 Hz and to 24 kHz.
        if (k > 0 && k + 1 < NoiseCarriers::kCount)
            CHECK(power == Approx(aula::ThirdOctaveModel::centre_hz(k) / 24000 *
                                  (std::pow(10.0, 0.05) - std::pow(10.0, -0.05)))
                               .epsilon(0.01));
        double energy = 0;
        const std::vector<double> samples = samples_of(carriers(), k, kPeriod_samples);
        for (const double x : samples) energy += x * x;
        // Levelling divides by a mean in which the sample itself weighs most, which lowers the
        // lowest octaves by some per cent. Responses are scaled to exact levels afterwards.
        CHECK(energy / static_cast<double>(samples.size()) == Approx(power).epsilon(0.05));
    }
    CHECK(sum == Approx(1).epsilon(1e-5));  // without the mean and half of the sample rate
}

TEST_CASE("neighbouring carriers do not interfere") {
    // Where two carriers overlap, each has half of the power at the edge: in phase, their sum would
    // have 3 dB too much there, and a correlation of 2 / pi of the power of the crossover.
    for (std::size_t k = 0; k + 1 < NoiseCarriers::kCount; ++k) {
        if (k + 1 == NoiseCarriers::kHigh) continue;  // another sample rate
        const std::vector<double> a = samples_of(carriers(), k, kPeriod_samples);
        const std::vector<double> b = samples_of(carriers(), k + 1, kPeriod_samples);
        double ab = 0, aa = 0, bb = 0;
        for (std::size_t n = 0; n < a.size(); ++n) {
            ab += a[n] * b[n];
            aa += a[n] * a[n];
            bb += b[n] * b[n];
        }
        CAPTURE(k);
        // Statistical, only by levelling: without it, the correlation over a period is exactly 0.
        CHECK(std::abs(ab) < 0.02 * std::sqrt(aa * bb));
    }
    // The sum of the highest carriers, above 2 kHz, is white.
    std::vector<double> sum(kPeriod_samples);
    for (std::size_t k = NoiseCarriers::kHigh; k < NoiseCarriers::kCount; ++k) {
        const std::vector<double> samples = samples_of(carriers(), k, kPeriod_samples);
        for (std::size_t n = 0; n < sum.size(); ++n) sum[n] += samples[n];
    }
    double power = 0;
    double wanted = 0;
    for (const double x : sum) power += x * x / static_cast<double>(sum.size());
    for (std::size_t k = NoiseCarriers::kHigh; k < NoiseCarriers::kCount; ++k)
        wanted += double{carriers().power()[k]};
    CHECK(power == Approx(wanted).epsilon(0.02));  // levelling
}

TEST_CASE("levelling makes the power constant over 64 independent samples, not over 32") {
    // At 8 kHz. A mean over V of the power has a variance of S / V, S the spectral density of the
    // power at low frequencies. Levelling over W subtracts the mean over W: for V = W / 2 the
    // variance becomes S / V (1 - 2 V / W + 5 / 6 V / W) = 5 / 12 S / V, for V = W S / V / 6.
    constexpr std::size_t kCarrier = 22;
    const std::vector<double> samples = samples_of(carriers(), kCarrier, kPeriod_samples);
    const double power{carriers().power()[kCarrier]};
    const auto window = static_cast<std::size_t>(2 * 32 / power);
    // The relative variance of means over that window.
    const std::size_t count = samples.size() / window;
    double sum = 0;
    double squares = 0;
    for (std::size_t i = 0; i < count; ++i) {
        double energy = 0;
        for (std::size_t n = i * window; n < (i + 1) * window; ++n)
            energy += samples[n] * samples[n];
        sum += energy;
        squares += energy * energy;
    }
    const double levelled = static_cast<double>(count) * squares / (sum * sum) - 1;
    // Gaussian noise of bandwidth B has the variance 1 / (B V). With the crossovers, B is the
    // power over the mean of its square: 2 * 3 / 8.
    const double natural = 0.75 / 32;
    CAPTURE(levelled, natural);
    // The standard error of the variance is 7 %. The bounds are the geometric means of 5 / 12 and
    // its neighbours: 1 / 6 if the window were half as long, 1 without levelling.
    CHECK(levelled / natural > std::sqrt(5.0 / 12 / 6));
    CHECK(levelled / natural < std::sqrt(5.0 / 12));
}

TEST_CASE("carriers of a noise that begins later in its period begin as much later") {
    // The windows of levelling extend over the end of the period.
    constexpr double kRate_hz = 8000;
    std::vector<float> noise(8192);
    aula::RandomStream random(5);
    for (float& x : noise) x = random.uniform() - 0.5F;
    const aula::CarrierFilters filters(kRate_hz, noise.size());
    const NoiseCarriers first(filters, noise);
    const std::size_t later = noise.size() / 2;
    std::rotate(noise.begin(), noise.begin() + static_cast<std::ptrdiff_t>(later), noise.end());
    const NoiseCarriers second(filters, noise);
    for (std::size_t k = 0; k < NoiseCarriers::kCount; ++k) {
        if (first.power()[k] == 0) continue;
        CHECK(second.step()[k] == Approx(first.step()[k]).epsilon(1e-3));
        int largest = 0;
        const std::size_t period = period_of(first, k, noise.size());
        for (std::size_t n = 0; n < period; ++n) {
            largest = std::max(
                largest, std::abs(*first.read(k, (n + period / 2) % period) - *second.read(k, n)));
        }
        CAPTURE(k);
        CHECK(largest <= 33);  // 1e-3 of the largest value
    }
}

TEST_CASE("the offset of a source depends on its name, the room and the seed only") {
    const NoiseCarriers again(48000, 1);
    const NoiseCarriers other(48000, 2);
    CHECK(carriers().offset(7, "violin", 0) == again.offset(7, "violin", 0));
    CHECK(carriers().offset(7, "violin", 0) != carriers().offset(7, "viola", 0));
    CHECK(carriers().offset(7, "violin", 0) != other.offset(7, "violin", 0));
    CHECK(carriers().offset(7, "violin", 0) != carriers().offset(8, "violin", 0));
    CHECK(carriers().waves_seed(7, "violin") != carriers().waves_seed(8, "violin"));
    CHECK(carriers().offset(7, "", 0) < kPeriod_samples);
}

TEST_CASE("the channels of a source are at least half a second apart") {
    std::vector<std::size_t> offsets;
    for (std::size_t c = 0; c < NoiseCarriers::kMaxChannels; ++c) {
        offsets.push_back(carriers().offset(7, "violin", c));
        for (std::size_t d = 0; d < c; ++d) {
            const std::size_t apart = (offsets[c] + kPeriod_samples - offsets[d]) % kPeriod_samples;
            CHECK(std::min(apart, kPeriod_samples - apart) >= 24000);
            // Those of the first order are farther apart.
            if (c < 4) CHECK(std::min(apart, kPeriod_samples - apart) >= 48000);
        }
    }
}
