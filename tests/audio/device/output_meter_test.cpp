#include "aula/devices/output_meter.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <vector>

using namespace aula;

TEST_CASE(
    "A late callback is attributed to rendering if it computed long, otherwise to scheduling") {
    constexpr double kSound_s = 256.0 / 48000;
    struct Case {
        double wall;  // re the duration of the block
        double cpu;
        std::optional<UnderrunCause> cause;
    };
    const Case c = GENERATE(Case{0.9, 0.9, std::nullopt}, Case{0.99, 0.1, std::nullopt},
                            Case{1.1, 1.05, UnderrunCause::rendering},
                            // Partly not scheduled, but computing for more than half of the block.
                            Case{1.3, 0.6, UnderrunCause::rendering},
                            Case{1.1, 0.1, UnderrunCause::scheduling},
                            Case{20, 0.4, UnderrunCause::scheduling});
    CAPTURE(c.wall, c.cpu);
    CHECK(lateness_cause(c.wall * kSound_s, c.cpu * kSound_s, kSound_s) == c.cause);
}

TEST_CASE("An underrun after callbacks in time is attributed to the sound system") {
    // One hour per sample: every callback is in time.
    OutputMeter meter(1.0 / 3600);
    meter.begin(false);
    meter.end(256);
    meter.begin(true);
    meter.end(256);
    CHECK(meter.underruns() == 1);
    CHECK(meter.rendering_underruns() == 0);
    REQUIRE(meter.first_underruns().size() == 1);
    CHECK(meter.first_underruns()[0].cause == UnderrunCause::sound_system);
    CHECK(meter.first_underruns()[0].time_s == Approx(256 * 3600.0));
}

TEST_CASE("An underrun after a callback that computed too long is attributed to rendering") {
    // A sample is shorter than any callback.
    OutputMeter meter(1e15);
    meter.begin(false);
    meter.end(1);
    meter.begin(true);
    meter.end(1);
    REQUIRE(meter.first_underruns().size() == 1);
    CHECK(meter.first_underruns()[0].cause == UnderrunCause::rendering);
    CHECK(meter.rendering_underruns() == 1);
}

TEST_CASE(
    "An underrun shortly after a callback that was not scheduled is attributed to scheduling") {
    constexpr double kRate_hz = 48000;
    constexpr int kBlock = 256;
    constexpr double kSound_s = kBlock / kRate_hz;
    OutputMeter meter(kRate_hz);
    meter.count_call(1.5 * kSound_s, 0.1 * kSound_s, kBlock);
    meter.begin(true);
    // An underrun reported more than 0.2 s later has another cause.
    for (int call = 0; call < 40; ++call) meter.count_call(0.1 * kSound_s, 0.1 * kSound_s, kBlock);
    meter.begin(true);
    REQUIRE(meter.first_underruns().size() == 2);
    CHECK(meter.first_underruns()[0].cause == UnderrunCause::scheduling);
    CHECK(meter.first_underruns()[1].cause == UnderrunCause::sound_system);
    CHECK(meter.rendering_underruns() == 0);
    CHECK(meter.worst_load() == Approx(1.5));
}

TEST_CASE("The load of a block longer than the smoothing time is not averaged") {
    OutputMeter meter(8000);
    meter.count_call(0.9, 0.9, 8000);
    CHECK(meter.load() == Approx(0.9));  // exact but for rounding
    meter.count_call(0.3, 0.3, 8000);
    CHECK(meter.load() == Approx(0.3));
}

TEST_CASE("A gap is attributed to the preceding late callback for any block duration") {
    // 1.02 s: the server reports the gap at the next callback, after more than 0.2 s.
    constexpr int kBlock = 8192;
    constexpr double kSound_s = kBlock / 8000.0;
    OutputMeter meter(8000);
    meter.count_call(1.1 * kSound_s, 1.05 * kSound_s, kBlock);
    meter.begin(true);
    REQUIRE(meter.first_underruns().size() == 1);
    CHECK(meter.first_underruns()[0].cause == UnderrunCause::rendering);
}

TEST_CASE(
    "The mean load is the time of all callbacks re that of the sound, the worst one's its own") {
    OutputMeter meter(1000);
    CHECK(meter.mean_load() == 0);
    CHECK(meter.worst_load() == 0);
    meter.count_call(0.05, 0.05, 100);
    meter.count_call(0.08, 0.01, 100);
    meter.count_call(0.02, 0.02, 200);
    CHECK(meter.mean_load() == Approx(0.15 / 0.4));
    CHECK(meter.worst_load() == Approx(0.8));
    CHECK(meter.underruns() == 0);
}

TEST_CASE("The load follows a change within half a second, by 1 - 1 / e") {
    OutputMeter meter(48000);
    for (int call = 0; call < 400; ++call) meter.count_call(0.8 * 0.005, 0, 240);
    CHECK(meter.load() == Approx(0.8).epsilon(0.02));  // e^-4 = 0.018
    for (int call = 0; call < 100; ++call) meter.count_call(0.2 * 0.005, 0, 240);
    // (1 - 0.01)^100 of the step remains, 0.995 / e, and 0.018 of the first one.
    CHECK(meter.load() == Approx(0.2 + 0.6 * std::pow(0.99, 100)).epsilon(0.02));
    CHECK(meter.mean_load() == Approx(0.68));
    CHECK(meter.worst_load() == Approx(0.8));
}

TEST_CASE("After late callbacks of both kinds a gap is the program's fault") {
    constexpr double kSound_s = 256.0 / 48000;
    for (const bool ours_first : {false, true}) {
        OutputMeter meter(48000);
        for (const bool ours : {ours_first, !ours_first})
            meter.count_call(2 * kSound_s, (ours ? 1.5 : 0.1) * kSound_s, 256);
        meter.begin(true);
        CAPTURE(ours_first);
        CHECK(meter.rendering_underruns() == 1);
        CHECK(meter.underruns() == 1);
    }
}

TEST_CASE("A gap is attributed to a late callback up to 0.2 s after it") {
    // Blocks of 10 ms.
    const auto cause_after = [](int blocks) {
        OutputMeter meter(48000);
        meter.count_call(0.02, 0.02, 480);
        for (int block = 0; block < blocks; ++block) meter.count_call(0.001, 0.001, 480);
        meter.begin(true);
        return meter.first_underruns().at(0).cause;
    };
    // The late callback began its block at time 0, the gap is reported after blocks + 1 of them.
    CHECK(cause_after(0) == UnderrunCause::rendering);
    CHECK(cause_after(19) == UnderrunCause::rendering);
    CHECK(cause_after(20) == UnderrunCause::sound_system);
}

TEST_CASE("All underruns are counted, the first 64 are kept with their times") {
    OutputMeter meter(1000);
    for (int call = 0; call < 100; ++call) {
        meter.begin(true);
        meter.count_call(0.001, 0.001, 250);
    }
    CHECK(meter.underruns() == 100);
    const std::vector<Underrun> kept = meter.first_underruns();
    REQUIRE(kept.size() == 64);
    for (std::size_t i = 0; i < kept.size(); ++i) {
        CHECK(kept[i].time_s == Approx(0.25 * static_cast<double>(i)));
        CHECK(kept[i].cause == UnderrunCause::sound_system);
    }
}

TEST_CASE("The time without callbacks starts anew with each callback and with touch()") {
    OutputMeter meter(48000);
    // Since the epoch of the clock: the machine has run longer than a second.
    CHECK(meter.silence() > std::chrono::seconds(1));
    meter.touch();
    CHECK(meter.silence() < std::chrono::seconds(1));
    OutputMeter called(48000);
    called.begin(false);
    called.end(64);
    CHECK(called.silence() < std::chrono::seconds(1));
    CHECK(called.silence() >= std::chrono::seconds(0));
}
