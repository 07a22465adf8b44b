#include "audio/dsp/limiter.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "audio/dsp/resample.h"

using namespace aula;

namespace {

constexpr double kRate_hz = 48000;
constexpr float kCeiling = 0.8912509F;  // -1 dBFS

using Stereo = std::array<std::vector<float>, 2>;

/// Runs a limiter over the signal in calls of 1 to 256 samples.
Stereo limited(Stereo signal, int& latency) {
    Limiter limiter(kRate_hz, 2, 256);
    latency = limiter.latency_samples();
    std::mt19937 random(3);
    std::uniform_int_distribution<std::size_t> call(1, 256);
    for (std::size_t done = 0; done < signal[0].size();) {
        const std::size_t n = std::min(call(random), signal[0].size() - done);
        const std::array<float*, 2> channels{signal[0].data() + done, signal[1].data() + done};
        limiter.process(channels, static_cast<int>(n));
        done += n;
    }
    return signal;
}

Stereo noise(std::size_t samples, float scale) {
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform(-scale, scale);
    Stereo signal;
    for (auto& channel : signal) {
        channel.resize(samples);
        for (float& x : channel) x = uniform(random);
    }
    return signal;
}

/// The largest magnitude at 16 times the rate, excluding the ends, where the resampler rings.
float true_peak(const std::vector<float>& signal) {
    const std::vector<float> fine = resample(signal, 1, kRate_hz, 16 * kRate_hz);
    float peak = 0;
    for (std::size_t n = 16 * 1000; n + 16 * 1000 < fine.size(); ++n) {
        peak = std::max(peak, std::abs(fine[n]));
    }
    return peak;
}

}  // namespace

TEST_CASE("Below the ceiling the limiter is a delay, to the bit") {
    // Peaks of white noise between samples are up to twice as high.
    const Stereo in = noise(20000, 0.4F * kCeiling);
    int latency = 0;
    const Stereo out = limited(in, latency);
    CHECK(latency == 192 + 15);  // 4 ms, and the delay of the interpolator
    for (std::size_t c = 0; c < 2; ++c) {
        CHECK(std::equal(in[c].begin(), in[c].end() - latency, out[c].begin() + latency));
        CHECK(
            std::all_of(out[c].begin(), out[c].begin() + latency, [](float x) { return x == 0; }));
    }
}

TEST_CASE("No output sample exceeds the ceiling for any input") {
    Stereo in = noise(48000, 4);
    // Single peaks in silence, adjacent and far apart.
    for (std::size_t i = 10000; i < 20000; ++i) in[0][i] = in[1][i] = 0;
    in[0][12000] = 3;
    in[1][12001] = -30;
    in[0][15000] = 1e6F;
    int latency = 0;
    const Stereo out = limited(in, latency);
    float peak = 0;
    for (const auto& channel : out) {
        for (const float x : channel) peak = std::max(peak, std::abs(x));
    }
    CHECK(peak <= kCeiling);
    // The single peak is output at the ceiling, not lower; the gain is rounded to one part in 10^6.
    CHECK(std::abs(out[1][static_cast<std::size_t>(12001 + latency)]) ==
          Approx(kCeiling).epsilon(1e-6));
}

TEST_CASE("A level that falls for longer than the look-ahead stays below the ceiling") {
    // The required gain rises with every sample, so that each sample of the look-ahead is a
    // candidate of the minimum: 60 dB in 0.3 s, slower than the release.
    Stereo in;
    for (auto& channel : in) {
        for (int n = 0; n < 24000; ++n) {
            const double decay_db =
                n < 2000 ? 0 : std::min(60.0, (n - 2000) / (0.3 * kRate_hz) * 60);
            channel.push_back(static_cast<float>(100 * std::pow(10, -decay_db / 20)));
        }
    }
    int latency = 0;
    const Stereo out = limited(in, latency);
    CHECK(*std::max_element(out[0].begin(), out[0].end()) <= kCeiling);
}

TEST_CASE("Both channels get the same gain") {
    Stereo in = noise(9600, 3);
    for (std::size_t i = 0; i < in[0].size(); ++i) in[1][i] = 0.125F * in[0][i];
    int latency = 0;
    const Stereo out = limited(in, latency);
    for (std::size_t i = 0; i < out[0].size(); ++i) CHECK(out[1][i] == 0.125F * out[0][i]);
}

TEST_CASE("Peaks between samples stay below -1 dBTP") {
    // A tone at a quarter of the sample rate, sampled at 45, 135, ... degrees: its peaks are 3 dB
    // above its samples. Then band-limited white noise.
    Stereo tone;
    for (auto& channel : tone) {
        for (std::size_t n = 0; n < 9600; ++n) {
            channel.push_back(n % 4 < 2 ? 0.8F : -0.8F);  // below the ceiling
        }
    }
    Stereo band = noise(48000, 2);
    for (auto& channel : band) {
        channel = resample(resample(channel, 1, kRate_hz, 36000), 1, 36000, kRate_hz);
    }
    for (const Stereo& in : {tone, band}) {
        int latency = 0;
        const Stereo out = limited(in, latency);
        const float before = true_peak(in[0]);
        const float after = true_peak(out[0]);
        CHECK(20 * std::log10(double{before}) > 0.9);
        // Eightfold oversampling underestimates peaks by up to 0.1 dB.
        CHECK(20 * std::log10(double{after}) < -0.9);
        CHECK(20 * std::log10(double{after}) > -1.5);
    }
    // Companion: the samples of the tone are below the ceiling before limiting.
    CHECK(*std::max_element(tone[0].begin(), tone[0].end()) < kCeiling);
}

TEST_CASE("The gain changes smoothly and is exactly one again after a peak") {
    Stereo in;
    in[0].assign(96000, 0.5F);
    in[1].assign(96000, 0.5F);
    in[0][1000] = 4;
    int latency = 0;
    const Stereo out = limited(in, latency);
    float step = 0;
    for (std::size_t i = static_cast<std::size_t>(latency) + 1; i < out[1].size(); ++i) {
        step = std::max(step, std::abs(out[1][i] - out[1][i - 1]));
    }
    // The gain falls linearly by 1 - 0.89 / 4 = 0.78 in 192 samples.
    CHECK(step < 0.5F * 0.78F / 192 * 1.01F);
    CHECK(step > 0.5F * 0.78F / 192 * 0.9F);
    // 0.1 s after the peak e^-1 of the reduction remains, finally nothing.
    CHECK(out[1][1000 + 4800] == Approx(0.5F * (1 - 0.78F / 2.718F)).epsilon(0.05));
    CHECK(out[1].back() == 0.5F);
}

TEST_CASE("The limiter's output does not depend on the size of its calls, to the bit") {
    // Peaks far above the ceiling, just above it, and between samples.
    Stereo in = noise(20000, 1);
    for (std::size_t n = 0; n < in[0].size(); ++n) {
        const float envelope = 0.2F + 2 * static_cast<float>(n % 5000) / 5000;
        for (auto& channel : in) channel[n] *= envelope * envelope;
    }
    const auto with_calls = [&](std::size_t call) {
        Stereo signal = in;
        Limiter limiter(kRate_hz, 2, 4096);
        float min = 1;
        for (std::size_t done = 0; done < signal[0].size(); done += call) {
            const std::size_t n = std::min(call, signal[0].size() - done);
            const std::array<float*, 2> channels{signal[0].data() + done, signal[1].data() + done};
            limiter.process(channels, static_cast<int>(n));
            min = std::min(min, limiter.min_gain());
        }
        return std::pair{signal, min};
    };
    const auto [whole, min] = with_calls(4096);
    // The largest peak is (0.2 + 2)^2 or more.
    CHECK(min < kCeiling / 4.5F);
    for (const std::size_t call : {1U, 7U, 256U, 1000U}) {
        CAPTURE(call);
        const auto [parts, min_of_parts] = with_calls(call);
        CHECK(parts[0] == whole[0]);
        CHECK(parts[1] == whole[1]);
        CHECK(min_of_parts == min);
    }
}

TEST_CASE("The ceiling holds at any sample rate and for any number of channels") {
    for (const double rate_hz : {8000.0, 44100.0, 192000.0}) {
        for (const std::size_t count : {1U, 4U, 16U}) {
            Limiter limiter(rate_hz, count, 512);
            CAPTURE(rate_hz, count);
            CHECK(limiter.latency_samples() == std::lround(0.004 * rate_hz) + 15);
            std::vector<std::vector<float>> signal(count, noise(4096, 0.1F)[0]);
            // Only the last channel exceeds the ceiling, and lowers the gain of all.
            signal.back() = noise(4096, 5)[1];
            float peak = 0;
            float quiet = 0;
            for (std::size_t done = 0; done < 4096; done += 512) {
                std::vector<float*> channels;
                for (auto& channel : signal) channels.push_back(channel.data() + done);
                limiter.process(channels, 512);
                for (std::size_t n = 0; n < 512; ++n) {
                    peak = std::max(peak, std::abs(channels.back()[n]));
                    quiet = std::max(quiet, std::abs(channels.front()[n]));
                }
            }
            CHECK(peak <= kCeiling);
            CHECK(peak > 0.5F * kCeiling);
            if (count > 1) CHECK(quiet < 0.1F * 0.5F);
        }
    }
}

TEST_CASE("A peak that decays sample by sample is held for the look-ahead") {
    // The gain required rises with each sample, more slowly than the release.
    constexpr float kDecay = 1e-4F;
    Stereo in;
    for (auto& channel : in) {
        for (int n = 0; n < 4000; ++n)
            channel.push_back(n < 500 ? 0 : 20 * std::exp(-kDecay * static_cast<float>(n - 500)));
    }
    int latency = 0;
    const Stereo out = limited(in, latency);
    CHECK(*std::max_element(out[0].begin(), out[0].end()) <= kCeiling);
    // A sample is limited by the peaks up to 4 ms before it.
    for (const std::size_t n : {1500U, 2500U, 3500U}) {
        CHECK(out[0][n] > kCeiling * std::exp(-kDecay * 192));
    }
}

TEST_CASE("The samples on both sides of a peak between them get the gain that it requires") {
    // The peak of 4 lies in the middle between two samples of the first channel. The other channel
    // shows the gain.
    constexpr std::size_t kPeak = 2000;
    constexpr float kSmall = 0.0625F;
    Stereo signal{std::vector<float>(4000), std::vector<float>(4000, kSmall)};
    for (std::size_t n = 0; n < signal[0].size(); ++n) {
        const double x = std::numbers::pi * (static_cast<double>(n) - kPeak - 0.5);
        signal[0][n] = static_cast<float>(4 * std::sin(x) / x);
    }
    int latency = 0;
    const Stereo output = limited(signal, latency);
    const std::size_t before = kPeak + static_cast<std::size_t>(latency);
    const auto least = std::min_element(output[1].begin() + latency, output[1].end());
    CHECK(output[1][before] == *least);
    CHECK(output[1][before + 1] == *least);
    CHECK(output[1][before - 1] > *least);
    CHECK(output[1][before + 2] > *least);
    // The interpolation misses up to 6 % of an impulse of the full bandwidth.
    CHECK(*least / kSmall == Approx(kCeiling / 4).epsilon(0.06));
}
