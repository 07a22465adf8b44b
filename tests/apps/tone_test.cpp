#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "apps/session/session.h"
#include "audio/sound_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace aula;

constexpr double kRate_hz = 48000;
constexpr double kTone_hz = 1000;

/// A second of a tone that swells from nothing and dies away, so that its spectrum is narrow.
std::vector<float> tone() {
    std::vector<float> samples(48000);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double t = static_cast<double>(i) / kRate_hz;
        const double swell = std::sin(std::numbers::pi * t);
        samples[i] =
            static_cast<float>(0.1 * swell * swell * std::sin(2 * std::numbers::pi * kTone_hz * t));
    }
    return samples;
}

/// Energy of a signal that begins and ends in silence within +-200 Hz of the tone, by its DFT.
double energy_near_tone(const std::vector<float>& samples) {
    const auto n = static_cast<double>(samples.size());
    double energy = 0;
    const auto first = static_cast<int>(std::ceil((kTone_hz - 200) / kRate_hz * n));
    const auto last = static_cast<int>(std::floor((kTone_hz + 200) / kRate_hz * n));
    for (int bin = first; bin <= last; ++bin) {
        // Goertzel: one multiplication a sample.
        const double w = 2 * std::numbers::pi * bin / n;
        const double twice_cos = 2 * std::cos(w);
        double s1 = 0;
        double s2 = 0;
        for (const float x : samples) {
            const double s = static_cast<double>(x) + twice_cos * s1 - s2;
            s2 = s1;
            s1 = s;
        }
        energy += 2 / n * (s1 * s1 + s2 * s2 - twice_cos * s1 * s2);
    }
    return energy;
}

double share_off_tone(const std::vector<float>& samples) {
    double total = 0;
    for (const float x : samples) total += static_cast<double>(x) * static_cast<double>(x);
    return (total - energy_near_tone(samples)) / total;
}

}  // namespace

TEST_CASE("A tone stays a tone while the listener walks and turns: nothing clicks") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "tone.wav";
    {
        WavWriter writer(file, kRate_hz, 1, SampleFormat::float32);
        writer.write(tone());
        writer.commit();
    }
    Scene scene = test::small_room();
    scene.sources[0].signal = Source::Signal::file;
    scene.sources[0].signal_file = file;
    scene.simulation.rays = 200;
    Pose there = scene.listener.pose;
    there.position.x -= 1.5F;
    there.yaw_rad = 1.5F;
    scene.listener.path = Path{{{0, scene.listener.pose}, {1, there}}, false};
    for (const OutputFormat output : {OutputFormat::mono, OutputFormat::binaural}) {
        const auto out = folder.path() / "out.wav";
        SessionOptions options;
        options.output = output;
        REQUIRE(Session(scene, options).render(out));
        const double share = share_off_tone(read_sound(out, kRate_hz).samples);
        INFO("off the tone: " << 10 * std::log10(share) << " dB");
        // The requirement is -60 dB; a click of one block's length would be at -40 dB or above.
        CHECK(share < 1e-6);
    }

    // The companion: a bump of a millisecond, a tenth of the tone high, is found.
    auto clicking = tone();
    for (std::size_t i = 24000; i < 24048; ++i) clicking[i] += 0.01F;
    CHECK(share_off_tone(tone()) < 1e-6);
    CHECK(share_off_tone(clicking) > 1e-6);
}
