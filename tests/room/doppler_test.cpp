#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "apps/room/offline/offline.h"
#include "aula/audio/sound_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"
#include "tests/support/tone.h"

namespace {

using namespace aula;

using test::kRate_hz;
using test::kTone_hz;

constexpr double kSound_m_s = 343.2;
constexpr double kDuration_s = 1.4;

/// Poses along x from one end to the other.
Trajectory along_x(float from_m, float to_m) {
    Pose from;
    Pose to;
    from.position = {from_m, 0, 0};
    to.position = {to_m, 0, 0};
    return {{{0, from}, {kDuration_s, to}}, false};
}

/// The deviation of the tone's pitch in a scene from `expected_hz`, up to 10 Hz, in cents: by the
/// phase in two windows of 0.1 s, at 1 s.
double deviation_cents(Scene scene, double expected_hz) {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "tone.wav";
    std::vector<float> tone(static_cast<std::size_t>(kDuration_s * kRate_hz));
    for (std::size_t n = 0; n < tone.size(); ++n)
        tone[n] = static_cast<float>(
            std::sin(2 * std::numbers::pi * kTone_hz * static_cast<double>(n) / kRate_hz));
    WavWriter writer(file, kRate_hz, 1, SampleFormat::float32);
    writer.write(tone);
    writer.commit();
    scene.sources[0].signal = Source::Signal::file;
    scene.sources[0].signal_file = file;
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    options.duration_s = kDuration_s;
    const auto out = folder.path() / "out.wav";
    REQUIRE(render_offline(scene, options, out));
    const std::vector<float> samples = read_sound(out, kRate_hz).samples;
    constexpr std::size_t kWindow = 4800;
    const auto phase = [&](std::size_t first) {
        std::complex<double> sum = 0;
        for (std::size_t n = 0; n < kWindow; ++n) {
            const double hann =
                1 - std::cos(2 * std::numbers::pi * static_cast<double>(n) / kWindow);
            sum += hann * double{samples[first + n]} *
                   std::polar(1.0, -2 * std::numbers::pi * expected_hz *
                                       static_cast<double>(first + n) / kRate_hz);
        }
        return std::arg(sum);
    };
    constexpr std::size_t kFirst = 48000 - kWindow;
    constexpr std::size_t kApart = 2400;
    const double cycles = (phase(kFirst + kApart) - phase(kFirst)) / (2 * std::numbers::pi);
    const double heard_hz = expected_hz + (cycles - std::round(cycles)) * kRate_hz / kApart;
    return 1200 * std::log2(heard_hz / expected_hz);
}

}  // namespace

TEST_CASE("The pitch of a moving source is that of Doppler's formula within 1 cent up to 50 m/s") {
    for (const float speed_m_s : {1.5F, 30.0F, 50.0F, -30.0F, -50.0F}) {
        // To the listener, or away from it; at least 10 m away.
        const float travelled_m = speed_m_s * static_cast<float>(kDuration_s);
        Scene scene = test::free_field({0, 0, 0});
        scene.sources[0].path =
            speed_m_s > 0 ? along_x(-travelled_m - 10, -10) : along_x(-10, -10 + travelled_m);
        const double expected_hz = kTone_hz / (1 - double{speed_m_s} / kSound_m_s);
        CAPTURE(speed_m_s);
        CHECK(std::abs(deviation_cents(scene, expected_hz)) < 1);
    }
}

TEST_CASE("A moving listener has the other pitch of Doppler's formula") {
    Scene scene = test::free_field({0, 0, 0});
    scene.listener.path = along_x(-38, -10);  // 20 m/s
    CHECK(std::abs(deviation_cents(scene, kTone_hz * (1 + 20 / kSound_m_s))) < 1);
    // Companion: it is 6 cents below that of a source of this speed.
    CHECK(std::abs(deviation_cents(scene, kTone_hz / (1 - 20 / kSound_m_s))) > 5);
}
