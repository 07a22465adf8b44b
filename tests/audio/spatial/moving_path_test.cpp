#include "audio/spatial/moving_path.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "audio/spatial/hrtf.h"
#include "tests/audio/convolution/signals.h"
#include "tests/audio/player.h"

namespace moving_path_test {

using namespace aula;
using namespace aula::test;

namespace {

std::shared_ptr<const Hrtf> kemar() {
    static const auto hrtf = std::make_shared<const Hrtf>("", kRate_hz);
    return hrtf;
}

/// Three seconds of motion at 1.5 m/s away from a reflection, mono.
Signal walk_from_reflection(std::uint64_t id, double frequency_hz) {
    constexpr std::size_t kSamples = 144000;
    Player player(config_for(OutputFormat::mono), nullptr,
                  {sine(frequency_hz, kSamples, kRate_hz)});
    for (unsigned frame = 0; player.done() < kSamples; ++frame) {
        SourceSound sound;
        sound.early = {path_of((5 + 1.5 * frame / 30) / kSpeed_m_s * kRate_hz, 0.2F)};
        sound.early[0].id = id;
        player.publish({sound});
        player.play_until(std::min<std::size_t>(kSamples, (frame + 1) * 1600));
    }
    return {player.output(0).begin() + 9600, player.output(0).end()};
}

/// A head turned to the left by `yaw` radians.
HeadRotation looking(double yaw) {
    const auto c = static_cast<float>(std::cos(yaw));
    const auto s = static_cast<float>(std::sin(yaw));
    return {{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}};
}

double energy(const Signal& signal, std::size_t from, std::size_t to) {
    double sum = 0;
    for (std::size_t n = from; n < to; ++n) sum += double{signal[n]} * double{signal[n]};
    return sum;
}

}  // namespace

TEST_CASE(
    "A reflection of known identity moves continuously, without sidebands at the frame rate") {
    for (const double frequency_hz : {1000.0, 4000.0, 8000.0}) {
        const double heard_hz = frequency_hz * (1 - 1.5 / kSpeed_m_s);
        const double moving_db =
            energy_outside_db(walk_from_reflection(7, frequency_hz), heard_hz, 25, kRate_hz);
        const double baked_db =
            energy_outside_db(walk_from_reflection(0, frequency_hz), heard_hz, 25, kRate_hz);
        CAPTURE(frequency_hz, moving_db, baked_db);
        // The side lobes of the window are at -92 dB; the speed varies slightly, since frames are
        // taken at the start of a call.
        CHECK(moving_db < -80);
        // Companion: a tap of the reverberation, crossfaded between positions.
        CHECK(baked_db > -30);
    }
}

TEST_CASE(
    "The strongest reflections move, the others are part of the reverberation, none is lost") {
    // Ten of 13 reflections move; then the order of their levels is reversed.
    const auto sound_with = [](bool reversed) {
        SourceSound sound;
        for (unsigned k = 0; k < 13; ++k) {
            const auto rank = static_cast<float>(reversed ? 13 - k : k + 1);
            sound.early.push_back(path_of(400 + 100 * k, rank / 10, {0, 0, 1}));
            sound.early.back().id = 100 + k;
        }
        return sound;
    };
    for (const bool reversed : {false, true}) {
        Player fresh(config_for(OutputFormat::foa), nullptr, {[] {
                         Signal impulse(6144);
                         impulse[4096] = 1;
                         return impulse;
                     }()});
        fresh.publish({sound_with(false)});
        fresh.play_until(1024);
        fresh.publish({sound_with(reversed)});
        fresh.play_until(6144);
        for (unsigned k = 0; k < 13; ++k) {
            const float expected = static_cast<float>(reversed ? 13 - k : k + 1) / 10;
            for (const std::size_t channel : {0U, 2U}) {
                CHECK(fresh.output(channel)[4096 + 400 + 100 * k] ==
                      Approx(double{expected}).margin(1e-5));  // rounding of the convolver
            }
        }
    }
}

TEST_CASE("A slot crossfades from one reflection to another") {
    SourceSound before;
    before.early = {path_of(480, 1)};
    before.early[0].id = 1;
    // Near enough that the same reflection would move there.
    SourceSound after;
    after.early = {path_of(504, 0.5F)};
    after.early[0].id = 2;
    CHECK(crossfade_error(before, 480, after, 504) < 1e-5);  // rounding: whole samples
}

TEST_CASE("A reflection that jumps farther than a source moves crossfades in both directions") {
    SourceSound near;
    near.early = {path_of(480, 1)};
    near.early[0].id = 1;
    SourceSound far = near;
    far.early[0].delay_s = path_of(2880, 1).delay_s;
    const auto half = [](SourceSound sound) {
        sound.early[0].band_gain = path_of(480, 0.5F).band_gain;
        return sound;
    };
    // Rounding: whole samples.
    CHECK(crossfade_error(near, 480, half(far), 2880) < 1e-5);
    CHECK(crossfade_error(far, 2880, half(near), 480) < 1e-5);
}

TEST_CASE("Direct sound, reflections and reverberation follow the head from the next block on") {
    // Each alone, from the front. Then the head turns left instantaneously: the sound is at its
    // right.
    SourceSound direct;
    direct.direct = path_of(480, 1, {1, 0, 0});
    SourceSound early;
    early.early = {path_of(480, 1, {1, 0, 0})};
    early.early[0].id = 3;
    SourceSound baked = early;
    baked.early[0].id = 0;
    for (const SourceSound& sound : {direct, early, baked}) {
        const Signal noise = random_signals(1, 9600, 1)[0];
        Signals steady;
        Signals turned;
        for (Signals* outputs : {&steady, &turned}) {
            Player player(config_for(OutputFormat::binaural), kemar(), {noise});
            player.publish({sound});
            player.play_until(5120);
            player.play_until(9600, {256},
                              outputs == &turned ? looking(std::numbers::pi / 2) : kNoRotation);
            *outputs = player.outputs();
        }
        // The block after the turn differs, and two blocks later the turn is complete: the level
        // difference of the ears is about 10 dB.
        CHECK(turned[0][5100] == steady[0][5100]);
        double difference = 0;
        for (std::size_t n = 5120; n < 5376; ++n) {
            difference += std::abs(double{turned[0][n]} - double{steady[0][n]});
        }
        CHECK(difference > 1);
        const double before_db =
            10 * std::log10(energy(turned[1], 4000, 5120) / energy(turned[0], 4000, 5120));
        const double after_db =
            10 * std::log10(energy(turned[1], 5632, 8000) / energy(turned[0], 5632, 8000));
        CHECK(before_db == Approx(0).margin(1));
        CHECK(after_db > 6);
    }
}

TEST_CASE("Turns of the head add no sidebands above -55 dB, with calls of varying size") {
    const std::size_t samples = 96000;
    Player player(config_for(OutputFormat::binaural), kemar(), {sine(1000, samples, kRate_hz)});
    SourceSound sound;
    sound.direct = path_of(480, 1, {1, 0, 0});
    player.publish({sound});
    // Half a revolution per second; the orientation is that at the start of each call.
    const std::vector<std::size_t> calls{256, 100, 256, 17};
    for (std::size_t k = 0; player.done() < samples; ++k) {
        const double yaw = std::numbers::pi * static_cast<double>(player.done()) / kRate_hz;
        player.play_until(std::min(samples, player.done() + calls[k % 4]), {calls[k % 4]},
                          looking(yaw));
    }
    for (const Signal& ear : player.outputs()) {
        const Signal steady(ear.begin() + 4800, ear.end());
        CHECK(energy_outside_db(steady, 1000, 200, kRate_hz) < -55);
    }
}

TEST_CASE("A glide reaches its target in time and smooths its corners") {
    constexpr std::size_t kSamples = 1600;
    Glide glide(kSamples);
    glide.jump(100);
    CHECK(glide.next() == 100);
    constexpr double kSlope = 0.01;
    double before = 100;
    double step_before = 0;
    double target = 100;
    for (int frame = 0; frame < 6; ++frame) {
        // Forwards twice, backwards once, then at rest.
        target += frame < 2 ? kSlope * kSamples : frame == 2 ? -kSlope * kSamples : 0;
        glide.move_to(target);
        for (std::size_t n = 0; n < kSamples; ++n) {
            const double value = glide.next();
            const double step = value - before;
            // The time constant of the pole is a quarter of the frame: it smooths a corner of twice
            // the slope.
            CHECK(std::abs(step) <= kSlope * (1 + 1e-9));
            CHECK(std::abs(step - step_before) <= 2 * kSlope * 4 / kSamples);
            before = value;
            step_before = step;
        }
        // At a constant slope it lags by the time constant.
        if (frame == 1) CHECK(before == Approx(target - kSlope * kSamples / 4).margin(0.1));
    }
    // Three frames of rest are twelve time constants.
    CHECK(before == Approx(target).margin(16 * std::exp(-12.0)));
}

TEST_CASE("After a turn the ears converge to those of a head at rest in that orientation") {
    SourceSound sound;
    sound.direct = path_of(480.5, 1, {0.6F, 0.8F, 0});
    const std::size_t samples = 20480;
    const Signal noise = random_signals(1, samples, 3)[0];
    // A turn that hardly changes the ear filters, and a large one.
    for (const double turn : {0.01, 1.5}) {
        Player still(config_for(OutputFormat::binaural), kemar(), {noise});
        still.publish({sound});
        still.play_until(samples, {256}, looking(turn));
        Player turning(config_for(OutputFormat::binaural), kemar(), {noise});
        turning.publish({sound});
        turning.play_until(5120);
        turning.play_until(samples, {256}, looking(turn));
        double worst = 0;
        double before = 0;
        for (std::size_t e = 0; e < 2; ++e) {
            for (std::size_t n = 0; n < samples; ++n) {
                const double difference =
                    double{std::abs(still.output(e)[n] - turning.output(e)[n])};
                if (n > 1024 && n < 5120) before = std::max(before, difference);
                // 60 blocks after the turn; the time constant of the ear delays is 1/4 block.
                if (n >= samples - 2048) worst = std::max(worst, difference);
            }
        }
        CAPTURE(turn, worst, before);
        // Rounding of outputs of magnitude 3.
        CHECK(worst < 1e-4);
        CHECK(before > 100 * worst);  // companion: before the turn the outputs differ
    }
}

TEST_CASE("A path that starts equals one that was always present, up to the longest delay") {
    RendererConfig config = config_for(OutputFormat::binaural);
    config.longest_delay_s = 0.05;  // 2400 samples
    const double delay_samples = GENERATE(700.25, 2399.75);
    SourceSound sound;
    sound.direct = path_of(delay_samples, 1, {0.6F, 0.8F, 0});
    // Unequal gains, which give a filter of many taps.
    sound.direct->band_gain = {1, 0.9F, 0.7F, 0.5F, 0.35F, 0.2F, 0.1F, 0.05F};
    const std::size_t samples = 8192;
    const Signal noise = random_signals(1, samples, 4)[0];
    Player always(config, kemar(), {noise});
    always.publish({sound});
    always.play_until(samples);
    // The first frame takes effect without a fade, with the history of the delay line.
    Player late(config, kemar(), {noise});
    late.play_until(4096);
    late.publish({sound});
    late.play_until(samples);
    double worst = 0;
    for (std::size_t e = 0; e < 2; ++e) {
        // Only the ear filters, of 256 taps, start without history.
        for (std::size_t n = 4096 + 256; n < samples; ++n) {
            worst = std::max(worst, double{std::abs(always.output(e)[n] - late.output(e)[n])});
        }
    }
    CHECK(worst < 1e-5);  // rounding
}

TEST_CASE("A path that returns contains nothing of its earlier output") {
    SourceSound sound;
    sound.direct = path_of(480, 1, {0, 1, 0});
    const std::size_t samples = 40960;
    Signal input = random_signals(1, samples, 5)[0];
    std::fill(input.begin() + 16384, input.end(), 0.0F);
    Player player(config_for(OutputFormat::binaural), kemar(), {input});
    player.publish({sound});
    player.play_until(8192);
    // Occluded during the signal; it returns in silence.
    player.publish({SourceSound{}});
    for (const std::size_t end : {24576U, 32768U}) {
        player.play_until(end);
        player.publish({sound});
    }
    player.play_until(samples);
    for (const Signal& ear : player.outputs()) {
        CHECK(energy(ear, 4096, 8192) > 1);
        // Rounding of the decoder's transforms: 1e-7 of the earlier signal.
        CHECK(std::all_of(ear.begin() + 24576, ear.end(),
                          [](float x) { return std::abs(x) < 1e-6F; }));
    }
}

TEST_CASE("A path that ended during a turn of the head returns with the present ear filters") {
    SourceSound sound;
    sound.direct = path_of(480, 1, {0.6F, 0.8F, 0});
    const std::size_t samples = 28000;
    constexpr std::size_t kBack = 24000;
    const Signal noise = random_signals(1, samples, 6)[0];
    // The path ends at different positions within a crossfade of the ears.
    for (const std::size_t hidden : {8000U, 8100U, 8200U}) {
        Signals outputs[2];
        for (const bool turns : {false, true}) {
            Player player(config_for(OutputFormat::binaural), kemar(), {noise});
            player.publish({sound});
            while (player.done() < 12000) {
                if (player.done() == hidden) player.publish({SourceSound{}});
                const double yaw = turns ? 1e-3 * static_cast<double>(player.done() / 100) : 0.0;
                player.play_until(player.done() + 100, {100}, looking(yaw));
            }
            player.play_until(kBack);
            player.publish({sound});
            player.play_until(samples);
            outputs[turns ? 1 : 0] = player.outputs();
        }
        CAPTURE(hidden);
        for (std::size_t e = 0; e < 2; ++e) {
            CHECK(outputs[0][e] != outputs[1][e]);
            CHECK(std::equal(outputs[0][e].begin() + kBack, outputs[0][e].end(),
                             outputs[1][e].begin() + kBack));
        }
    }
}

TEST_CASE("A direction moves to its next value within a frame") {
    const std::size_t samples = 9600;
    Player player(config_for(OutputFormat::foa), nullptr, {Signal(samples, 1.0F)});
    SourceSound front;
    front.direct = path_of(100, 1, {1, 0, 0});
    SourceSound left;
    left.direct = path_of(100, 1, {0, 1, 0});
    player.publish({front});
    player.play_until(5120);
    player.publish({left});
    player.play_until(samples);
    const auto angle_deg = [&](std::size_t after) {
        return std::atan2(double{player.output(1)[5120 + after]},
                          double{player.output(3)[5120 + after]}) *
               180 / std::numbers::pi;
    };
    // A chord of a quarter circle, traversed uniformly in 1600 samples; at most a block of 256
    // samples early.
    for (const std::size_t after : {256U, 512U, 768U, 1024U, 1280U, 1536U}) {
        const double share = static_cast<double>(after) / 1600;
        const auto on_chord = [](double s) {
            return std::atan2(s, 1 - s) * 180 / std::numbers::pi;
        };
        CAPTURE(after, angle_deg(after));
        CHECK(angle_deg(after) > on_chord(share - 0.17));
        CHECK(angle_deg(after) < on_chord(share + 0.17));
    }
    CHECK(angle_deg(1800) == Approx(90).margin(0.01));
}

TEST_CASE("The level of a path that turns about the head within a frame is constant") {
    constexpr std::size_t kSamples = 8192;
    Player player(config_for(OutputFormat::foa), nullptr, {Signal(kSamples, 1)});
    SourceSound sound;
    sound.direct = path_of(480, 1, {1, 0, 0});
    player.publish({sound});
    player.play_until(4096);
    sound.direct = path_of(480, 1, {0, 1, 0});
    player.publish({sound});
    player.play_until(kSamples);
    double min = 1;
    for (std::size_t n = 4096; n < kSamples; ++n) {
        REQUIRE(double{player.output(0)[n]} == Approx(1).margin(1e-4));  // rounding
        min = std::min(min, std::hypot(double{player.output(1)[n]}, double{player.output(2)[n]},
                                       double{player.output(3)[n]}));
    }
    // Encodings are interpolated linearly from block to block, over at most 18 degrees in the
    // middle of the quarter turn: cos 9 = 0.988. Linear interpolation over the whole turn would
    // give 0.71.
    CHECK(min > 0.985);
    CHECK(double{player.output(1)[kSamples - 1]} == Approx(1).margin(1e-4));
}

TEST_CASE("A turn of the head is crossfaded equally in calls of any size") {
    const auto turned = [](const std::vector<std::size_t>& calls) {
        constexpr std::size_t kSamples = 6144;
        Player player(config_for(OutputFormat::binaural), kemar(),
                      {sine(4000, kSamples, kRate_hz)});
        SourceSound sound;
        sound.direct = path_of(480, 1, {1, 0, 0});
        player.publish({sound});
        player.play_until(4096);
        player.play_until(kSamples, calls, looking(0.5));
        return player.outputs();
    };
    const Signals whole = turned({256});
    const Signals parts = turned({64, 17, 100});
    for (std::size_t e = 0; e < 2; ++e) {
        double worst = 0;
        for (std::size_t n = 0; n < whole[e].size(); ++n)
            worst = std::max(worst, std::abs(double{whole[e][n]} - double{parts[e][n]}));
        CAPTURE(e);
        CHECK(worst < 1e-4);  // rounding; both ears have levels of magnitude 1
    }
}

}  // namespace moving_path_test
