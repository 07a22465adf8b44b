#include "apps/room/live/player.h"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "apps/room/live/reduction_reporter.h"
#include "aula/audio/sound_file.h"
#include "aula/devices/device.h"
#include "aula/exception.h"
#include "tests/support/jack_server.h"
#include "tests/support/program.h"
#include "tests/support/pulse_server.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"
#include "tests/support/tone.h"
#include "tests/support/wait.h"

namespace {

using namespace aula;
using namespace aula::test;

/// The share of a recording's energy outside the tone, with faded ends.
double share_off_tone_within(std::vector<float> samples) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double swell = std::sin(std::numbers::pi * static_cast<double>(i) /
                                      static_cast<double>(samples.size()));
        samples[i] *= static_cast<float>(swell * swell);
    }
    return share_off_tone(samples);
}

/// A room whose frames take longer than 5 ms on any machine, which gives neither rays nor length.
Scene heavy_room() {
    Scene scene = small_room();
    scene.simulation.ir_length_s.reset();
    scene.materials[0].absorption = Bands::filled(0.1F);
    scene.simulation.rays = 5000;
    scene.simulation.frame_rate_hz = 200;
    return scene;
}

/// Mono output on the silent device, for a long time.
PlaybackOptions silent() {
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    options.device = AudioDevice::kNone;
    options.duration_s = 1000;
    return options;
}

/// While it exists, no thread can be started: a stack would exceed the address space.
class NoNewThreads {
 public:
    NoNewThreads() {
        pthread_getattr_default_np(&before_);
        pthread_attr_t huge;
        pthread_attr_init(&huge);
        pthread_attr_setstacksize(&huge, std::size_t{1} << 47);
        pthread_setattr_default_np(&huge);
        pthread_attr_destroy(&huge);
    }
    ~NoNewThreads() {
        pthread_setattr_default_np(&before_);
        pthread_attr_destroy(&before_);
    }
    NoNewThreads(const NoNewThreads&) = delete;
    NoNewThreads& operator=(const NoNewThreads&) = delete;

 private:
    pthread_attr_t before_;
};

}  // namespace

TEST_CASE(
    "A scene that is too heavy plays with fewer rays and a shorter response until frames are in "
    "time") {
    Scene scene = heavy_room();
    PlaybackOptions options = silent();
    options.rays_fall = true;
    Player player(scene, options);
    REQUIRE(eventually([&] { return player.status().rays < 5000; }));
    CHECK(player.status().full_rays == 5000);
    CHECK(reduction_text(player.status()).find("of 5000 rays") != std::string::npos);
    // A value chosen by the user is kept.
    PlayControls controls;
    controls.rays = 4000;
    player.control(controls);
    REQUIRE(eventually([&] { return player.status().rays == 4000; }));
    CHECK(player.status().full_rays == 4000);
    REQUIRE(eventually([&] {
        const PlayStatus status = player.status();
        return status.response_length_s < 0.7 * status.full_response_length_s;
    }));
    CHECK(player.status().rays == 4000);
    // Another scene begins with its full rays and response length.
    scene.simulation.ir_length_s = 0.5F;
    const auto change = player.change(scene, options, true);
    REQUIRE(eventually([&] {
        const PlayStatus status = player.status();
        return status.audible_change >= change && status.response_length_s > 0.45 &&
               status.response_length_s == status.full_response_length_s;
    }));
}

TEST_CASE("A response that could not be shortened is shortened later") {
    Scene scene = heavy_room();
    PlaybackOptions options = silent();
    Player player(scene, options);
    {
        const NoNewThreads no_threads;
        REQUIRE(eventually([&] { return player.status().failed_changes > 0; }));
        CHECK_FALSE(player.status().change_error.empty());
        const PlayStatus status = player.status();
        CHECK(status.response_length_s == status.full_response_length_s);
    }
    CHECK(eventually([&] {
        const PlayStatus status = player.status();
        return status.response_length_s < 0.7 * status.full_response_length_s;
    }));
    CHECK(player.status().change_error.empty());
}

TEST_CASE("The first frame of a change has the rays that the change gives") {
    Scene scene = heavy_room();
    PlaybackOptions options = silent();
    options.rays_fall = true;
    Player player(scene, options);
    REQUIRE(eventually([&] { return player.status().rays < 5000; }));
    scene.simulation.frame_rate_hz = 0.02F;  // the first frame remains the newest
    options.rays_fall = false;
    const auto change = player.change(scene, options);
    REQUIRE(eventually([&] { return player.status().audible_change == change; }));
    CHECK(player.status().rays == 5000);
}

TEST_CASE("Of many rays that may fall the first frame has as many as by default") {
    Scene scene = heavy_room();
    scene.simulation.frame_rate_hz = 0.02F;  // the first frame remains the newest
    PlaybackOptions options = silent();
    options.rays_fall = true;
    Player player(scene, options);
    REQUIRE(eventually([&] { return player.status().frames > 0; }));
    CHECK(player.status().rays == Simulation::kRays);
    CHECK(player.status().full_rays == 5000);
}

TEST_CASE("A live input is read without a gap during a change") {
    const Scene scene = free_field({1, 0, 0});
    Player player(scene, silent());
    std::atomic<std::int64_t> end = -1;  // of the samples read, without a gap
    std::atomic<int> gaps = 0;
    const auto read = [&](std::int64_t position, std::span<float> out) {
        std::fill(out.begin(), out.end(), 0.1F);
        const std::int64_t read_to = end;
        if (read_to >= 0 && position > read_to) ++gaps;
        end = std::max(read_to, position + static_cast<std::int64_t>(out.size()));
    };
    player.play_signal(0, std::make_shared<const Signal>(LiveInput(read)));
    REQUIRE(eventually([&] { return end > 0; }));
    Scene warm = scene;
    warm.medium.temperature_c += 1;
    const auto change = player.change(warm, silent());
    REQUIRE(eventually([&] { return player.status().audible_change == change; }));
    const std::int64_t begun = end;
    // Longer than the fade between the playbacks and the ringing of the previous one.
    CHECK(eventually([&] { return end > begun + 2 * 48000; }));
    CHECK(gaps == 0);
    // Another scene plays its own signals: the input is no longer read.
    const auto anew = player.change(scene, silent(), true);
    REQUIRE(eventually([&] { return player.status().audible_change == anew; }));
    CHECK(eventually([&] {
        const std::int64_t before = end;
        const double time_s = player.status().time_s;
        return eventually([&] { return player.status().time_s > time_s + 0.1; }) && end == before;
    }));
}

TEST_CASE(
    "Changes during the loss of a device are heard when it returns, a new scene from its start") {
    PulseServer server;
    if (!server.running()) {
        WARN("skipped: no PulseAudio server can run here");
        return;
    }
    const auto devices = list_output_devices();
    if (std::none_of(devices.begin(), devices.end(),
                     [](const DeviceInfo& device) { return device.name == "pulse"; })) {
        WARN("skipped: ALSA knows no PulseAudio here (libasound2-plugins)");
        return;
    }
    Scene scene = free_field({1, 0, 0});
    PlaybackOptions options = silent();
    options.device = "pulse";
    Player player(scene, options);
    REQUIRE(eventually([&] { return player.status().time_s > 0.5 && player.status().frames > 3; }));
    server.kill();
    REQUIRE(eventually([&] { return player.status().device == DeviceState::lost; }));
    const double lost_s = player.status().time_s;
    player.status();  // resets the peak
    // The second change replaces the first one before the sound continues.
    const auto anew = player.change(scene, options, true);
    REQUIRE(eventually([&] { return player.status().audible_change == anew; }));
    scene.medium.temperature_c += 1;
    const auto next = player.change(scene, options);
    REQUIRE(eventually([&] { return player.status().audible_change == next; }));
    CHECK(player.status().peak == 0);
    CHECK(player.status().time_s == lost_s);
    CHECK(player.status().scene_time_s == 0);
    server.restart();
    REQUIRE(server.running());
    // The only sample of the signal is the first one of the scene.
    float peak = 0;
    CHECK(eventually([&] {
        const PlayStatus status = player.status();
        peak = std::max(peak, status.peak);
        return status.device == DeviceState::playing && status.scene_time_s > 0.3;
    }));
    CHECK(peak > 0.01F);
    CHECK(player.status().reconnects == 1);
    const auto frames = player.status().frames;
    CHECK(eventually([&] { return player.status().frames > frames + 5; }));
    CHECK(player.status().change_error.empty());
}

TEST_CASE("A player goes on at the rate with which its device returns") {
    auto server = std::make_unique<JackServer>(256);
    if (!server->running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    const TemporaryFolder folder;
    const auto sound = folder.path() / "tone.wav";
    {
        std::vector<float> tone(48000);  // 1 kHz
        for (std::size_t i = 0; i < tone.size(); ++i)
            tone[i] = static_cast<float>(
                0.1 * std::sin(2 * std::numbers::pi * static_cast<double>(i) / 48));
        WavWriter writer(sound, 48000, 1, SampleFormat::float32);
        writer.write(tone);
        writer.commit();
    }
    Scene scene = free_field({1, 0, 0});
    scene.sources[0].signal = Source::Signal::file;
    scene.sources[0].signal_file = sound;
    scene.sources[0].loop = true;
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    options.duration_s = 1000;
    Player player(scene, options);
    REQUIRE(eventually([&] { return player.status().time_s > 0.5; }));
    CHECK(player.status().sample_rate_hz == 48000);
    const auto before = folder.path() / "before.wav";
    player.record(before);
    REQUIRE(eventually([&] { return player.monitor_status().recorded_s > 0.2; }));
    server.reset();
    REQUIRE(eventually([&] { return player.status().device == DeviceState::lost; }));
    const double lost_s = player.status().time_s;
    const auto frames = player.status().frames;
    server = std::make_unique<JackServer>(512, 2, 44100);
    REQUIRE(server->running());
    REQUIRE(eventually([&] {
        const PlayStatus status = player.status();
        return status.device == DeviceState::playing && status.time_s > lost_s + 0.2;
    }));
    CHECK(player.status().sample_rate_hz == 44100);
    CHECK(player.sample_rate_hz() == 44100);
    CHECK(player.status().reconnects == 1);
    CHECK(player.status().frames > frames);
    CHECK_FALSE(player.monitor_status().recording);
    CHECK_FALSE(player.monitor_status().error.empty());
    CHECK(sound_info(before).sample_rate_hz == 48000);

    const auto after = folder.path() / "after.wav";
    player.record(after);
    REQUIRE(eventually([&] { return player.monitor_status().recorded_s > 0.5; }));
    player.stop_recording();
    CHECK(sound_info(after).sample_rate_hz == 44100);
    const std::vector<float> heard = read_sound(after, 44100).samples;
    std::size_t periods = 0;
    for (std::size_t i = 1; i < heard.size(); ++i)
        if (heard[i - 1] < 0 && heard[i] >= 0) ++periods;
    // A tone of 1 kHz still: 48000 samples played at 44.1 kHz would have 919 Hz. One more or less
    // of 500 periods.
    CHECK(static_cast<double>(periods) / (static_cast<double>(heard.size()) / 44100) ==
          Approx(1000).epsilon(0.005));
    // Changes and the server's next loss are made at the new rate.
    const auto change = player.change(scene, options);
    CHECK(eventually([&] { return player.status().audible_change == change; }));
    CHECK(player.status().sample_rate_hz == 44100);
    CHECK(player.status().change_error.empty());
}

TEST_CASE("A player does not reduce given rays and a given response length") {
    Scene scene = small_room();
    scene.simulation.rays = 3000;
    scene.simulation.frame_rate_hz = 1000;
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    options.device = AudioDevice::kNone;
    options.duration_s = 1000;
    Player player(scene, options);
    REQUIRE(eventually([&] { return player.status().frames > 30; }));
    // 3000 rays take longer than 1 ms: nearly all frames are late, and frame times are skipped.
    const PlayStatus late = player.status();
    CHECK(2 * late.late_frames > late.frames);
    CHECK(late.late_frames <= late.frames);
    CHECK(late.skipped_frames > 0);
    CHECK(player.status().rays == 3000);
    CHECK(player.status().response_length_s == player.status().full_response_length_s);
    CHECK(reduction_text(player.status()).empty());
    CHECK(player.status().audible_change == 0);
}

TEST_CASE(
    "Changes during live playback do not click, and after a failed change playback continues") {
    const JackServer server(256);
    if (!server.running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    const TemporaryFolder folder;
    Scene scene = small_room();
    scene.simulation.rays = 100;
    PlaybackOptions options;
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
    REQUIRE(eventually([&] { return player.view() && player.view()->frame > 10; }));
    CHECK(player.view()->lines.size() == 10);
    CHECK_FALSE(player.view()->patches.empty());

    const auto file = folder.path() / "heard.wav";
    player.record(file);
    scene.simulation.estimator = Estimator::dpc;
    const auto first = player.change(scene, options);
    REQUIRE(eventually([&] { return player.status().audible_change == first; }));
    CHECK(eventually([&] { return player.view()->simulation.estimator == Estimator::dpc; }));
    scene.materials[0].absorption = Bands::filled(0.8F);
    const auto second = player.change(scene, options);
    PlayControls controls;
    controls.sources.resize(1);
    controls.sources[0].gain_db = -6;
    controls.early = false;
    player.control(controls);
    REQUIRE(eventually([&] { return player.status().audible_change == second; }));

    Scene wrong = scene;
    wrong.simulation.rays = 0;
    player.change(wrong, options);
    REQUIRE(eventually([&] { return !player.status().change_error.empty(); }));
    CHECK(player.status().audible_change == second);
    const auto frames = player.status().frames;
    CHECK(eventually([&] { return player.status().frames > frames + 5; }));
    player.stop_recording();

    // All fades, and gains that change from frame to frame: the requirement is -60 dB; a hard cut
    // is at -40 dB or above.
    CHECK(share_off_tone_within(read_sound(file, kRate_hz).samples) < 1e-6);

    const auto third = player.change(free_field({2, 0, 0}), options, true);
    REQUIRE(eventually([&] { return player.status().audible_change == third; }));
    CHECK_FALSE(player.controls().sources.size() == 1);  // those of the new scene
    CHECK(player.status().change_error.empty());
    CHECK(eventually([&] { return player.status().sources[0] == Vec3(2, 0, 0); }));
}

TEST_CASE("On the silent device frames follow the playback time and the listener its path") {
    constexpr double kSpeed_m_s = 1;
    Scene scene = small_room();
    scene.simulation.rays = 50;
    scene.simulation.frame_rate_hz = 50;
    const Pose begin{{1, 1, 1.2F}};
    Pose end = begin;
    end.position.x = 3;
    scene.listener.path = Trajectory{{{0, begin}, {2 / kSpeed_m_s, end}}, false};
    scene.sources[0].signal = Source::Signal::noise;
    scene.sources[0].loop = true;
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    options.device = AudioDevice::kNone;
    options.duration_s = 1000;
    Player player(scene, options);
    CHECK(player.device().name == AudioDevice::kNone);
    // With any load of the machine, each frame time is computed or counted as skipped, except those
    // played while the status is made and the frame ahead.
    const auto off_frames = [&] {
        const double before_s = player.status().time_s;
        const PlayStatus status = player.status();
        const double after_s = player.status().time_s;
        const auto frames = static_cast<double>(status.frames + status.skipped_frames);
        return std::max({frames - 50 * after_s, 50 * before_s - frames, 0.0});
    };
    for (const double time_s : {0.3, 1.0, 1.5}) {
        REQUIRE(eventually([&] { return player.status().time_s >= time_s; }));
        // The first frame is computed before the sound begins, the newest up to a frame ahead.
        // Frames follow the sound, played in blocks of 256, within three frames.
        CHECK(eventually([&] { return off_frames() < 4; }));
        // The listener is on the path at the frame's time, one or two frames behind.
        CHECK(eventually([&] {
            const PlayStatus status = player.status();
            const double walked_s = (double{status.listener.position.x} - 1) / kSpeed_m_s;
            return std::abs(status.scene_time_s - walked_s) < 4.0 / 50;
        }));
    }
    // Companion: frames counted at another rate deviate far more.
    CHECK(player.status().frames + player.status().skipped_frames > 45);
    // The path ends, and frames continue as long as the sound.
    REQUIRE(eventually([&] { return player.status().listener.position.x == 3.0F; }));
    const auto frames = player.status().frames;
    CHECK(eventually([&] { return player.status().frames > frames + 5; }));
    // Changes take effect there as well.
    const auto change = player.change(free_field({2, 0, 0}), options, true);
    REQUIRE(eventually([&] { return player.status().audible_change == change; }));
    CHECK(eventually([&] { return player.status().sources[0] == Vec3(2, 0, 0); }));
    CHECK(player.status().scene_time_s < player.status().time_s - 1);
    CHECK(player.status().underruns == 0);
    CHECK(player.status().device == DeviceState::playing);
}

TEST_CASE("On the silent device playback ends after its duration") {
    Scene scene = free_field({1, 0, 0});
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    options.device = AudioDevice::kNone;
    options.duration_s = 0.3;
    Player player(scene, options);
    CHECK(eventually([&] { return player.status().finished; }));
    CHECK(player.status().time_s == Approx(0.3));
    // The last frame times may be counted slightly later.
    CHECK(eventually([&] { return player.status().frames + player.status().skipped_frames >= 9; }));
}

TEST_CASE("Changes in quick succession between two frames play, and poses turn what rings out") {
    Scene scene = free_field({1, 0, 0});
    scene.sources[0].signal = Source::Signal::noise;
    scene.sources[0].gain_db = 150;          // the format allows 200; the limiter holds the output
    scene.simulation.frame_rate_hz = 0.02F;  // no frame between the changes
    PlaybackOptions options;
    options.device = "none";
    options.duration_s = 1000;
    Player player(scene, options);
    // More than the mailbox of the mixer circulates.
    for (int i = 0; i < 9; ++i) {
        scene.medium.temperature_c += 1;
        const auto change = player.change(scene, options);
        REQUIRE(eventually([&] { return player.status().audible_change == change; }));
        player.move_listener({.position = {0, static_cast<float>(i) * 0.01F, 0}});
    }
    CHECK(player.status().change_error.empty());
}
