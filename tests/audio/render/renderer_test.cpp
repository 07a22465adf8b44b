#include "audio/render/renderer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "audio/dsp/fractional_delay.h"
#include "audio/render/render_frame.h"
#include "tests/audio/convolution/signals.h"
#include "tests/audio/player.h"

using namespace aula;
using namespace aula::test;

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

TEST_CASE("A frame that comes while paths fade waits for them") {
    RendererConfig config = config_for(OutputFormat::mono);
    config.steps_hz = 60;
    Player player(config, nullptr, {Signal(8192, 1.0F)});
    const auto publish = [&](std::uint64_t id, float gain) {
        SourceSound sound;
        sound.direct = path_of(100, gain);
        sound.direct->id = id;
        player.publish({sound});
    };
    // Paths fade for 1024 samples, the reverberation of each half of a frame for 800.
    publish(1, 1);
    player.play_until(1024, {128});
    publish(2, 0);
    player.play_until(1024 + 128, {128});
    publish(3, 1);
    player.play_until(8192, {128});
    const Signal& output = player.output(0);
    float step = 0;
    for (std::size_t n = 200; n < output.size(); ++n)
        step = std::max(step, std::abs(output[n] - output[n - 1]));
    // The steepest step of a raised cosine of 1024 samples, with rounding.
    CHECK(double{step} < 1.01 * std::numbers::pi / 2 / 1024);
    CHECK(output.back() == Approx(1));
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

TEST_CASE("Reflections beyond the first and the last sample of the response are cut off") {
    // Part of the reverberation, one tap each. Samples before the emission are dropped.
    for (const std::size_t whole : {0U, 2U}) {
        SourceSound sound;
        sound.early = {path_of(static_cast<double>(whole) + 0.25, 1), path_of(4795, 0.5F),
                       path_of(4800, 0.5F), path_of(1e7, 0.5F)};
        Player player(config_for(OutputFormat::mono), nullptr, {impulse(16384)});
        player.publish({sound});
        player.play_until(16384);
        Signal expected(16384);
        const std::array<float, kInterpolationTaps> part = FractionalDelay().impulse(0.25);
        for (std::size_t k = 0; k < part.size(); ++k) {
            if (k + whole >= FractionalDelay::kBefore)
                expected[k + whole - FractionalDelay::kBefore] += part[k];
        }
        expected[4795] += 0.5F;
        double worst = 0;
        for (std::size_t n = 0; n < expected.size(); ++n) {
            worst = std::max(worst, double{std::abs(player.output(0)[n] - expected[n])});
        }
        CAPTURE(whole);
        // Rounding of the convolution, and of the filter's design.
        CHECK(worst < 1e-5);
    }
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
        // Frames before the newest one are in use during its fade.
        renderer.render(in, kNoRotation, out, 256);
        CHECK(renderer.tail_samples() == static_cast<std::int64_t>(std::max(1000.0, delay)));
        for (int block = 0; block < 7; ++block) renderer.render(in, kNoRotation, out, 256);
        CHECK(renderer.newest_stamp() == stamp);
        CHECK(renderer.tail_samples() == static_cast<std::int64_t>(std::max(1000.0, delay)));
    }
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
