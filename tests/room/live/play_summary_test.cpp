#include "apps/room/live/play_summary.h"

#include <catch2/catch.hpp>
#include <string>

#include "apps/room/base/latency.h"

using namespace aula;

TEST_CASE("A quantile of durations exists if there are durations") {
    LatencyCounts counts;
    CHECK_FALSE(counts.quantile_ms(0.5));
    counts.add(2'000'000);
    // Rounded up to a step of 0.1 ms.
    REQUIRE(counts.quantile_ms(0.5));
    CHECK(*counts.quantile_ms(0.5) == Approx(2.1));
}

TEST_CASE("The summary has no latency where none was measured") {
    PoseLatency latency;
    latency.frame_period_ms = 20;
    CHECK(latency_summary(latency) ==
          "pose to sound p50 - p99 - (frame period 20.0 ms, compute p50 - p99 -), head rotation "
          "p50 - p99 -, callback interval p99 -");
    latency.sound_p50_ms = 0.1;
    latency.sound_p99_ms = 31.5;
    CHECK(latency_summary(latency).find("pose to sound p50 0.1 ms p99 31.5 ms (") == 0);
}

TEST_CASE("The summary counts late and skipped frames") {
    PlayStatus status;
    status.time_s = 1.5;
    status.frames = 4;
    status.late_frames = 3;
    status.skipped_frames = 28;
    CHECK(play_summary(status).find(
              "played 1.5 s, underruns 0, frames 4 (3 late, 28 skipped), frame mean") == 0);
}
