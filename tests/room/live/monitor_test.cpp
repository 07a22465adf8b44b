#include "apps/room/live/monitor.h"

#include <catch2/catch.hpp>

#include "aula/exception.h"
#include "tests/support/live_take.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"
#include "tests/support/tone.h"

using namespace aula;
using namespace aula::test;

namespace {

/// Begins a scene in which noise plays.
void begin(LiveTake& live, double sample_rate_hz) {
    Scene scene = free_field({1, 0, 0});
    scene.sources[0].signal = Source::Signal::noise;
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    options.sample_rate_hz = sample_rate_hz;
    live.begin(*live.prepare(scene, options));
}

}  // namespace

TEST_CASE("A recording contains every output sample of its time") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "heard.wav";
    LiveTake live;
    begin(live, kRate_hz);
    Monitor monitor(live.mixer(), kRate_hz);
    CHECK_THROWS_AS(monitor.record(folder.path() / "no folder" / "heard.wav"), InputError);
    std::size_t begun = 0;
    const auto heard = live.take(100, [&](int block) {
        if (block == 10) {
            monitor.record(file);
            begun = static_cast<std::size_t>(block) * kTakeBlock;
        }
        if (block == 90) monitor.stop_recording();
    });
    const auto recorded = read_sound(file, kRate_hz).samples;
    REQUIRE(recorded.size() == 80 * kTakeBlock);
    // Exact: the samples themselves, as float.
    CHECK(std::equal(recorded.begin(), recorded.end(),
                     heard.begin() + static_cast<std::ptrdiff_t>(begun)));
    const MonitorStatus status = monitor.status();
    CHECK_FALSE(status.recording);
    CHECK(status.error.empty());
    CHECK(status.loudness.true_peak > 0.05);
    CHECK(names_in(folder.path()).size() == 1);
}

TEST_CASE("Recorded and lost samples of a recording sum to all output samples") {
    const TemporaryFolder folder;
    LiveTake live;
    begin(live, kRate_hz);
    Monitor monitor(live.mixer(), kRate_hz);
    // Faster than it is read, unless the machine is very slow.
    constexpr int kBlocks = 4000;
    live.take(kBlocks, [&](int block) {
        if (block == 0) monitor.record(folder.path() / "heard.wav");
    });
    monitor.stop_recording();
    const MonitorStatus status = monitor.status();
    CHECK(status.recorded_s + status.lost_s == Approx(kBlocks * kTakeBlock / kRate_hz));
}

TEST_CASE("A recording ends with an error when the monitor follows a mixer of another rate") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "heard.wav";
    LiveTake live;
    begin(live, kRate_hz);
    LiveTake other;
    begin(other, 44100);
    Monitor monitor(live.mixer(), kRate_hz);
    live.take(20, [&](int block) {
        if (block == 0) monitor.record(file);
    });
    monitor.follow(other.mixer(), 44100);
    CHECK_FALSE(monitor.status().recording);
    CHECK(monitor.status().error.find("sample rate") != std::string::npos);
    CHECK(sound_info(file).samples == 20 * kTakeBlock);
    CHECK(sound_info(file).sample_rate_hz == kRate_hz);
    // The next one has the new rate.
    const auto next = folder.path() / "next.wav";
    other.take(10, [&](int block) {
        if (block == 0) monitor.record(next);
    });
    monitor.stop_recording();
    CHECK(monitor.status().error.empty());
    CHECK(sound_info(next).samples == 10 * kTakeBlock);
    CHECK(sound_info(next).sample_rate_hz == 44100);
}
