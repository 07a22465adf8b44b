#include "audio/dsp/loudness.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

using aula::Loudness;
using aula::LoudnessMeter;

namespace {

/// A sine of `s` seconds in every channel, interleaved.
std::vector<float> sine(double amplitude, double frequency_hz, std::size_t channels, double s) {
    std::vector<float> samples;
    for (std::size_t i = 0; i < static_cast<std::size_t>(s * 48000); ++i) {
        const double phase = 2 * std::numbers::pi * frequency_hz * static_cast<double>(i) / 48000;
        // The initial phase of 45 degrees puts no sample of a tone at a quarter of the rate on a
        // crest.
        const double value = amplitude * std::sin(phase + std::numbers::pi / 4);
        for (std::size_t c = 0; c < channels; ++c) samples.push_back(static_cast<float>(value));
    }
    return samples;
}

/// A part of a signal of EBU Tech 3341: a tone of 1 kHz in both channels.
struct Part {
    double level_dbfs;
    double s;
};

/// The parts one after another, the phase continuous.
std::vector<float> tone_of(const std::vector<Part>& parts, double sample_rate_hz) {
    std::vector<float> samples;
    for (const Part& part : parts) {
        const double amplitude = std::pow(10.0, part.level_dbfs / 20);
        const auto count = static_cast<std::size_t>(std::lround(part.s * sample_rate_hz));
        for (std::size_t i = 0; i < count; ++i) {
            const auto n = static_cast<double>(samples.size() / 2);
            const double phase = 2 * std::numbers::pi * 1000 * n / sample_rate_hz;
            samples.insert(samples.end(), 2, static_cast<float>(amplitude * std::sin(phase)));
        }
    }
    return samples;
}

/// The true peak of a tone in both channels, dB. It fades in: the interpolation of a sudden start
/// overshoots.
double peak_db(double amplitude, double frequency_hz, double phase_deg) {
    std::vector<float> samples;
    for (int i = 0; i < 24000; ++i) {
        const double phase = 2 * std::numbers::pi * frequency_hz * i / 48000;
        const double value = std::min(1.0, i / 4800.0) * amplitude *
                             std::sin(phase + phase_deg * std::numbers::pi / 180);
        samples.insert(samples.end(), 2, static_cast<float>(value));
    }
    LoudnessMeter meter(48000, 2);
    meter.add(samples);
    return 20 * std::log10(meter.read().true_peak);
}

// EBU Tech 3341, 2016: "expected response and accepted tolerances".
constexpr double kTolerance_lu = 0.1;

}  // namespace

TEST_CASE("A full-scale tone of 997 Hz has -3.01 LUFS in one channel, 0.0 LUFS in two") {
    // The reference of ITU-R BS.1770-4; EBU Tech 3341 allows a tolerance of 0.1 LU.
    for (const auto& [channels, lufs] : {std::pair{1U, -3.01}, {2U, 0.0}, {4U, -3.01}}) {
        LoudnessMeter meter(48000, channels);
        meter.add(sine(1, 997, channels, 4));
        const Loudness loudness = meter.read();
        CHECK(loudness.momentary_lufs == Approx(lufs).margin(0.1));
        CHECK(loudness.short_term_lufs == Approx(lufs).margin(0.1));
        CHECK(loudness.integrated_lufs == Approx(lufs).margin(0.1));
    }
}

TEST_CASE("The true peak includes peaks between samples and restarts at each reading") {
    LoudnessMeter meter(48000, 2);
    meter.add(sine(0.5, 12000, 2, 1));
    // The samples are at 0.354; EBU Tech 3341 allows a true peak of +0.2 and -0.4 dB.
    CHECK(20 * std::log10(meter.read().true_peak / 0.5) == Approx(0).margin(0.4));
    meter.add(std::vector<float>(9600));
    meter.read();  // the interpolator still contains the end of the tone
    meter.add(std::vector<float>(9600));
    CHECK(meter.read().true_peak == 0);  // exact: silence
}

TEST_CASE("Silence has no loudness") {
    LoudnessMeter meter(48000, 2);
    meter.add(std::vector<float>(96000));
    CHECK(meter.read().momentary_lufs == Loudness::kSilence_lufs);
    CHECK(meter.read().integrated_lufs == Loudness::kSilence_lufs);
}

TEST_CASE("The true peak is the larger one of both channels") {
    for (const std::size_t loud : {0U, 1U}) {
        CAPTURE(loud);
        std::vector<float> samples = sine(0.5, 997, 2, 1);
        for (std::size_t i = 1 - loud; i < samples.size(); i += 2) samples[i] *= 0.1F;
        LoudnessMeter meter(48000, 2);
        meter.add(samples);
        // EBU Tech 3341 allows a true peak of +0.2 and -0.4 dB.
        CHECK(20 * std::log10(meter.read().true_peak / 0.5) == Approx(0).margin(0.4));
    }
}

TEST_CASE("A steady tone has its level in all three measures: EBU Tech 3341, cases 1 and 2") {
    const double level_dbfs = GENERATE(-23.0, -33.0);
    LoudnessMeter meter(48000, 2);
    meter.add(tone_of({{level_dbfs, 5}}, 48000));
    const Loudness loudness = meter.read();
    CHECK(loudness.momentary_lufs == Approx(level_dbfs).margin(kTolerance_lu));
    CHECK(loudness.short_term_lufs == Approx(level_dbfs).margin(kTolerance_lu));
    CHECK(loudness.integrated_lufs == Approx(level_dbfs).margin(kTolerance_lu));
    // One of the samples lies on a crest of the tone. EBU Tech 3341 allows +0.2 and -0.4 dB.
    CHECK(20 * std::log10(loudness.true_peak) == Approx(level_dbfs).margin(0.2));
}

TEST_CASE("Quiet parts are gated: EBU Tech 3341, cases 3 to 5") {
    // 16 kHz takes a third of the computation time; the gates do not depend on the sample rate.
    constexpr double kRate_hz = 16000;
    const std::vector<Part> parts =
        GENERATE(std::vector<Part>{{-36, 10}, {-23, 60}, {-36, 10}},
                 std::vector<Part>{{-72, 10}, {-36, 10}, {-23, 60}, {-36, 10}, {-72, 10}},
                 std::vector<Part>{{-26, 20}, {-20, 20.1}, {-26, 20}});
    LoudnessMeter meter(kRate_hz, 2);
    meter.add(tone_of(parts, kRate_hz));
    CHECK(meter.read().integrated_lufs == Approx(-23).margin(kTolerance_lu));
    // Companion: the mean of the energy over the whole time differs by more.
    double energy = 0;
    double all_s = 0;
    for (const Part& part : parts) {
        energy += part.s * std::pow(10.0, part.level_dbfs / 10);
        all_s += part.s;
    }
    const double mean_db = 10 * std::log10(energy / all_s);
    if (parts.size() == 3 && parts[0].level_dbfs == -26) {
        CHECK(mean_db == Approx(-23).margin(kTolerance_lu));  // nothing is gated
    } else {
        CHECK(mean_db < -23 - 5 * kTolerance_lu);
    }
}

TEST_CASE("Short-term loudness averages 3 s: EBU Tech 3341, case 9") {
    LoudnessMeter meter(48000, 2);
    std::vector<Part> parts;
    for (int repetition = 0; repetition < 3; ++repetition)
        parts.insert(parts.end(), {{-20, 1.34}, {-30, 1.66}});
    const std::vector<float> samples = tone_of(parts, 48000);
    for (std::size_t block = 0; (block + 1) * 9600 <= samples.size(); ++block) {
        meter.add(std::span(samples).subspan(block * 9600, 9600));
        const Loudness loudness = meter.read();
        if ((block + 1) * 9600 < 3 * 96000) continue;
        CHECK(loudness.short_term_lufs == Approx(-23).margin(kTolerance_lu));
    }
}

TEST_CASE("Momentary loudness averages 0.4 s: EBU Tech 3341, case 12") {
    LoudnessMeter meter(48000, 2);
    std::vector<Part> parts;
    for (int repetition = 0; repetition < 8; ++repetition)
        parts.insert(parts.end(), {{-20, 0.18}, {-30, 0.22}});
    const std::vector<float> samples = tone_of(parts, 48000);
    bool short_term_differs = false;
    for (std::size_t block = 0; (block + 1) * 960 <= samples.size(); ++block) {
        meter.add(std::span(samples).subspan(block * 960, 960));
        const Loudness loudness = meter.read();
        if ((block + 1) * 960 < 38400) continue;
        CHECK(loudness.momentary_lufs == Approx(-23).margin(kTolerance_lu));
        short_term_differs |= std::abs(loudness.short_term_lufs + 23) > kTolerance_lu;
    }
    // Companion: silence before the signal is part of the first 3 s.
    CHECK(short_term_differs);
}

TEST_CASE("True peaks of tones at any phase: EBU Tech 3341, cases 15 to 19") {
    struct Case {
        double amplitude;
        double frequency_hz;
        double phase_deg;
        double peak_db;
    };
    const Case c =
        GENERATE(Case{0.5, 12000, 0, -6}, Case{0.5, 12000, 45, -6}, Case{0.5, 8000, 60, -6},
                 Case{0.5, 6000, 67.5, -6}, Case{1.41, 12000, 45, 3});
    CAPTURE(c.frequency_hz, c.phase_deg);
    const double measured_db = peak_db(c.amplitude, c.frequency_hz, c.phase_deg);
    CHECK(measured_db <= c.peak_db + 0.2);
    CHECK(measured_db >= c.peak_db - 0.4);
}

TEST_CASE("Loudness does not depend on how the samples are divided into calls") {
    const std::vector<float> samples = tone_of({{-20, 0.7}, {-35, 0.9}}, 48000);
    LoudnessMeter whole(48000, 2);
    whole.add(samples);
    LoudnessMeter parts(48000, 2);
    std::size_t done = 0;
    for (std::size_t frames = 1; done < samples.size(); frames = frames % 1000 + 97) {
        const std::size_t count = std::min(2 * frames, samples.size() - done);
        parts.add(std::span(samples).subspan(done, count));
        done += count;
    }
    parts.add({});
    const Loudness one = whole.read();
    const Loudness other = parts.read();
    // Exact: the same filters, gates and histogram.
    CHECK(one.momentary_lufs == other.momentary_lufs);
    CHECK(one.integrated_lufs == other.integrated_lufs);
    CHECK(other.true_peak == Approx(0.1).epsilon(0.01));
}
