#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "apps/room/offline/offline.h"
#include "audio/file/headphone_file.h"
#include "aula/audio/sound_file.h"
#include "aula/exception.h"
#include "aula/measurement.h"
#include "tests/room/auralizer/auralizer_rendering.h"
#include "tests/support/temporary_folder.h"

namespace room_headphones_test {

using namespace aula;
using namespace aula::test;

namespace {

using Channels = std::vector<std::vector<float>>;

/// A filter of both ears that differ, with a delay of 300 samples.
std::filesystem::path write_headphones(const TemporaryFolder& folder) {
    const auto file = folder.path() / "headphones.wav";
    std::vector<float> interleaved(2 * std::size_t{700});
    for (std::size_t n = 300; n < 700; ++n) {
        const float decay = std::exp(-static_cast<float>(n - 300) / 60);
        interleaved[2 * n] = 0.5F * decay;
        interleaved[2 * n + 1] = (n % 2 == 0 ? 0.25F : -0.25F) * decay;
    }
    WavWriter writer(file, kRate_hz, 2, SampleFormat::float32);
    writer.write(interleaved);
    writer.commit();
    return file;
}

Channels offline(const Scene& scene, const PlaybackOptions& options) {
    OfflineRendering rendering(scene, read_signals(scene, options.sample_rate_hz), options);
    Channels channels(2);
    rendering.render([&](std::span<const std::span<const float>> block) {
        for (std::size_t c = 0; c < 2; ++c)
            channels[c].insert(channels[c].end(), block[c].begin(), block[c].end());
    });
    return channels;
}

/// The largest difference re the largest sample of `b`; `a` may be shorter.
double difference(const Channels& a, const Channels& b) {
    double largest = 0;
    double peak = 0;
    for (std::size_t c = 0; c < a.size(); ++c) {
        REQUIRE(a[c].size() <= b[c].size());
        for (std::size_t n = 0; n < b[c].size(); ++n) {
            const double sample = n < a[c].size() ? double{a[c][n]} : 0;
            largest = std::max(largest, std::abs(sample - double{b[c][n]}));
            peak = std::max(peak, std::abs(double{b[c][n]}));
        }
    }
    return largest / peak;
}

// Rounding: sums of 700 products in single precision, in transforms of another division.
constexpr double kRounding = 1e-5;

}  // namespace

TEST_CASE("A rendering for headphones is the plain one through their filter, and as much longer") {
    const TemporaryFolder folder;
    const auto file = write_headphones(folder);
    const auto filter = read_headphones(file, kRate_hz);
    Scene scene = small_room();
    scene.simulation.rays = 50;
    // The listener turns: the filter follows the ears.
    Pose turned = scene.listener.pose;
    turned.yaw_rad = 2;
    scene.listener.path = Trajectory{{{0, scene.listener.pose}, {0.3, turned}}, false};
    PlaybackOptions options;
    Channels plain = offline(scene, options);
    options.headphones = file;
    const Channels heard = offline(scene, options);
    CHECK(heard[0].size() == plain[0].size() + filter->taps() - 1);
    const Channels unfiltered = plain;
    equalize(*filter, plain);
    CHECK(difference(heard, plain) < kRounding);
    // Companion.
    CHECK(difference(unfiltered, plain) > 0.1);
}

TEST_CASE("Impulse responses for headphones contain their filter, measured and played") {
    const TemporaryFolder folder;
    const auto file = write_headphones(folder);
    const auto filter = read_headphones(file, kRate_hz);
    Scene scene = small_room();
    scene.simulation.rays = 50;
    const auto measurement = measure(scene, {.frames = 2, .parameters = false});
    OutputOptions options{.output = OutputFormat::binaural};
    Channels plain = ImpulseResponses(*measurement, options).response(0);
    options.headphones = file;
    const Channels measured = ImpulseResponses(*measurement, options).response(0);
    equalize(*filter, plain);
    CHECK(measured[0].size() == plain[0].size());
    CHECK(difference(measured, plain) < kRounding);

    // Files that are gone have been read.
    const OutputResources output(options, "output");
    std::filesystem::rename(file, folder.path() / "gone.wav");
    CHECK_THROWS_AS(ImpulseResponses(*measurement, options), InputError);
    CHECK(responses_with(*measurement, output).response(0) == measured);
    std::filesystem::rename(folder.path() / "gone.wav", file);

    const auto played = [&](const std::filesystem::path& headphones) {
        AuralizerOptions playing;
        playing.clock = RenderClock::exact;
        playing.headphones = headphones;
        Auralizer auralizer(scene, playing);
        rendered(auralizer, 2000, {256}, tone_at);
        const Channels response = auralizer.impulse_response(auralizer.sources()[0]);
        CHECK(auralizer.heard_length_s() ==
              Approx(static_cast<double>(response[0].size()) / kRate_hz).margin(1 / kRate_hz));
        CHECK(static_cast<double>(auralizer.tail_samples()) >
              auralizer.heard_length_s() * kRate_hz);
        return response;
    };
    Channels unfiltered = played({});
    equalize(*filter, unfiltered);
    CHECK(difference(played(file), unfiltered) < kRounding);
}

TEST_CASE("The limit of the memory of a room includes its headphones") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "long.wav";
    constexpr std::size_t kTaps = 180'000;
    WavWriter writer(file, kRate_hz, 1, SampleFormat::float32);
    writer.write(std::vector<float>(kTaps, 1e-3F));
    writer.commit();
    const auto taken_bytes = [&](const std::filesystem::path& headphones) {
        AuralizerOptions options;
        options.headphones = headphones;
        options.listeners = 2;
        options.max_memory_bytes = 1;
        try {
            const Auralizer auralizer(small_room(), options);
        } catch (const InputError& error) {
            const std::string text = error.what();
            return std::stoull(text.substr(text.find("take ") + 5));
        }
        FAIL("accepted");
        return 0ULL;
    };
    const auto more_bytes = static_cast<double>(taken_bytes(file) - taken_bytes({}));
    // Spectra of the filter and of the past, two floats per tap each; for each ear of two
    // listeners. Measured: 16.3.
    CHECK(more_bytes / (2 * 2 * kTaps) == Approx(16.3).epsilon(0.1));
}

TEST_CASE("Headphones are refused for other outputs than binaural") {
    AuralizerOptions options = mono();
    options.headphones = "headphones.wav";
    CHECK_THROWS_WITH(Auralizer(small_room(), options),
                      Catch::Contains("headphones are for binaural output"));
    const auto measurement = measure(small_room(), {.frames = 1, .parameters = false});
    CHECK_THROWS_WITH(ImpulseResponses(*measurement, {.output = OutputFormat::mono,
                                                      .headphones = "headphones.wav"}),
                      Catch::Contains("headphones are for binaural output"));
}

}  // namespace room_headphones_test
