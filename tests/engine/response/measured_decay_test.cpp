#include "engine/response/measured_decay.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace aula;

constexpr double kRate_hz = 24000;
constexpr std::size_t kZero = 480;  // 20 ms

double rate(double time_s) { return 6 * std::log(10.0) / time_s; }

/// White noise with a power envelope from kZero on, above a white floor of the given power.
std::vector<float> response(double length_s, unsigned seed, double floor,
                            const std::function<double(double time_s)>& power) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<float> samples(static_cast<std::size_t>(length_s * kRate_hz));
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double decay = i < kZero ? 0 : power(static_cast<double>(i - kZero) / kRate_hz);
        samples[i] = static_cast<float>(normal(random) * std::sqrt(decay) +
                                        normal(random) * std::sqrt(floor));
    }
    return samples;
}

std::function<double(double)> exponential(double time_s) {
    return [time_s](double t) { return std::exp(-rate(time_s) * t); };
}

constexpr unsigned kSeeds = 8;

/// Mean of a parameter over seeds; empty unless all have it.
std::optional<double> mean_of(std::optional<double> BandParameters::*member,
                              const FrequencyBand& band,
                              const std::function<std::vector<float>(unsigned seed)>& make) {
    double sum = 0;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
        const auto decay = measured_decay(make(seed), kRate_hz, kZero, band);
        if (!decay) return std::nullopt;
        const auto value = band_parameters(DecayCurve(*decay)).*member;
        if (!value) return std::nullopt;
        sum += *value;
    }
    return sum / kSeeds;
}

/// Four standard errors of the mean of kSeeds decay times of Gaussian noise, relative. One has a
/// standard deviation of 0.6 / sqrt(B T) for T30 (measured over 20 seeds), twice that for T20.
double tolerance(const FrequencyBand& band, double time_s) {
    return 4 * 0.6 / std::sqrt(band.width_hz() * time_s * kSeeds);
}

std::vector<FrequencyBand> octaves() {
    std::vector<FrequencyBand> bands;
    for (int b = -4; b <= 3; ++b) bands.push_back(FrequencyBand::at(b, 1));
    return bands;
}

}  // namespace

TEST_CASE("a band-pass has no delay, -3 dB at its edges and 32 dB at the next octave") {
    for (const int per_octave : {1, 3}) {
        const FrequencyBand band = FrequencyBand::at(0, per_octave);
        const auto gain_db = [&](double frequency_hz) {
            constexpr std::size_t kCount = 48000;
            std::vector<float> sine(kCount);
            const double step = 2 * std::numbers::pi * frequency_hz / 48000;
            for (std::size_t i = 0; i < kCount; ++i)
                sine[i] = static_cast<float>(std::cos(step * static_cast<double>(i)));
            const std::vector<double> filtered = band_passed(sine, 48000, band, 0);
            // The amplitude in phase: what a delay turns is lost.
            double sum = 0;
            for (std::size_t i = kCount / 4; i < kCount * 3 / 4; ++i)
                sum += filtered[i] * double{sine[i]} * 4 / kCount;
            return 20 * std::log10(sum);
        };
        CHECK(gain_db(1000) == Approx(0).margin(0.01));
        CHECK(gain_db(band.low_hz) == Approx(-3.01).margin(0.05));
        CHECK(gain_db(band.high_hz) == Approx(-3.01).margin(0.05));
        if (per_octave == 1) CHECK(gain_db(500) == Approx(-32).margin(1));
        if (per_octave == 3) CHECK(gain_db(790) == Approx(-29).margin(1.5));
    }
}

TEST_CASE("bands have the centres of IEC 61260-1") {
    CHECK(FrequencyBand::at(-4, 1).low_hz == Approx(44.67).margin(0.01));
    CHECK(FrequencyBand::at(3, 1).high_hz == Approx(11220).margin(1));
    CHECK(FrequencyBand::at(-13, 3).low_hz == Approx(44.67).margin(0.01));
    CHECK(FrequencyBand::at(12, 3).high_hz == Approx(17783).margin(1));
}

TEST_CASE("a decay above a floor has its T20, T30, C80 and Ts in every octave") {
    const double t = 1;
    const auto make = [&](unsigned seed) { return response(1.6, seed, 1e-5, exponential(t)); };
    for (const FrequencyBand& band : octaves()) {
        INFO("octave from " << band.low_hz << " Hz");
        const double bound = tolerance(band, t);
        const auto t30 = mean_of(&BandParameters::t30_s, band, make);
        REQUIRE(t30);
        CHECK(*t30 == Approx(t).epsilon(bound));
        CHECK(mean_of(&BandParameters::t20_s, band, make).value() == Approx(t).epsilon(2 * bound));
        CHECK(mean_of(&BandParameters::ts_s, band, make).value() ==
              Approx(1 / rate(t)).epsilon(2 * bound));
        // Energies of times t of Gaussian noise have the relative variance 1 / (B t).
        const double early = 1 / (band.width_hz() * 0.08);
        const double late = rate(t) / band.width_hz();
        CHECK(mean_of(&BandParameters::c80_db, band, make).value() ==
              Approx(10 * std::log10(std::exp(rate(t) * 0.08) - 1))
                  .margin(4 * 4.34 * std::sqrt((early + late) / kSeeds)));
    }
    // Companion: the bound tells a decay that is longer by 3 %.
    CHECK(mean_of(&BandParameters::t30_s, FrequencyBand::at(3, 1), make).value() !=
          Approx(1.03 * t).epsilon(tolerance(FrequencyBand::at(3, 1), t)));
}

TEST_CASE("third octaves have the decay of their octave") {
    const double t = 0.8;
    const auto make = [&](unsigned seed) { return response(1.4, seed, 1e-6, exponential(t)); };
    for (const int third : {-13, -10, -5, 0, 5, 10}) {
        const FrequencyBand band = FrequencyBand::at(third, 3);
        INFO("third octave from " << band.low_hz << " Hz");
        CHECK(mean_of(&BandParameters::t30_s, band, make).value() ==
              Approx(t).epsilon(tolerance(band, t)));
    }
}

TEST_CASE("octaves with different decays are told apart") {
    // Noise in every second octave, whose decay falls from 2 s at 63 Hz to 0.8 s at 4 kHz.
    const auto time_s = [](std::size_t b) { return 2 - 0.2 * static_cast<double>(b); };
    const std::vector<FrequencyBand> bands = octaves();
    const auto make = [&](unsigned seed) {
        std::vector<float> sum = response(2.5, 100 + seed, 1e-8, [](double) { return 0; });
        for (std::size_t b = 0; b < bands.size(); b += 2) {
            const std::vector<float> noise =
                response(2.5, 8 * seed + static_cast<unsigned>(b), 0, [](double) { return 1; });
            const std::vector<double> band = band_passed(noise, kRate_hz, bands[b], 0);
            const double amplitude_rate = rate(time_s(b)) / 2;
            for (std::size_t i = kZero; i < sum.size(); ++i)
                sum[i] += static_cast<float>(
                    band[i] *
                    std::exp(-amplitude_rate * static_cast<double>(i - kZero) / kRate_hz));
        }
        return sum;
    };
    for (std::size_t b = 0; b < bands.size(); b += 2) {
        INFO("octave " << b);
        CHECK(mean_of(&BandParameters::t30_s, bands[b], make).value() ==
              Approx(time_s(b)).epsilon(tolerance(bands[b], time_s(b))));
    }
}

TEST_CASE("a decay time needs a decay range of 10 dB more, and the floor does not change it") {
    const double t = 1;
    const FrequencyBand band = FrequencyBand::at(2, 1);  // 4 kHz
    const auto with_floor = [&](double floor_db) {
        return [=](unsigned seed) {
            return response(2, seed, std::pow(10, floor_db / 10), exponential(t));
        };
    };
    const auto of = [&](std::optional<double> BandParameters::*member, double floor_db) {
        return mean_of(member, band, with_floor(floor_db));
    };
    CHECK_FALSE(of(&BandParameters::t30_s, -43));
    CHECK_FALSE(of(&BandParameters::t20_s, -33));
    const double t30 = of(&BandParameters::t30_s, -100).value();
    // The same noise above a floor: less than the error of a perfect evaluation.
    CHECK(of(&BandParameters::t30_s, -47).value() == Approx(t30).epsilon(0.01));
    CHECK(of(&BandParameters::t20_s, -37).value() ==
          Approx(of(&BandParameters::t20_s, -100).value()).epsilon(0.01));
    // Companion: without the search for the floor, T20 is wrong.
    SampledDecay raw{.energy = {}, .bin_s = 1 / kRate_hz, .tail = {}};
    const std::vector<double> filtered = band_passed(with_floor(-37)(1), kRate_hz, band, 0);
    for (std::size_t i = kZero; i < filtered.size(); ++i)
        raw.energy.push_back(filtered[i] * filtered[i]);
    raw.tail = {.energy = 0, .time_s = 1};
    CHECK(band_parameters(DecayCurve(raw)).t20_s.value() > 1.15 * t);
}

TEST_CASE("the range of a decay is that above its floor") {
    const auto samples = response(2, 1, 1e-5, exponential(1));
    const auto decay = measured_decay(samples, kRate_hz, kZero, FrequencyBand::at(2, 1));
    REQUIRE(decay);
    const DecayCurve curve(*decay);
    // 50 dB; a standard error of 0.1 dB of the energy of 40 ms in the octave of 4 kHz.
    CHECK(10 * std::log10(curve.total() / curve.tail()) == Approx(50).margin(0.5));
}

TEST_CASE("two slopes have the times of the closed form of their decay curve") {
    // 0.4 s, and 25 dB below it 1.6 s.
    const auto power = [](double t) {
        return std::exp(-rate(0.4) * t) + std::pow(10, -2.5) * std::exp(-rate(1.6) * t);
    };
    SampledDecay exact{.energy = {}, .bin_s = 1e-4, .tail = SampledDecay::Tail{}};
    for (int i = 0; i < 30000; ++i) exact.energy.push_back(power((i + 0.5) * exact.bin_s));
    const BandParameters expected = band_parameters(DecayCurve(exact));
    const FrequencyBand band = FrequencyBand::at(3, 1);
    const auto make = [&](unsigned seed) { return response(3, seed, 1e-7, power); };
    const auto check = [&](std::optional<double> BandParameters::*member, double bound) {
        CHECK(mean_of(member, band, make).value() ==
              Approx((expected.*member).value()).epsilon(bound));
    };
    const double bound = tolerance(band, 0.4);
    check(&BandParameters::t30_s, bound);
    check(&BandParameters::t20_s, 2 * bound);
    check(&BandParameters::edt_s, 3 * bound);
    CHECK(expected.t30_s.value() > 1.2 * expected.edt_s.value());
}

TEST_CASE("a decay that lasts to the end of the response has no floor") {
    const double t = 1;
    // It ends 50 dB down.
    const auto make = [&](unsigned seed) { return response(0.853, seed, 0, exponential(t)); };
    const FrequencyBand band = FrequencyBand::at(3, 1);
    const auto decay = measured_decay(make(1), kRate_hz, kZero, band);
    REQUIRE(decay);
    CHECK_FALSE(decay->tail);
    CHECK(mean_of(&BandParameters::t30_s, band, make).value() ==
          Approx(t).epsilon(tolerance(band, t)));
}

TEST_CASE("noise has no decay") {
    const auto samples = response(2, 1, 1, [](double) { return 0; });
    for (const FrequencyBand& band : octaves()) {
        const auto decay = measured_decay(samples, kRate_hz, kZero, band);
        // A low octave may begin louder by chance, far from a range of 10 dB.
        if (decay) CHECK_FALSE(band_parameters(DecayCurve(*decay)).c50_db);
    }
}

TEST_CASE("what precedes time zero is not part of the response") {
    auto samples = response(1.6, 1, 1e-6, exponential(1));
    const FrequencyBand band = FrequencyBand::at(1, 1);
    const auto c80 = [&](const std::vector<float>& of, std::size_t zero) {
        return band_parameters(DecayCurve(measured_decay(of, kRate_hz, zero, band).value())).c80_db;
    };
    const double alone = c80(samples, kZero).value();
    // The product of a distortion 100 ms before, as loud as the response.
    std::vector<float> distorted(2400, 0.0F);
    for (std::size_t i = 0; i < 1200; ++i) distorted[i] = samples[kZero + i];
    distorted.insert(distorted.end(), samples.begin(), samples.end());
    CHECK(c80(distorted, 2400 + kZero).value() == Approx(alone).margin(0.01));
}

TEST_CASE("time zero is the first sample at most 20 dB below the largest") {
    std::vector<float> samples(100, 0.001F);
    samples[40] = -0.101F;
    samples[60] = 1;
    CHECK(first_arrival(samples) == 40);
    samples[40] = -0.099F;
    CHECK(first_arrival(samples) == 60);
}
