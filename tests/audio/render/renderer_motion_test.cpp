#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "audio/render/renderer.h"
#include "audio/spatial/sofa_file.h"
#include "tests/audio/convolution/signals.h"
#include "tests/audio/player.h"
#include "tests/audio/spatial/directions.h"

using namespace aula;
using namespace aula::test;

namespace {

/// A walk at 1.5 m/s away from a source, from a distance of 2 m on, with 30 frames per second.
/// `unrelated`: each frame has an independent reverberation.
Signals walk(const RendererConfig& config, const std::shared_ptr<const Hrtf>& hrtf, Signal dry,
             bool unrelated) {
    const std::size_t samples = dry.size();
    Player player(config, hrtf, {std::move(dry)});
    for (unsigned frame = 0; player.done() < samples; ++frame) {
        const double distance_m = 2 + 1.5 * frame / 30.0;
        const Signals late = reverberation(config.response_samples, unrelated ? frame : 0);
        SourceSound sound = sound_of(late);
        const double angle = 0.02 * frame;
        const std::array<float, 3> direction{static_cast<float>(std::cos(angle)),
                                             static_cast<float>(std::sin(angle)), 0};
        const auto gain = static_cast<float>(1 / distance_m);
        sound.direct = path_of(distance_m / kSpeed_m_s * kRate_hz, gain, direction);
        sound.early = {path_of((distance_m + 3) / kSpeed_m_s * kRate_hz, 0.5F * gain, direction)};
        player.publish({sound});
        player.play_until(std::min<std::size_t>(samples, (frame + 1) * 1600));
    }
    return player.outputs();
}

}  // namespace

TEST_CASE("An exchange of frames is a crossfade of their outputs for a frame") {
    const std::size_t samples = 6000;
    const Signals input = random_signals(1, samples, 8);
    // Short enough for the first level of the convolution.
    const std::array<Signals, 2> late{reverberation(1000, 9), reverberation(1000, 10)};
    std::array<Signal, 2> alone;
    for (std::size_t i = 0; i < 2; ++i) {
        Player player(config_for(OutputFormat::mono), nullptr, input);
        player.publish({sound_of(late[i])});
        player.play_until(samples);
        alone[i] = player.output(0);
    }
    Player player(config_for(OutputFormat::mono), nullptr, input);
    player.publish({sound_of(late[0])});
    player.play_until(2048);
    player.publish({sound_of(late[1])});
    player.play_until(samples);
    const std::vector<float> weights = rounded_line(1600);
    double worst = 0;
    for (std::size_t n = 0; n < samples; ++n) {
        const float w = n < 2048 ? 0 : n - 2048 < weights.size() ? weights[n - 2048] : 1;
        const float expected = (1 - w) * alone[0][n] + w * alone[1][n];
        worst = std::max(worst, double{std::abs(player.output(0)[n] - expected)});
    }
    CHECK(worst < 1e-5);  // rounding
}

TEST_CASE("Motion adds no sidebands above -60 dB to a tone") {
    const bool unrelated = GENERATE(false, true);
    const double frequency_hz = GENERATE(1000.0, 8000.0);
    const Signals outputs = walk(config_for(OutputFormat::foa), nullptr,
                                 sine(frequency_hz, 144000, kRate_hz), unrelated);
    for (std::size_t c = 0; c < 4; ++c) {
        // After the onset. Z has no direct sound.
        const Signal steady(outputs[c].begin() + 9600, outputs[c].end());
        const double outside_db = energy_outside_db(steady, frequency_hz, 200, kRate_hz);
        CAPTURE(c, unrelated, frequency_hz);
        // Fades are straight lines; a reverberation that is another one in each frame bends them.
        CHECK(outside_db < (unrelated ? -49 : -60));
    }
}

TEST_CASE("The same motion without crossfades adds sidebands above -60 dB") {
    // Companion of the test above: frames spliced without a fade.
    const Signal tone = sine(1000, 48000, kRate_hz);
    Signal spliced(48000);
    for (std::size_t n = 0; n < spliced.size(); ++n) {
        const auto frame = static_cast<double>(n / 1600);
        const double distance_m = 2 + 1.5 * frame / 30;
        const double at = static_cast<double>(n) - distance_m / kSpeed_m_s * kRate_hz;
        spliced[n] =
            static_cast<float>(std::sin(2 * std::numbers::pi * 1000 * at / kRate_hz) / distance_m);
    }
    CHECK(energy_outside_db(spliced, 1000, 200, kRate_hz) > -60);
    CHECK(energy_outside_db(tone, 1000, 200, kRate_hz) < -80);
}

TEST_CASE("The Doppler shift lowers the frequency of a receding source") {
    RendererConfig config = config_for(OutputFormat::mono);
    Player player(config, nullptr, {sine(4000, 96000, kRate_hz)});
    for (unsigned frame = 0; player.done() < 96000; ++frame) {
        SourceSound sound;
        // 10 m/s.
        sound.direct = path_of((20 + 10 * frame / 30.0) / kSpeed_m_s * kRate_hz, 1);
        player.publish({sound});
        player.play_until(std::min<std::size_t>(96000, (frame + 1) * 1600));
    }
    const double expected_hz = 4000 * (1 - 10 / kSpeed_m_s);
    const Signal steady(player.output(0).begin() + 9600, player.output(0).end());
    // The target delay changes at block boundaries, not exactly every 1600 samples: the shift
    // varies by some hertz about its mean.
    CHECK(energy_outside_db(steady, expected_hz, 60, kRate_hz) < -40);
    CHECK(energy_outside_db(steady, 4000, 60, kRate_hz) > -3);
}

TEST_CASE("A path that starts at the longest delay has the sound from before its start") {
    // An ear hears 5.2 ms after the other one, nearly as late as a head may.
    constexpr std::size_t kStart = 4800;
    constexpr std::size_t kFade = 1024;
    HeadMeasurements measured;
    measured.samples = 64;
    for (const auto& direction : uniform_directions(60)) {
        measured.positions.push_back({direction[0], direction[1], direction[2]});
        for (const float delay_samples : {0.0F, 250.0F}) {
            measured.responses.push_back(1);
            measured.responses.resize(measured.responses.size() + measured.samples - 1);
            measured.delays_samples.push_back(delay_samples);
        }
    }
    const auto head = std::make_shared<const Hrtf>(measured, kRate_hz);
    RendererConfig config = config_for(OutputFormat::binaural, 1, 480);
    config.block = 32;
    config.longest_delay_s = 0.05;
    SourceSound sound;
    sound.direct = path_of(2400, 1);
    const auto played = [&](std::size_t start) {
        Player player(config, head, random_signals(1, 9600, 12));
        player.publish({SourceSound{}});
        player.play_until(start, {32});
        player.publish({sound});
        player.play_until(9600, {32});
        return player.outputs();
    };
    const Signals late = played(kStart);
    const Signals always = played(32);
    const std::vector<float> weights = raised_cosine(kFade);
    for (std::size_t ear = 0; ear < 2; ++ear) {
        double worst = 0;
        for (std::size_t n = kStart; n < 9600; ++n) {
            const float weight = n - kStart < kFade ? weights[n - kStart] : 1;
            worst =
                std::max(worst, std::abs(double{late[ear][n]} - double{weight * always[ear][n]}));
        }
        // The response of an ear, which follows the fade, is not quite an impulse.
        CAPTURE(ear);
        CHECK(worst < 1e-3);
    }
    CHECK(std::any_of(always[1].begin(), always[1].end(), [](float x) { return x > 0.5F; }));
}

TEST_CASE("A jump of a source is crossfaded without a sweep") {
    SourceSound before;
    before.direct = path_of(480, 1);
    SourceSound after;
    after.direct = path_of(2424, 0.5F);
    CHECK(crossfade_error(before, 480, after, 2424) < 1e-5);  // rounding: whole samples
}

TEST_CASE("Direct sound fades out when occluded and returns without a click") {
    const std::size_t samples = 48000;
    Player player(config_for(OutputFormat::foa), nullptr, {sine(1000, samples, kRate_hz)});
    SourceSound visible;
    visible.direct = path_of(480, 1);
    for (std::size_t turn = 0; turn < 12; ++turn) {
        player.publish({turn % 2 == 0 ? visible : SourceSound{}});
        player.play_until((turn + 1) * 4000);
    }
    const Signal steady(player.output(0).begin() + 2000, player.output(0).end());
    CHECK(energy_outside_db(steady, 1000, 200, kRate_hz) < -60);
    // Occluded in the last turn: exactly silent after the fade.
    CHECK(std::all_of(player.output(0).end() - 2000, player.output(0).end(),
                      [](float x) { return x == 0; }));
}

TEST_CASE("A turn of the head rotates the field in the opposite direction") {
    // The head looks along world y: its x axis is y, its y axis is -x.
    const HeadRotation left{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
    Signals late(4, Signal(1));
    late[0][0] = 1;  // from world x, the right of that head
    late[3][0] = 1;
    SourceSound sound = sound_of(late);
    sound.early = {path_of(100, 1, {0, 1, 0})};  // in front of it
    sound.direct = path_of(200, 1, {0, -1, 0});  // behind it
    Player player(config_for(OutputFormat::foa), nullptr, {impulse(1024)});
    player.publish({sound});
    player.play_until(1024, {256}, left);
    const auto at = [&](std::size_t n) {
        return std::array<float, 4>{player.output(0)[n], player.output(1)[n], player.output(2)[n],
                                    player.output(3)[n]};
    };
    // Rounding of the convolution; the direct path is exact.
    const auto agrees = [](const std::array<float, 4>& a, const std::array<float, 4>& b) {
        return std::equal(a.begin(), a.end(), b.begin(),
                          [](float x, float y) { return std::abs(x - y) < 1e-6F; });
    };
    CHECK(agrees(at(0), {1, -1, 0, 0}));
    CHECK(agrees(at(100), {1, 0, 0, 1}));
    CHECK(agrees(at(200), {1, 0, 0, -1}));
}

TEST_CASE("An instantaneous turn of the head does not click") {
    Signals late(4, Signal(1));
    late[0][0] = late[1][0] = 1;
    const HeadRotation turned{{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};
    Player player(config_for(OutputFormat::foa), nullptr, {sine(1000, 24000, kRate_hz)});
    player.publish({sound_of(late)});
    for (std::size_t turn = 0; turn < 12; ++turn) {
        player.play_until((turn + 1) * 2000, {256, 100}, turn % 2 == 0 ? kNoRotation : turned);
    }
    // Y changes between 1 and -1 linearly over 256 samples, 24 times a second. This has -50 dB of
    // its energy farther than 1 kHz from the tone; a step has -20 dB.
    CHECK(energy_outside_db(player.output(1), 1000, 1000, kRate_hz) < -45);
}

TEST_CASE("Rendering is reproducible to the bit") {
    const auto play = [] {
        return walk(config_for(OutputFormat::foa), nullptr, random_signals(1, 24000, 13)[0], true);
    };
    CHECK(play() == play());
}

TEST_CASE("A change of a source's gain is crossfaded, linearly for paths that move") {
    SourceSound direct;
    direct.direct = path_of(480, 1);
    SourceSound moving;
    moving.early = {path_of(480, 1)};
    moving.early[0].id = 1;
    Signals late(1, Signal(481));
    late[0][480] = 1;
    SourceSound reflection;
    reflection.early = {path_of(480, 1)};
    std::vector<float> linear(1600);  // until the next frame
    for (std::size_t n = 0; n < linear.size(); ++n) linear[n] = static_cast<float>(n) / 1600;
    for (const auto& [sound, weights] : {std::pair(direct, linear),
                                         {moving, linear},
                                         {reflection, rounded_line(1600)},
                                         {sound_of(late), rounded_line(1600)}}) {
        SourceSound quieter = sound;
        quieter.gain = 0.5F;
        CHECK(crossfade_error(sound, 480, quieter, 480, weights) < 1e-5);  // rounding
        // Companion: the fade is part of the error's definition.
        CHECK(crossfade_error(sound, 480, sound, 480, weights) > 0.4);
    }
}

TEST_CASE("A level that rises and falls once a second adds no lines at the frame rate") {
    constexpr std::size_t kSamples = 144000;
    const auto level = [](double time_s) {
        return 0.55 + 0.45 * std::cos(2 * std::numbers::pi * time_s);
    };
    for (const double rate_hz : {30.0, 60.0, 100.0, 120.0}) {
        for (const int block : {64, 256, 480, 1000}) {
            RendererConfig config = config_for(OutputFormat::mono);
            config.frame_s = 1 / rate_hz;
            config.block = block;
            const auto frame_samples = static_cast<std::size_t>(kRate_hz / rate_hz);
            const auto call = static_cast<std::size_t>(block);
            Player player(config, nullptr, {sine(1000, kSamples, kRate_hz)});
            std::size_t due = 0;
            for (std::size_t frame = 0; player.done() < kSamples;) {
                if (player.done() >= due) {
                    frame = player.done() / frame_samples;
                    SourceSound sound;
                    sound.direct = path_of(
                        480, static_cast<float>(level(static_cast<double>(frame) / rate_hz)));
                    player.publish({sound});
                    due = (frame + 1) * frame_samples;
                }
                player.play_until(std::min(kSamples, player.done() + call), {call});
            }
            const Signal steady(player.output(0).begin() + 24000, player.output(0).end());
            CAPTURE(rate_hz, block);
            // Calls of more than half a frame take frames at more irregular times.
            CHECK(energy_outside_db(steady, 1000, 15, kRate_hz) < (block > 800 ? -55 : -60));
        }
    }
    // Companion: raised-cosine crossfades of 1024 samples between 30 levels a second.
    const std::vector<float> weights = raised_cosine(1024);
    Signal crossfaded = sine(1000, kSamples, kRate_hz);
    for (std::size_t n = 0; n < kSamples; ++n) {
        const double from = level(static_cast<double>(n / 1600) / 30);
        const double to = level(static_cast<double>(n / 1600 + 1) / 30);
        const double w = n % 1600 < 1024 ? double{weights[n % 1600]} : 1;
        crossfaded[n] *= static_cast<float>(from + w * (to - from));
    }
    CHECK(energy_outside_db(crossfaded, 1000, 15, kRate_hz) > -50);
}

TEST_CASE("A source at constant speed is shifted by 1 - v / c, towards the listener and away") {
    const double speed_m_s = GENERATE(-30.0, -3.0, 0.0, 3.0, 30.0);
    constexpr std::size_t kSamples = 72000;
    Player player(config_for(OutputFormat::mono), nullptr, {sine(1000, kSamples, kRate_hz)});
    for (unsigned frame = 0; player.done() < kSamples; ++frame) {
        SourceSound sound;
        const double distance_m = 60 + speed_m_s * frame / 30.0;
        sound.direct = path_of(distance_m / kSpeed_m_s * kRate_hz, 1);
        player.publish({sound});
        player.play_until(std::min<std::size_t>(kSamples, (frame + 1) * 1600));
    }
    // Rising zero crossings over 30 frames, with linear interpolation.
    const Signal& out = player.output(0);
    double first = 0;
    double last = 0;
    int periods = -1;
    for (std::size_t n = 24000; n < kSamples; ++n) {
        if (!(out[n - 1] < 0 && out[n] >= 0)) continue;
        last = static_cast<double>(n) - double{out[n]} / (double{out[n]} - double{out[n - 1]});
        if (periods < 0) first = last;
        ++periods;
    }
    const double heard_hz = periods * kRate_hz / (last - first);
    // Delays glide over frames of 1600 samples that are taken at blocks of 256, up to a sixth of a
    // frame late; of 30 frames one sixth of the shift's share is 0.6 % of it.
    const double shift_hz = -1000 * speed_m_s / kSpeed_m_s;
    CAPTURE(heard_hz);
    CHECK(heard_hz - 1000 == Approx(shift_hz).epsilon(0.006).margin(0.01));
}

TEST_CASE("A turn of the head crossfades the field linearly over a block, at least 64 samples") {
    const HeadRotation left{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
    for (const auto& [block, turn] : {std::pair{256, 256}, {16, 64}}) {
        RendererConfig config = config_for(OutputFormat::foa, 1, 16);
        config.block = block;
        Signals late(4, Signal(1));
        late[0][0] = late[3][0] = 1;  // from the front, then from the right
        Player player(config, nullptr, {Signal(2048, 1)});
        player.publish({sound_of(late)});
        const std::vector<std::size_t> calls{static_cast<std::size_t>(block)};
        player.play_until(1024, calls);
        player.play_until(2048, calls, left);
        CAPTURE(block);
        double worst = 0;
        for (int n = 0; n < 1024; ++n) {
            const double share = std::min(1.0, (n + 1.0) / turn);
            const auto at = static_cast<std::size_t>(1024 + n);
            worst = std::max(worst, std::abs(double{player.output(3)[at]} - (1 - share)));
            worst = std::max(worst, std::abs(double{player.output(1)[at]} + share));
        }
        CHECK(worst < 1e-5);  // rounding
    }
}
