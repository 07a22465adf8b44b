#include "apps/room/frames/signals.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "aula/audio/sound_file.h"
#include "tests/support/temporary_folder.h"

namespace signals_test {

namespace {

using aula::Signal;
using aula::Source;

Source source(Source::Signal signal, bool loop) {
    Source s;
    s.signal = signal;
    s.loop = loop;
    return s;
}

std::vector<float> read(const Signal& signal, std::int64_t first, std::size_t count) {
    std::vector<float> samples(count, -1.0F);
    signal.read(first, first, samples);
    return samples;
}

constexpr double kRate_hz = 48000;

}  // namespace

TEST_CASE("An impulse is one unit sample at time 0") {
    const Signal impulse(source(Source::Signal::impulse, false), kRate_hz, 1);
    REQUIRE(impulse.length_samples() == 1);
    REQUIRE_FALSE(impulse.cycle_samples());
    const auto samples = read(impulse, 0, 96001);
    REQUIRE(samples[0] == 1);
    for (std::size_t i = 1; i < samples.size(); ++i) REQUIRE(samples[i] == 0);
}

TEST_CASE("A looped impulse repeats each second") {
    const Signal impulse(source(Source::Signal::impulse, true), kRate_hz, 1);
    REQUIRE_FALSE(impulse.length_samples());
    REQUIRE(impulse.cycle_samples() == 48000);
    const auto samples = read(impulse, 47990, 48020);
    for (std::size_t i = 0; i < samples.size(); ++i)
        REQUIRE(samples[i] == ((i == 10 || i == 48010) ? 1 : 0));
}

TEST_CASE("Noise is the same for any division into blocks") {
    const Signal noise(source(Source::Signal::noise, false), kRate_hz, 7);
    REQUIRE_FALSE(noise.length_samples());
    const auto whole = read(noise, 0, 1000);
    const auto part = read(noise, 300, 256);
    for (std::size_t i = 0; i < part.size(); ++i) REQUIRE(part[i] == whole[300 + i]);
}

TEST_CASE("Noise is white at -20 dBFS") {
    const Signal noise(source(Source::Signal::noise, false), kRate_hz, 7);
    constexpr std::size_t kCount = 480000;
    const auto samples = read(noise, 0, kCount);
    double sum = 0;
    double squares = 0;
    double neighbours = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
        const auto x = static_cast<double>(samples[i]);
        sum += x;
        squares += x * x;
        if (i > 0) neighbours += x * static_cast<double>(samples[i - 1]);
    }
    // Statistical, four standard errors, the seed is fixed. The mean of n uniform numbers of RMS s
    // has the standard error s / sqrt(n); their mean square s^2 sqrt(0.8 / n), as the fourth
    // moment of a uniform distribution is 1.8 s^4; the product of neighbours s^2 / sqrt(n).
    const double n = kCount;
    REQUIRE(sum / n == Approx(0).margin(4 * 0.1 / std::sqrt(n)));
    REQUIRE(squares / n == Approx(0.01).margin(4 * 0.01 * std::sqrt(0.8 / n)));
    REQUIRE(neighbours / n == Approx(0).margin(4 * 0.01 / std::sqrt(n)));
    // Companion: a level 0.1 dB higher is detected.
    REQUIRE(squares / n * 1.0233 != Approx(0.01).margin(4 * 0.01 * std::sqrt(0.8 / n)));
}

TEST_CASE("The noises of two sources of a scene are independent") {
    aula::Scene scene;
    scene.sources = {source(Source::Signal::noise, false), source(Source::Signal::noise, false)};
    const auto signals = aula::read_signals(scene, kRate_hz);
    constexpr std::size_t kCount = 48000;
    const auto a = read(*signals[0], 0, kCount);
    const auto b = read(*signals[1], 0, kCount);
    double product = 0;
    double own = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
        product += static_cast<double>(a[i]) * static_cast<double>(b[i]);
        own += static_cast<double>(a[i]) * static_cast<double>(a[i]);
    }
    // Four standard errors of the mean product; a signal with itself fails.
    const double margin = 4 * 0.01 / std::sqrt(static_cast<double>(kCount));
    REQUIRE(product / kCount == Approx(0).margin(margin));
    REQUIRE(own / kCount != Approx(0).margin(margin));
}

TEST_CASE("Noise and a truncated sound begin abruptly, and silence and an onset do not") {
    std::vector<float> wave(4800);
    std::vector<float> cut(4800);
    for (std::size_t i = 0; i < wave.size(); ++i) {
        wave[i] = static_cast<float>(std::sin(0.05 * static_cast<double>(i)));
        cut[i] = static_cast<float>(std::cos(0.05 * static_cast<double>(i)));
    }
    std::vector<float> knock(4800);
    for (std::size_t i = 0; i < knock.size(); ++i)
        knock[i] = static_cast<float>(std::exp(-0.02 * static_cast<double>(i)));
    CHECK(Signal(cut, true).begins_abruptly());
    CHECK(Signal(std::vector<float>(48, 0.1F), true).begins_abruptly());
    CHECK(Signal(source(Source::Signal::noise, false), kRate_hz, 1).begins_abruptly());
    CHECK_FALSE(Signal(wave, true).begins_abruptly());
    CHECK_FALSE(Signal(knock, false).begins_abruptly());
    CHECK_FALSE(Signal(std::vector<float>{1}, false).begins_abruptly());
    CHECK_FALSE(Signal(std::vector<float>(48, 0.0F), true).begins_abruptly());
    for (const bool loop : {false, true})
        CHECK_FALSE(Signal(source(Source::Signal::impulse, loop), kRate_hz, 1).begins_abruptly());
}

TEST_CASE("Sources that play the same file share its samples, and its warnings are given once") {
    const aula::test::TemporaryFolder folder;
    const std::vector<float> stereo(200, 0.5F);
    for (const char* name : {"a.wav", "b.wav"}) {
        aula::WavWriter file(folder.path() / name, kRate_hz, 2, aula::SampleFormat::float32);
        file.write(stereo);
        file.commit();
    }
    aula::Scene scene;
    for (const char* name : {"a.wav", "b.wav", "./a.wav"}) {
        scene.sources.push_back(source(Source::Signal::file, true));
        scene.sources.back().signal_file = folder.path() / name;
    }
    scene.sources.push_back(scene.sources[0]);
    scene.sources.back().loop = false;
    const auto signals = aula::read_signals(scene, kRate_hz);
    CHECK(signals[0] == signals[2]);
    CHECK(signals[0] != signals[1]);
    CHECK(signals[3]->length_samples() == 100);
    CHECK_FALSE(signals[0]->length_samples());
    CHECK(warnings_of(signals).size() == 2);
}

TEST_CASE("Sources that play the same sound inside a model share its samples") {
    const aula::test::TemporaryFolder folder;
    aula::WavWriter file(folder.path() / "a.wav", kRate_hz, 1, aula::SampleFormat::float32);
    file.write(std::vector<float>(100, 0.5F));
    file.commit();
    std::filesystem::rename(folder.path() / "a.wav", folder.path() / "sound.bin");
    const auto bytes = std::filesystem::file_size(folder.path() / "sound.bin");
    folder.write("room.gltf",
                 R"({"asset": {"version": "2.0"}, "extensions": {"KHR_audio_emitter":
                     {"audio": [{"bufferView": 0}, {"bufferView": 0}]}},
                     "buffers": [{"uri": "sound.bin", "byteLength": )" +
                     std::to_string(bytes) + R"(}], "bufferViews": [{"buffer": 0, "byteLength": )" +
                     std::to_string(bytes) + "}]}");
    aula::Scene scene;
    for (const char* name : {"room.gltf#0", "./room.gltf#0", "room.gltf#1"}) {
        scene.sources.push_back(source(Source::Signal::file, false));
        scene.sources.back().signal_file = folder.path() / name;
    }
    const auto signals = aula::read_signals(scene, kRate_hz);
    CHECK(signals[0]->length_samples() == 100);
    CHECK(signals[0] == signals[1]);
    CHECK(signals[0] != signals[2]);
}

}  // namespace signals_test
