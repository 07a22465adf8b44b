#include "audio/render/headphones.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include "audio/file/headphone_file.h"
#include "aula/audio/sound_file.h"
#include "aula/exception.h"
#include "tests/audio/player.h"
#include "tests/support/temporary_folder.h"

namespace headphones_test {

using namespace aula;
using namespace aula::test;

namespace {

using Channels = std::vector<std::vector<float>>;

/// Sound files of a test.
struct Files {
    std::filesystem::path write(const Channels& channels, double rate_hz = kRate_hz) const {
        const auto file = folder.path() / "headphones.wav";
        WavWriter writer(file, rate_hz, channels.size(), SampleFormat::float32);
        std::vector<float> interleaved;
        for (std::size_t n = 0; n < channels[0].size(); ++n)
            for (const auto& channel : channels) interleaved.push_back(channel[n]);
        writer.write(interleaved);
        writer.commit();
        return file;
    }

    std::shared_ptr<const HeadphoneFilter> read(const Channels& channels, double from_hz = kRate_hz,
                                                double to_hz = kRate_hz) const {
        return read_headphones(write(channels, from_hz), to_hz);
    }

    TemporaryFolder folder;
};

std::vector<float> convolved(const std::vector<float>& a, const std::vector<float>& b) {
    std::vector<double> sum(a.size() + b.size() - 1);
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t k = 0; k < b.size(); ++k) sum[i + k] += double{a[i]} * double{b[k]};
    return {sum.begin(), sum.end()};
}

double largest_difference(std::span<const float> a, std::span<const float> b) {
    REQUIRE(a.size() == b.size());
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(largest, std::abs(double{a[i]} - double{b[i]}));
    return largest;
}

std::complex<double> transfer(const std::vector<float>& response, double frequency_hz,
                              double rate_hz) {
    std::complex<double> sum;
    for (std::size_t n = 0; n < response.size(); ++n)
        sum += double{response[n]} * std::polar(1.0, -2 * std::numbers::pi * frequency_hz /
                                                         rate_hz * static_cast<double>(n));
    return sum;
}

/// The largest deviation of the gain from that of a unit impulse, 50 Hz to 18 kHz, dB.
double gain_error_db(const std::vector<float>& response, double rate_hz) {
    double largest_db = 0;
    for (double f = 50; f < 18000; f *= 1.05)
        largest_db = std::max(largest_db,
                              std::abs(20 * std::log10(std::abs(transfer(response, f, rate_hz)))));
    return largest_db;
}

double delay_s(const std::vector<float>& response, double rate_hz) {
    constexpr double kTone_hz = 50;  // the delays are less than half a period
    return -std::arg(transfer(response, kTone_hz, rate_hz)) / (2 * std::numbers::pi * kTone_hz);
}

}  // namespace

TEST_CASE("Headphones convolve each ear with its channel of the file") {
    const Files files;
    const Signals filter = random_signals(2, 1500, 3);
    const Signals ears = random_signals(2, 4000, 4);
    // Rounding: sums of 1500 products of unit variance in single precision.
    constexpr double kTolerance = 1e-3;
    SECTION("of two channels, in calls of any size") {
        HeadphoneEqualizer equalizer(*files.read({filter[0], filter[1]}), 256);
        Signals out = ears;
        for (std::size_t done = 0, turn = 0; done < out[0].size(); ++turn) {
            const std::size_t samples =
                std::min(std::array<std::size_t, 3>{256, 1, 77}[turn % 3], out[0].size() - done);
            equalizer.process(std::array{out[0].data() + done, out[1].data() + done},
                              static_cast<int>(samples));
            done += samples;
        }
        for (std::size_t e = 0; e < 2; ++e) {
            auto expected = convolved(ears[e], filter[e]);
            expected.resize(out[e].size());
            CHECK(largest_difference(out[e], expected) < kTolerance);
        }
    }
    SECTION("of one channel for both") {
        Channels response = ears;
        equalize(*files.read({filter[0]}), response);
        for (std::size_t e = 0; e < 2; ++e)
            CHECK(largest_difference(response[e], convolved(ears[e], filter[0])) < kTolerance);
    }
    SECTION("of one sample of 1, which changes nothing") {
        Channels response = ears;
        equalize(*files.read({{1, 0, 0}}), response);
        for (std::size_t e = 0; e < 2; ++e) CHECK(largest_difference(response[e], ears[e]) < 1e-5);
    }
}

TEST_CASE("Headphones of another sample rate have the levels and the times of the file") {
    const Files files;
    for (const auto& [from_hz, to_hz] : {std::pair(44100.0, 48000.0),
                                         {48000.0, 44100.0},
                                         {96000.0, 48000.0},
                                         {44100.0, 96000.0}}) {
        CAPTURE(from_hz, to_hz);
        // As of filters of minimum phase. The tolerance is the ringing below -60 dB.
        std::vector<float> abrupt(64);
        abrupt[0] = 1;
        const auto filter = files.read({abrupt}, from_hz, to_hz);
        CHECK(gain_error_db(filter->ears[0], to_hz) < 0.05);
        CHECK(delay_s(filter->ears[0], to_hz) >= 0);
        CHECK(delay_s(filter->ears[0], to_hz) < 88 / std::min(from_hz, to_hz));
        // Companion: without the ringing before it the gain is wrong.
        const auto peak = std::max_element(filter->ears[0].begin(), filter->ears[0].end());
        CHECK(gain_error_db({peak, filter->ears[0].end()}, to_hz) > 0.1);

        // As measured responses, which have a delay: 300 and 303 samples.
        Channels late(2, std::vector<float>(400));
        late[0][300] = 0.5F;
        late[1][303] = 0.5F;
        const auto delayed = files.read(late, from_hz, to_hz);
        for (std::size_t e = 0; e < 2; ++e) {
            const double expected_s = (300.0 + 3.0 * static_cast<double>(e)) / from_hz;
            const double error_s = delay_s(delayed->ears[e], to_hz) - expected_s;
            // Time 0 of the file becomes a whole sample.
            CHECK(std::abs(error_s) < 1 / to_hz);
        }
        CHECK(delay_s(delayed->ears[1], to_hz) - delay_s(delayed->ears[0], to_hz) ==
              Approx(3 / from_hz).margin(1e-7));
    }
}

TEST_CASE("Files that are no filter of headphones are refused") {
    const Files files;
    const auto refused = [&](const Channels& channels, const char* part) {
        CHECK_THROWS_WITH(files.read(channels), Catch::Contains(part));
    };
    refused(Channels(3, {1, 0}), "has 3 channels; expected 1 for both ears, or 2");
    refused({std::vector<float>(100)}, "is silent; expected an impulse response");
    std::vector<float> lengthy(static_cast<std::size_t>(4.1 * kRate_hz));
    lengthy.back() = 1;
    refused({lengthy}, "at most 4 s");
    refused({{1, 2e6F}}, "expected a whole impulse response");
    CHECK_THROWS_AS(read_headphones(files.folder.path() / "none.wav", kRate_hz), InputError);
    // Zeros at the end are no part of it.
    lengthy.back() = 0;
    lengthy[2] = 1;
    CHECK(files.read({lengthy})->taps() == 3);
}

}  // namespace headphones_test
