#include "audio/render/renderer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "audio/dsp/fractional_delay.h"
#include "audio/render/render_frame.h"
#include "aula/audio/convolver.h"
#include "tests/audio/convolution/signals.h"
#include "tests/audio/player.h"

using namespace aula;
using namespace aula::test;

namespace {

Signal impulse(std::size_t samples, std::size_t at = 0) {
    Signal signal(samples);
    signal[at] = 1;
    return signal;
}

/// Decaying noise with an energy of 1 in W and 1/3 in the other channels.
Signals reverberation(std::size_t samples, unsigned seed) {
    Signals channels = random_signals(4, samples, seed);
    for (std::size_t c = 0; c < 4; ++c) {
        double energy = 0;
        for (std::size_t n = 0; n < samples; ++n) {
            channels[c][n] *= std::exp(-4 * static_cast<float>(n) / static_cast<float>(samples));
            energy += double{channels[c][n]} * double{channels[c][n]};
        }
        const double scale = std::sqrt((c == 0 ? 1.0 : 1.0 / 3) / energy);
        for (float& x : channels[c]) x *= static_cast<float>(scale);
    }
    return channels;
}

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

TEST_CASE("A source at distance d is rendered with delay d / c and amplitude 1 / d") {
    Player player(config_for(OutputFormat::mono), nullptr, {impulse(2048, 10)});
    SourceSound sound;
    sound.direct = path_of(420, 1 / 3.0F);
    player.publish({sound});
    player.play_until(2048);
    Signal expected(2048);
    expected[430] = 1 / 3.0F;
    CHECK(player.output(0) == expected);
}

TEST_CASE("Fractional delays have the right phase and unit gain") {
    const double delay = GENERATE(100.25, 333.5, 16.875);
    const double frequency_hz = GENERATE(100.0, 1000.0, 8000.0, 16000.0);
    Player player(config_for(OutputFormat::mono), nullptr, {sine(frequency_hz, 4096, kRate_hz)});
    SourceSound sound;
    sound.direct = path_of(delay, 1);
    player.publish({sound});
    player.play_until(4096);
    double worst = 0;
    for (std::size_t n = 1000; n < 4096; ++n) {
        const double expected = std::sin(2 * std::numbers::pi * frequency_hz *
                                         (static_cast<double>(n) - delay) / kRate_hz);
        worst = std::max(worst, std::abs(double{player.output(0)[n]} - expected));
    }
    // Interpolation error: -80 dB required up to 8 kHz.
    CHECK(worst < (frequency_hz > 10000 ? 1e-3 : 1e-4));
}

TEST_CASE("The output is silent before the first frame, which takes effect without a fade") {
    const OutputFormat format = GENERATE(OutputFormat::mono, OutputFormat::foa);
    Player player(config_for(format), nullptr, random_signals(1, 2048, 1));
    player.play_until(512);
    SourceSound sound;
    sound.direct = path_of(100, 1);
    player.publish({sound});
    player.play_until(2048);
    const Signal in = random_signals(1, 2048, 1)[0];
    for (std::size_t n = 0; n < 2048; ++n) {
        // The delay line already contains the input before the frame.
        CHECK(player.output(0)[n] == (n < 512 ? 0.0F : in[n - 100]));
    }
}

TEST_CASE("The rendered output agrees with its definition") {
    const std::vector<std::size_t> calls =
        GENERATE(std::vector<std::size_t>{256}, std::vector<std::size_t>{100, 256, 1, 31});
    const std::size_t samples = 8192;
    const Signals inputs = random_signals(2, samples, 5);
    const Signals late = reverberation(4000, 6);
    std::vector<SourceSound> sounds{sound_of(late), SourceSound{}};
    sounds[0].gain = 0.5F;
    sounds[0].direct = path_of(200, 0.7F, {0, 1, 0});
    // The second source has early reflections only, one with a fractional delay.
    sounds[1].early = {path_of(300, 0.4F, {0, 0, 1}), path_of(1000.5, 0.3F, {0.6F, 0, 0.8F})};

    Player player(config_for(OutputFormat::foa, 2), nullptr, inputs);
    player.publish(sounds);
    player.play_until(samples, calls);

    const std::array<std::array<double, 4>, 3> encoding{
        {{1, 1, 0, 0}, {1, 0, 1, 0}, {1, 0, 0.8, 0.6}}};
    const std::array<float, kInterpolationTaps> half = FractionalDelay().impulse(0.5);
    double worst = 0;
    for (std::size_t c = 0; c < 4; ++c) {
        for (std::size_t n = 2000; n < samples; n += 37) {
            double sum = 0.5 * 0.7 * encoding[0][c] * double{inputs[0][n - 200]};
            for (std::size_t k = 0; k < std::min<std::size_t>(n + 1, 4000); ++k) {
                sum += 0.5 * double{late[c][k]} * double{inputs[0][n - k]};
            }
            sum += double{0.4F} * encoding[1][c] * double{inputs[1][n - 300]};
            for (std::size_t k = 0; k < half.size(); ++k) {
                sum += double{0.3F} * encoding[2][c] * double{half[k]} *
                       double{inputs[1][n - 1000 + FractionalDelay::kBefore - k]};
            }
            worst = std::max(worst, std::abs(double{player.output(c)[n]} - sum));
        }
    }
    // Rounding, as for the convolver: outputs have magnitudes of 1 to 4.
    CHECK(worst < 1e-5);
}

TEST_CASE("Calls of varying size give the output of whole blocks") {
    const auto play = [](const std::vector<std::size_t>& calls) {
        Player player(config_for(OutputFormat::foa), nullptr, random_signals(1, 12000, 7));
        for (unsigned frame = 0; frame < 5; ++frame) {
            const Signals late = reverberation(4800, frame);
            SourceSound sound = sound_of(late);
            sound.direct = path_of(500 + 7.3 * frame, 0.5F, {0, 1, 0});
            player.publish({sound});
            // Frames are taken at the start of a call, here at the same sample for both.
            player.play_until((frame + 1) * 2304, calls);
        }
        return player.outputs();
    };
    const Signals whole = play({256});
    const Signals varying = play({1, 200, 56, 255, 17});
    double worst = 0;
    for (std::size_t c = 0; c < 4; ++c) {
        for (std::size_t n = 0; n < 5 * 2304; ++n) {
            worst = std::max(worst, double{std::abs(whole[c][n] - varying[c][n])});
        }
    }
    CHECK(worst < 1e-5);  // rounding
    CHECK(worst > 0);     // the order of summation differs
}

TEST_CASE("An exchange of frames is a raised-cosine crossfade of their outputs") {
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
    const std::vector<float> weights = raised_cosine(1024);
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
        CHECK(outside_db < -60);
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

TEST_CASE("Mono output is the W channel of ambisonic output") {
    const Signals late = reverberation(3000, 11);
    SourceSound sound = sound_of(late);
    sound.early = {path_of(77.7, 0.5F, {0, 1, 0})};
    sound.direct = path_of(55.5, 0.8F, {0, 0, 1});
    Signals outputs;
    for (const OutputFormat format : {OutputFormat::mono, OutputFormat::foa}) {
        Player player(config_for(format), nullptr, random_signals(1, 6000, 12));
        player.publish({sound});
        player.play_until(6000);
        outputs.push_back(player.output(0));
    }
    double worst = 0;
    for (std::size_t n = 0; n < 6000; ++n) {
        worst = std::max(worst, double{std::abs(outputs[0][n] - outputs[1][n])});
    }
    CHECK(worst < 1e-6);
}

TEST_CASE("Rendering is reproducible to the bit") {
    const auto play = [] {
        return walk(config_for(OutputFormat::foa), nullptr, random_signals(1, 24000, 13)[0], true);
    };
    CHECK(play() == play());
}

TEST_CASE("Reflections beyond the first and the last sample of the response are cut off") {
    // Part of the reverberation, one tap each. Samples before the emission are dropped.
    const double delay = 2.25;
    SourceSound sound;
    sound.early = {path_of(delay, 1), path_of(4795, 0.5F), path_of(4800, 0.5F), path_of(1e7, 0.5F)};
    Player player(config_for(OutputFormat::mono), nullptr, {impulse(16384)});
    player.publish({sound});
    player.play_until(16384);
    Signal expected(16384);
    const std::array<float, kInterpolationTaps> part = FractionalDelay().impulse(0.25);
    for (std::size_t k = 0; k < part.size(); ++k) {
        if (k + 2 >= FractionalDelay::kBefore)
            expected[k + 2 - FractionalDelay::kBefore] += part[k];
    }
    expected[4795] += 0.5F;
    double worst = 0;
    for (std::size_t n = 0; n < expected.size(); ++n) {
        worst = std::max(worst, double{std::abs(player.output(0)[n] - expected[n])});
    }
    // Rounding of the convolution, and of the filter's design.
    CHECK(worst < 1e-5);
}

TEST_CASE("Direct sound can arrive after the end of the response, up to the longest delay") {
    RendererConfig config = config_for(OutputFormat::mono, 1, 1000);
    config.longest_delay_s = 0.2;  // 9600 samples
    for (const double delay : {5000.0, 9600.0, 20000.0}) {
        Player player(config, nullptr, {impulse(24000, 3)});
        SourceSound sound;
        sound.direct = path_of(delay, 0.5F);
        player.publish({sound});
        player.play_until(24000);
        // Longer delays are clamped.
        Signal expected(24000);
        expected[3 + static_cast<std::size_t>(std::min(delay, 9600.0))] = 0.5F;
        CHECK(player.output(0) == expected);
    }
}

TEST_CASE("The tail of a renderer covers its longest path, and its stamp is the newest frame's") {
    RendererConfig config = config_for(OutputFormat::mono, 2, 1000);
    config.longest_delay_s = 1;
    Renderer renderer(config, nullptr);
    RenderFrameBuilder builder(config, nullptr);
    CHECK(renderer.tail_samples() == 1000);
    const Signal silence(256);
    Signal output(256);
    const std::array<const float*, 2> in{silence.data(), silence.data()};
    const std::array<float*, 1> out{output.data()};
    std::int64_t stamp = 0;
    for (const double delay : {300.0, 4000.0, 2000.0}) {
        std::vector<SourceSound> sounds(2);
        sounds[0].direct = path_of(200, 1);
        sounds[1].early = {path_of(delay, 1)};
        sounds[1].early[0].id = 9;
        std::unique_ptr<RenderFrame> frame = builder.make_frame();
        builder.prepare(sounds, *frame);
        frame->stamp = ++stamp;
        renderer.mailbox().publish(std::move(frame));
        for (int block = 0; block < 8; ++block) renderer.render(in, kNoRotation, out, 256);
        CHECK(renderer.newest_stamp() == stamp);
        CHECK(renderer.tail_samples() == static_cast<std::int64_t>(std::max(1000.0, delay)));
    }
}

TEST_CASE("A crossfade ends before the next frame unless frames are shorter than it") {
    for (const double frame_rate_hz : {10.0, 30.0, 50.0, 60.0, 100.0}) {
        for (const int block : {64, 256, 1024}) {
            RendererConfig config = config_for(OutputFormat::mono);
            config.frame_s = 1 / frame_rate_hz;
            config.block = block;
            const RenderShape shape(config, nullptr);
            const double left = kRate_hz / frame_rate_hz - block;
            CAPTURE(frame_rate_hz, block);
            // A frame is at most a block late. A fade has 512 to 1024 samples at 48 kHz.
            CHECK(static_cast<double>(shape.fade_samples) ==
                  Approx(std::clamp(left, 512.0, 1024.0)));
        }
    }
}

TEST_CASE("Twelve reflections of all sources move, one to six of each source") {
    for (const auto& [sources, moving] : {std::pair(1, 6), std::pair(2, 6), std::pair(3, 4),
                                          std::pair(4, 3), std::pair(12, 1), std::pair(50, 1)}) {
        // Whether or not there is room for more sources.
        for (const int room : {sources, 50}) {
            const RendererConfig config =
                config_for(OutputFormat::mono, static_cast<std::size_t>(room));
            RenderFrameBuilder builder(config, nullptr);
            const std::unique_ptr<RenderFrame> frame = builder.make_frame();
            std::vector<SourceSound> sounds(config.sources);
            for (std::size_t s = 0; s < sounds.size(); ++s) {
                sounds[s].absent = s >= static_cast<std::size_t>(sources);
                for (unsigned k = 0; k < 7; ++k) {
                    sounds[s].early.push_back(path_of(400 + 10 * k, 1));
                    sounds[s].early.back().id = 100 + k;
                }
            }
            builder.prepare(sounds, *frame);
            for (std::size_t s = 0; s < sounds.size(); ++s) {
                const auto& paths = frame->parts->paths[s];
                const auto present = std::count_if(
                    paths.begin(), paths.end(), [](const PathSound& path) { return path.present; });
                CAPTURE(sources, room, s);
                CHECK(present == (sounds[s].absent ? 0 : moving));
            }
        }
    }
}

TEST_CASE("A moving reflection is replaced only by one of twice its energy") {
    // Seven reflections for six slots. The output does not reveal which of them move, so the test
    // inspects frames.
    RendererConfig config = config_for(OutputFormat::mono);
    RenderFrameBuilder builder(config, nullptr);
    std::unique_ptr<RenderFrame> frame = builder.make_frame();
    SourceSound sound;
    for (unsigned k = 0; k < 7; ++k) {
        sound.early.push_back(path_of(400 + 10 * k, k == 6 ? 0.9F : 1));
        sound.early.back().id = 100 + k;
    }
    const auto moves = [&](std::uint64_t id) {
        builder.prepare({&sound, 1}, *frame);
        const auto& paths = frame->parts->paths[0];
        return std::any_of(paths.begin(), paths.end(),
                           [&](const PathSound& path) { return path.present && path.id == id; });
    };
    CHECK_FALSE(moves(106));
    sound.early[6].band_gain.fill(1.3F);  // 1.7 times the energy
    CHECK_FALSE(moves(106));
    sound.early[6].band_gain.fill(1.5F);
    CHECK(moves(106));
    // At its former level it keeps moving: no other has twice its energy.
    sound.early[6].band_gain.fill(0.9F);
    CHECK(moves(106));
    // A reflection that ends frees its slot.
    sound.early.pop_back();
    CHECK_FALSE(moves(106));
    for (std::uint64_t id = 100; id < 106; ++id) CHECK(moves(id));
}

TEST_CASE("The gain of a source scales its direct sound, reflections and reverberation") {
    const Signals late = reverberation(4800, 20);
    SourceSound sound = sound_of(late);
    sound.direct = path_of(123.4, 0.7F, {0, 1, 0});
    sound.early = {path_of(345.6, 0.5F, {0, 0, 1}), path_of(456.7, 0.4F)};
    sound.early[0].id = 3;  // on a delay line
    std::array<Signals, 2> outputs;
    for (const bool quiet : {false, true}) {
        sound.gain = quiet ? 0.25F : 1;
        Player player(config_for(OutputFormat::foa), nullptr, random_signals(1, 8192, 21));
        player.publish({sound});
        player.play_until(8192);
        outputs[quiet] = player.outputs();
    }
    for (std::size_t c = 0; c < 4; ++c) {
        CHECK(band_energy(outputs[0][c], 100, 20000, kRate_hz) > 1);
        // Exact: the gain is a power of two.
        for (float& x : outputs[0][c]) x *= 0.25F;
        CHECK(outputs[0][c] == outputs[1][c]);
    }
}

TEST_CASE("A change of a source's gain is crossfaded") {
    SourceSound direct;
    direct.direct = path_of(480, 1);
    Signals late(1, Signal(481));
    late[0][480] = 1;
    SourceSound reflection;
    reflection.early = {path_of(480, 1)};
    for (const SourceSound& sound : {direct, reflection, sound_of(late)}) {
        SourceSound quieter = sound;
        quieter.gain = 0.5F;
        CHECK(crossfade_error(sound, 480, quieter, 480) < 1e-5);  // rounding
        // Companion: the fade is part of the error's definition.
        CHECK(crossfade_error(sound, 480, sound, 480) > 0.4);
    }
}

TEST_CASE("Nothing of an absent source is read, and it is silent after the fade") {
    const std::size_t samples = 24000;
    const Signals inputs = random_signals(2, samples, 22);
    const Signals late = reverberation(2000, 23);
    SourceSound sound = sound_of(late);
    sound.direct = path_of(300, 1);
    // NaN would spread to all of the output.
    const Signals unread(4, Signal(2000, std::nanf("")));
    SourceSound absent = sound_of(unread);
    absent.direct = path_of(300, std::nanf(""));
    absent.early = {path_of(400, std::nanf(""))};
    absent.gain = std::nanf("");
    absent.absent = true;
    // It leaves, stays away for two frames, and returns.
    Player player(config_for(OutputFormat::foa, 2), nullptr, inputs);
    Player alone(config_for(OutputFormat::foa, 2), nullptr, inputs);
    Player both(config_for(OutputFormat::foa, 2), nullptr, inputs);
    for (std::size_t frame = 0; frame < 6; ++frame) {
        const bool away = frame == 1 || frame == 2 || frame == 3;
        player.publish({sound, away ? absent : sound});
        alone.publish({sound, absent});
        both.publish({sound, sound});
        for (Player* const p : {&player, &alone, &both}) p->play_until((frame + 1) * 4000);
    }
    // All levels of the convolution have faded within a frame.
    const auto differs = [&](const Player& other, std::size_t from, std::size_t to) {
        double worst = 0;
        for (std::size_t c = 0; c < 4; ++c) {
            for (std::size_t n = from; n < to; ++n)
                worst = std::max(
                    worst, std::abs(double{player.output(c)[n]} - double{other.output(c)[n]}));
        }
        return worst;
    };
    CHECK(differs(alone, 12000, 16000) < 1e-5);  // rounding
    CHECK(differs(both, 20000, 24000) < 1e-5);
    CHECK(differs(both, 12000, 16000) > 0.1);
    CHECK(differs(alone, 20000, 24000) > 0.1);
}

TEST_CASE("The output of several sources is the sum of those of each one") {
    const std::size_t samples = 8192;
    const Signals inputs = random_signals(3, samples, 24);
    const Signals late = reverberation(3000, 25);
    std::vector<SourceSound> sounds(3, sound_of(late));
    sounds[0].direct = path_of(200.25, 0.7F, {0, 1, 0});
    sounds[1].early = {path_of(900, 0.4F, {0.6F, 0, 0.8F})};
    sounds[2].gain = -0.5F;
    const auto play = [&](std::size_t only) {
        std::vector<SourceSound> some = sounds;
        for (std::size_t s = 0; s < 3; ++s) some[s].absent = only < 3 && s != only;
        Player player(config_for(OutputFormat::foa, 3), nullptr, inputs);
        player.publish(some);
        player.play_until(samples);
        return player.outputs();
    };
    const Signals all = play(3);
    const std::array<Signals, 3> each{play(0), play(1), play(2)};
    double worst = 0;
    for (std::size_t c = 0; c < 4; ++c) {
        for (std::size_t n = 0; n < samples; ++n) {
            const double sum =
                double{each[0][c][n]} + double{each[1][c][n]} + double{each[2][c][n]};
            worst = std::max(worst, std::abs(double{all[c][n]} - sum));
        }
    }
    CHECK(worst < 1e-5);  // rounding
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

TEST_CASE("Half precision of late reverberation has an error of -74 dB") {
    // The largest partitions have 8192 taps: the first level ends before tap 16384.
    Signals late = random_signals(1, 24000, 26);
    std::fill_n(late[0].begin(), 16384, 0.0F);
    const auto play = [&](bool half) {
        RendererConfig config = config_for(OutputFormat::mono, 1, 24000);
        config.half_precision_tail = half;
        Player player(config, nullptr, random_signals(1, 48000, 27));
        player.publish({sound_of(late)});
        player.play_until(48000);
        return player.output(0);
    };
    const Signal exact = play(false);
    const Signal half = play(true);
    double energy = 0;
    double error = 0;
    for (std::size_t n = 0; n < exact.size(); ++n) {
        energy += double{exact[n]} * double{exact[n]};
        error += std::pow(double{half[n]} - double{exact[n]}, 2);
    }
    // Rounding to 11 bits has a variance of 2^-20 / 12 re the square of the power of two below a
    // number, -71.0 dB. The mean of that square is 0.54 of the variance of normal deviates, -2.7
    // dB. 16000 taps: a standard error of 0.05 dB. Single precision has -140 dB.
    CHECK(10 * std::log10(error / energy) == Approx(-73.7).margin(0.2));
}

TEST_CASE("Direct sound has its delay at every sample rate and block size") {
    for (const auto& [rate_hz, block] : {std::pair{8000.0, 1}, {44100.0, 64}, {96000.0, 1000}}) {
        RendererConfig config = config_for(OutputFormat::mono, 1, 100);
        config.sample_rate_hz = rate_hz;
        config.block = block;
        Player player(config, nullptr, {impulse(2000, 5)});
        SourceSound sound;
        sound.direct = DiscretePath{};
        sound.direct->delay_s = 0.01;
        sound.direct->band_gain.fill(0.5F);
        player.publish({sound});
        player.play_until(2000, {static_cast<std::size_t>(block)});
        const auto at = static_cast<std::size_t>(5 + std::lround(0.01 * rate_hz));
        CAPTURE(rate_hz, block);
        for (std::size_t n = 0; n < 2000; ++n) {
            // 0.01 s is a whole number of samples but for rounding.
            if (std::abs(player.output(0)[n] - (n == at ? 0.5F : 0.0F)) > 1e-6F)
                FAIL("sample " << n << ": " << player.output(0)[n]);
        }
    }
}

TEST_CASE("A frame has the nearest whole number of samples, at least one") {
    RendererConfig config;
    for (const auto& [rate_hz, frame_s, samples] : {std::tuple{48000.0, 1.0 / 30, 1600},
                                                    {44100.0, 1.0 / 30, 1470},
                                                    {44100.0, 1.0 / 80, 551},
                                                    {48000.0, 1.0 / 70, 686},
                                                    {48000.0, 1e-6, 1}}) {
        config.sample_rate_hz = rate_hz;
        config.frame_s = frame_s;
        CAPTURE(rate_hz, frame_s);
        CHECK(frame_samples(config) == samples);
    }
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
