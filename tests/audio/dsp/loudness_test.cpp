#include "audio/dsp/loudness.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
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
