#include "apps/session/player.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "audio/error.h"
#include "audio/sound_file.h"
#include "tests/support/jack_server.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"
#include "tests/support/tone.h"
#include "tests/support/wait.h"

namespace {

using namespace aula;
using namespace aula::test;

/// The share of a recording's energy that is off the tone, its ends faded so that they count for
/// nothing.
double share_off_tone_within(std::vector<float> samples) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double swell = std::sin(std::numbers::pi * static_cast<double>(i) /
                                      static_cast<double>(samples.size()));
        samples[i] *= static_cast<float>(swell * swell);
    }
    return share_off_tone(samples);
}

}  // namespace

TEST_CASE("What plays live is changed without a click; a change that fails leaves it playing") {
    const JackServer server(256);
    if (!server.running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    const TemporaryFolder folder;
    Scene scene = small_room();
    scene.simulation.rays = 100;
    SessionOptions options;
    options.output = OutputFormat::mono;
    options.duration_s = 1000;
    Player player(scene, options);
    std::vector<float> tone(48);
    for (std::size_t i = 0; i < tone.size(); ++i)
        tone[i] =
            static_cast<float>(0.1 * std::sin(2 * std::numbers::pi * static_cast<double>(i) / 48));
    player.play_signal(0, std::make_shared<const Signal>(tone, true));
    player.measure_loudness();
    CHECK(player.view() == nullptr);
    player.watch(ViewRequest{.lines = 10, .patches = true});
    REQUIRE(comes([&] { return player.view() && player.view()->frame > 10; }));
    CHECK(player.view()->lines.size() == 10);
    CHECK_FALSE(player.view()->patches.empty());

    const auto file = folder.path() / "heard.wav";
    player.record(file);
    scene.simulation.estimator = Estimator::dpc;
    const auto first = player.change(scene, options);
    REQUIRE(comes([&] { return player.status().heard_change == first; }));
    CHECK(comes([&] { return player.view()->simulation.estimator == Estimator::dpc; }));
    scene.materials[0].absorption = Bands::filled(0.8F);
    const auto second = player.change(scene, options);
    PlayControls controls;
    controls.sources.resize(1);
    controls.sources[0].gain_db = -6;
    controls.early = false;
    player.control(controls);
    REQUIRE(comes([&] { return player.status().heard_change == second; }));

    Scene wrong = scene;
    wrong.simulation.rays = 0;
    player.change(wrong, options);
    REQUIRE(comes([&] { return !player.status().change_error.empty(); }));
    CHECK(player.status().heard_change == second);
    const auto frames = player.status().frames;
    CHECK(comes([&] { return player.status().frames > frames + 5; }));
    player.stop_recording();

    // All fades, and gains, from frame to frame: -60 dB is the requirement; a hard cut of the sound
    // is at -40 dB or above.
    CHECK(share_off_tone_within(read_sound(file, kRate_hz).samples) < 1e-6);

    const auto third = player.change(free_field({2, 0, 0}), options, true);
    REQUIRE(comes([&] { return player.status().heard_change == third; }));
    CHECK_FALSE(player.controls().sources.size() == 1);  // as the new scene has it
    CHECK(player.status().change_error.empty());
    CHECK(comes([&] { return player.status().sources[0] == Vec3(2, 0, 0); }));
}
