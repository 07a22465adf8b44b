#include "apps/room/live/live_mixer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/live_take.h"
#include "tests/support/test_scenes.h"
#include "tests/support/tone.h"

namespace {

using namespace aula;
using test::kRate_hz;
using test::kTakeBlock;
using test::LiveTake;
using test::share_off_tone;

constexpr int kSecond_blocks = 188;

PlaybackOptions mono() {
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    return options;
}

/// The room, in which a tone with a sin^2 envelope of a second plays. `start`: of the playback
/// before.
std::unique_ptr<PreparedScene> tone_in(const LiveTake& live, const Scene& scene,
                                       bool starts_anew = false, std::uint64_t start = 0) {
    Reusable before;
    before.sources = scene.sources;
    before.signals = {std::make_shared<const Signal>(test::tone(), false)};
    before.start = start;
    return live.prepare(scene, mono(), starts_anew, before);
}

Scene dry_room() {
    Scene scene = test::small_room();
    scene.simulation.rays = 100;
    return scene;
}

}  // namespace

TEST_CASE("A tone has no clicks while estimator, order, materials and source change") {
    LiveTake live;
    std::vector<std::unique_ptr<PreparedScene>> all;
    Scene scene = dry_room();
    const auto change = [&] {
        all.push_back(tone_in(live, scene));
        live.begin(*all.back());
    };
    const auto output = live.take(2 * kSecond_blocks, [&](int block) {
        if (block == 0) change();
        if (block == 50) {
            scene.simulation.estimator = Estimator::dpc;
            change();
        }
        if (block == 75) {
            scene.simulation.order = 1;
            scene.materials[0].absorption = Bands::filled(0.9F);
            change();
        }
        if (block == 79) {  // while the previous one fades in
            scene.sources[0].position.x += 1;
            change();
        }
        if (block == 81) {  // while that one waits
            scene.simulation.estimator = Estimator::pt;
            change();
        }
    });
    const double share = share_off_tone(output);
    INFO("off the tone: " << 10 * std::log10(share) << " dB");
    // The requirement is -60 dB; a click of one block's length would be at -40 dB or above.
    CHECK(share < 1e-6);

    // Companion: the same changes as a hard cut from one room to another.
    LiveTake other;
    auto room = tone_in(other, scene);
    const auto after = other.take(2 * kSecond_blocks, [&](int block) {
        if (block == 0) other.begin(*room);
    });
    auto cut = output;
    std::copy(after.begin() + 24000, after.end(), cut.begin() + 24000);
    CHECK(share_off_tone(cut) > 1e-6);
}

TEST_CASE("A switch to the same scene is inaudible: both playbacks add up") {
    const Scene scene = test::free_field({3, 0, 0});
    const auto output = [&](bool changes) {
        LiveTake live;
        std::vector<std::unique_ptr<PreparedScene>> all;
        return live.take(kSecond_blocks, [&](int block) {
            // A playback that begins anew: later ones continue in its time.
            const bool anew = block == 40;
            if (block == 0 || anew || (changes && (block == 80 || block == 110))) {
                all.push_back(tone_in(live, scene, anew, all.empty() ? 0 : all.back()->start));
                live.begin(*all.back());
            }
        });
    };
    const auto through = output(false);
    const auto changed = output(true);
    const float loudest = *std::max_element(through.begin(), through.end());
    REQUIRE(loudest > 0.02F);
    double worst = 0;
    for (std::size_t i = 0; i < through.size(); ++i)
        worst = std::max(worst, static_cast<double>(std::abs(through[i] - changed[i])));
    // Rounding: transforms and filters of single precision, some hundred operations of 6e-8.
    CHECK(worst < 2e-5 * static_cast<double>(loudest));
}

TEST_CASE("A scene begins anew even if another change replaces the one that should begin it") {
    const Scene scene = test::free_field({3, 0, 0});
    const auto output = [&](bool replaced) {
        LiveTake live;
        std::vector<std::unique_ptr<PreparedScene>> all;
        return live.take(kSecond_blocks, [&](int block) {
            if (block != 0 && block != 100) return;
            all.push_back(tone_in(live, scene, block == 100));
            live.begin(*all.back());
            if (block == 0 || !replaced) return;
            // Nothing is rendered in between, as while the device is lost.
            all.push_back(tone_in(live, scene, false, all.back()->start));
            live.begin(*all.back());
        });
    };
    const auto anew = output(false);
    CHECK(output(true) == anew);
    // Companion: the tone that continues differs from the one that begins anew.
    LiveTake live;
    auto through = tone_in(live, scene);
    CHECK(live.take(kSecond_blocks, [&](int block) {
        if (block == 0) live.begin(*through);
    }) != anew);
}

TEST_CASE("A signal that begins abruptly or continues fades in, and an onset is unchanged") {
    struct Case {
        int start_block;
        bool anew;
        bool onset;           ///< a unit sample, otherwise a truncated wave
        double rise_samples;  ///< 0: immediately
    };
    const Case c =
        GENERATE(Case{0, false, false, 960}, Case{20, true, false, 960},
                 Case{20, false, false, 2400}, Case{0, false, true, 0}, Case{20, true, true, 0});
    CAPTURE(c.start_block, c.anew, c.onset);
    const Scene scene = test::free_field({1, 0, 0});
    Reusable before;
    before.sources = scene.sources;
    std::vector<float> wave(48, 0.1F);
    if (c.onset) {
        wave.assign(12000, 0.0F);
        wave[0] = 0.1F;
    }
    before.signals = {std::make_shared<const Signal>(wave, true)};
    LiveTake live;
    const auto room = live.prepare(scene, mono(), c.anew, before);
    const auto output = live.take(c.start_block + 70, [&](int block) {
        if (block == c.start_block) live.begin(*room);
    });
    // A metre away, and the limiter's delay: 140 and 207 samples.
    constexpr std::size_t kLate = 347;
    const auto start = static_cast<std::size_t>(c.start_block * kTakeBlock) + kLate;
    if (c.onset) {
        // The first of two is as large as the second. Rounding: some hundred operations of 6e-8.
        const auto peak = [&](std::size_t at) {
            float max = 0;
            for (std::size_t i = at - 100; i < at + 100; ++i)
                max = std::max(max, std::abs(output[i]));
            return double{max};
        };
        CHECK(peak(start) > 0.01);
        CHECK(peak(start) == Approx(peak(start + wave.size())).epsilon(2e-5));
        return;
    }
    const float size = std::abs(output.back());
    REQUIRE(size > 0.05F);
    bool above = false;
    bool near = false;
    for (std::size_t i = 0; start + i < output.size(); ++i) {
        // Filters ring before their peak by a millisecond.
        const double position = std::min(1.0, (static_cast<double>(i) + 48) / c.rise_samples);
        const double max = double{size} * (0.5 - 0.5 * std::cos(std::numbers::pi * position));
        above = above || double{std::abs(output[start + i])} > 1.02 * max + 1e-6;
        // Companion: the rise is not much later either.
        near = near || (position < 0.7 && double{std::abs(output[start + i])} > 0.8 * max);
    }
    CHECK_FALSE(above);
    CHECK(near);
}

TEST_CASE("Sound emitted by an old playback is audible to its end at any distance") {
    // Over 100 m sound travels for 0.29 s, much longer than the reverberation.
    Scene scene = test::free_field({100, 0, 0});
    scene.simulation.ir_length_s = 0.1F;
    const auto output = [&](bool changes) {
        LiveTake live;
        std::vector<std::unique_ptr<PreparedScene>> all;
        return live.take(2 * kSecond_blocks, [&](int block) {
            if (block == 0 || (changes && block == 80)) {
                all.push_back(tone_in(live, scene));
                live.begin(*all.back());
            }
        });
    };
    const auto through = output(false);
    const auto changed = output(true);
    const float loudest = *std::max_element(through.begin(), through.end());
    REQUIRE(loudest > 0.0005F);
    double worst = 0;
    for (std::size_t i = 0; i < through.size(); ++i)
        worst = std::max(worst, static_cast<double>(std::abs(through[i] - changed[i])));
    // Rounding: transforms and filters of single precision, some hundred operations of 6e-8.
    CHECK(worst < 2e-5 * static_cast<double>(loudest));
}

TEST_CASE("A requested duration of half a second is exact and ends without a click") {
    const Scene scene = dry_room();
    const auto output = [&](std::optional<double> duration_s) {
        PlaybackOptions options = mono();
        options.duration_s = duration_s;
        Reusable before;
        before.sources = scene.sources;
        before.signals = {std::make_shared<const Signal>(test::tone(), false)};
        LiveTake live;
        const auto room = live.prepare(scene, options, true, before);
        return live.take(kSecond_blocks, [&](int block) {
            if (block == 0) live.begin(*room);
        });
    };
    const auto through = output(1000);
    const auto ended = output(0.5);
    // The output is delayed by the limiter.
    constexpr std::size_t kDelay = 207;
    constexpr std::size_t kEnd = 24000 + kDelay;
    CHECK(std::equal(ended.begin(), ended.begin() + kEnd - 960, through.begin()));
    CHECK(std::all_of(ended.begin() + kEnd, ended.end(), [](float x) { return x == 0; }));
    CHECK(share_off_tone(ended) < 1e-6);
    // Companion: the other one continued; cut there, it clicks.
    auto cut = through;
    std::fill(cut.begin() + kEnd, cut.end(), 0.0F);
    CHECK(cut != through);
    CHECK(share_off_tone(cut) > 1e-6);
}

TEST_CASE("Samples that are not finite are muted and counted, and later ones are audible") {
    LiveTake live;
    const Scene scene = test::free_field({1, 0, 0});
    // A tone with 10 ms of NaN.
    std::vector<float> tone = test::tone();
    std::fill(tone.begin() + 9600, tone.begin() + 10080, std::numeric_limits<float>::quiet_NaN());
    Reusable before;
    before.sources = scene.sources;
    before.signals = {std::make_shared<const Signal>(tone, false)};
    const auto prepared = live.prepare(scene, mono(), false, before);
    const auto output = live.take(kSecond_blocks, [&](int block) {
        if (block == 0) live.begin(*prepared);
    });
    CHECK(live.auralizer().room().status().muted_samples == 480);
    CHECK(std::all_of(output.begin(), output.end(), [](float x) { return std::isfinite(x); }));
    CHECK(std::any_of(output.begin() + 24000, output.end(), [](float x) { return x != 0; }));
}

TEST_CASE("A mixer that begins later continues the signals at their place") {
    const Scene scene = test::free_field({1, 0, 0});
    const auto play = [&](LiveTake& live, std::uint64_t start, int blocks) {
        const auto prepared = tone_in(live, scene, false, start);
        return live.take(blocks, [&](int block) {
            if (block == 0) live.begin(*prepared);
        });
    };
    LiveTake whole;
    const auto expected = play(whole, 0, kSecond_blocks);
    constexpr int kBegin = 60;  // blocks
    constexpr double kBegin_s = kBegin * kTakeBlock / kRate_hz;
    LiveTake later(kBegin_s, {.number = 3, .zero = 0});
    const auto continued = play(later, 3, kSecond_blocks - kBegin);
    CHECK(later.mixer().time_s() == kSecond_blocks * kTakeBlock / kRate_hz);
    // After the fade-in of 50 ms, the delay of 1 m and the latency of the limiter, to the bit.
    const auto from = static_cast<std::ptrdiff_t>(0.06 * kRate_hz);
    CHECK(std::equal(continued.begin() + from, continued.end(),
                     expected.begin() + kBegin * kTakeBlock + from));
    // Companion: signals of another start begin with the playback.
    LiveTake other(kBegin_s, {.number = 3, .zero = 0});
    const auto begun = play(other, 4, kSecond_blocks - kBegin);
    CHECK(std::equal(begun.begin() + from, begun.end(), expected.begin() + from));
}

TEST_CASE("Samples that are not read in time are counted as lost") {
    LiveTake live;
    live.begin(*tone_in(live, test::free_field({1, 0, 0})));
    live.mixer().listen(true);
    // Two seconds of 96000 samples fit, rounded up to a power of two: 131072, or 512 blocks.
    live.take(520, [](int) {});
    CHECK(live.mixer().lost_samples() == 8 * kTakeBlock);
}

TEST_CASE("Of many changes in a row the last is played, and all playbacks are returned") {
    LiveTake live;
    Scene scene = test::free_field({1, 0, 0});
    scene.simulation.ir_length_s = 0.3F;
    std::vector<std::unique_ptr<PreparedScene>> all;
    constexpr int kChanges = 30;
    const auto output = live.take(3 * kSecond_blocks, [&](int block) {
        if (block < kChanges) {
            scene.sources[0].position.x = block + 1 < kChanges ? 1.0F : 2.0F;
            Reusable before;
            before.sources = scene.sources;
            before.signals = {std::make_shared<const Signal>(std::vector<float>(48, 0.1F), true)};
            all.push_back(live.prepare(scene, mono(), false, before));
            live.begin(*all.back());
        }
    });
    // A frame frees what has rung out; then the prepared scene alone holds the signal.
    live.auralizer().compute_first(live.mixer().time_s());
    CHECK(std::count_if(all.begin(), all.end(), [](const auto& prepared) {
              return prepared->signals[0].use_count() == 1;
          }) == kChanges - 1);
    // A constant at 2 m, half of its value at 1 m.
    LiveTake near;
    Scene one = scene;
    one.sources[0].position.x = 1;
    Reusable before;
    before.sources = one.sources;
    before.signals = {std::make_shared<const Signal>(std::vector<float>(48, 0.1F), true)};
    const auto alone = near.prepare(one, mono(), false, before);
    const auto reference = near.take(kSecond_blocks, [&](int block) {
        if (block == 0) near.begin(*alone);
    });
    // 0.1 dB: rounding in the design of the filters.
    CHECK(static_cast<double>(output.back()) ==
          Approx(static_cast<double>(reference.back()) / 2).epsilon(0.0116));
}

TEST_CASE("A new signal of a playing source fades in") {
    LiveTake live;
    const Scene scene = test::free_field({1, 0, 0});
    auto prepared = tone_in(live, scene);
    // A quarter of a period later: the same tone with another phase.
    std::vector<float> other = test::tone();
    std::rotate(other.begin(), other.begin() + 12, other.end());
    const auto output = live.take(2 * kSecond_blocks, [&](int block) {
        if (block == 0) live.begin(*prepared);
        if (block != 80) return;
        prepared->playback.signals().publish(
            std::make_unique<SignalSet>(SignalSet{std::make_shared<const Signal>(other, false)}));
    });
    CHECK(share_off_tone(output) < 1e-6);
    // A metre away, 140 samples later: the output at the end is the other tone.
    double difference = 0;
    double energy = 0;
    for (std::size_t i = 36000; i < 44000; ++i) {
        const double expected = static_cast<double>(other[i - 140]);
        difference += std::pow(static_cast<double>(output[i + 207]) - expected, 2);
        energy += expected * expected;
    }
    // The delay of 139.86 samples and the limiter's of 207: 0.14 samples are 0.018 of a radian.
    CHECK(difference < 0.03 * 0.03 * energy);
}

TEST_CASE("A pause fades to silence, stops the time and fades back without a click") {
    LiveTake live;
    auto prepared = tone_in(live, test::free_field({1, 0, 0}));
    double paused_at_s = 0;
    const auto output = live.take(2 * kSecond_blocks, [&](int block) {
        if (block == 0) live.begin(*prepared);
        if (block == 90) live.mixer().pause(true);
        if (block == 110) {
            CHECK(live.mixer().silent());
            paused_at_s = live.mixer().time_s();
        }
        if (block == 140) {
            CHECK(live.mixer().time_s() == paused_at_s);
            live.mixer().pause(false);
        }
    });
    CHECK(share_off_tone(output) < 1e-6);
    CHECK(std::all_of(output.begin() + 110 * kTakeBlock, output.begin() + 140 * kTakeBlock,
                      [](float x) { return x == 0; }));
    CHECK(std::any_of(output.begin() + 145 * kTakeBlock, output.begin() + 160 * kTakeBlock,
                      [](float x) { return std::abs(x) > 0.01F; }));
    // Companion: the same tone cut off without a fade.
    std::vector<float> cut = output;
    std::fill(cut.begin() + 80 * kTakeBlock, cut.begin() + 140 * kTakeBlock, 0.0F);
    CHECK(share_off_tone(cut) > 1e-6);
}
