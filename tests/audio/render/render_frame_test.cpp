#include "audio/render/render_frame.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/audio/player.h"

using namespace aula;
using namespace aula::test;

namespace {

/// One reflection more than can move, with the identifiers 100 to 106; the last has its own gain.
SourceSound eleven_reflections(float last_gain) {
    SourceSound sound;
    for (unsigned k = 0; k < 11; ++k) {
        sound.early.push_back(path_of(400 + 10 * k, k == 10 ? last_gain : 1));
        sound.early.back().id = 100 + k;
    }
    return sound;
}

}  // namespace

TEST_CASE("Frames have at most four steps, and fades last from step to step") {
    CHECK(frame_steps(config_for(OutputFormat::mono)) == 1);
    for (const auto& [frame_rate_hz, steps] :
         {std::pair(1.0, 4.0), {10.0, 4.0}, {29.0, 3.0}, {30.0, 2.0}, {60.0, 1.0}, {100.0, 1.0}}) {
        RendererConfig config = config_for(OutputFormat::mono);
        config.steps_hz = 60;
        config.frame_s = 1 / frame_rate_hz;
        CAPTURE(frame_rate_hz);
        CHECK(static_cast<double>(frame_steps(config)) == steps);
        // A shorter fade than 512 samples would be audible.
        CHECK(static_cast<double>(RenderShape(config, nullptr).fade_samples) ==
              std::max(512.0, std::floor(kRate_hz / frame_rate_hz / steps)));
    }
    // Frames are not late: the steps of several last no longer than a frame.
    for (const double rate_hz : {8000.0, 16000.0, 44100.0, 48000.0, 96000.0}) {
        for (const double frame_rate_hz : {5.0, 10.0, 25.0, 29.97, 30.0, 50.0, 59.0, 60.0, 100.0}) {
            RendererConfig config = config_for(OutputFormat::mono);
            config.sample_rate_hz = rate_hz;
            config.frame_s = 1 / frame_rate_hz;
            config.steps_hz = 60;
            CAPTURE(rate_hz, frame_rate_hz);
            const RenderShape shape(config, nullptr);
            if (shape.steps > 1)
                CHECK(static_cast<double>(shape.steps * shape.fade_samples) <=
                      rate_hz / frame_rate_hz + 1e-6);
        }
    }
}

TEST_CASE("The steps of a frame follow each other, and the first frame has its last one at once") {
    // The output of a constant is the level of the response.
    RendererConfig config = config_for(OutputFormat::mono);
    config.frame_s = 0.1;
    config.steps_hz = 30;
    RenderFrameBuilder builder(config, nullptr);
    Renderer renderer(config, nullptr);
    const auto publish = [&](const std::array<float, 3>& levels) {
        std::unique_ptr<RenderFrame> frame = builder.make_frame();
        for (std::size_t step = 0; step < 3; ++step) {
            const Signals late{Signal{levels[step]}};
            builder.prepare(0, sound_of(late), 1, *frame, step);
        }
        renderer.mailbox().publish(std::move(frame));
    };
    const Signal input(256, 1.0F);
    Signal heard;
    const auto play_until = [&](std::size_t end) {
        while (heard.size() < end) {
            Signal block(256);
            const float* const in = input.data();
            float* const out = block.data();
            renderer.render({&in, 1}, kNoRotation, {&out, 1}, 256);
            heard.insert(heard.end(), block.begin(), block.end());
        }
    };
    publish({1, 2, 3});
    play_until(4864);
    CHECK(heard[4000] == Approx(3).margin(1e-4));
    publish({6, 7, 5});
    play_until(12000);
    // The frame takes effect at 4864, its steps 1600 samples apart.
    for (const auto& [at, level] :
         {std::pair(4864, 3.0), {5664, 4.5}, {6464, 6.0}, {8064, 7.0}, {9664, 5.0}, {11999, 5.0}}) {
        CAPTURE(at);
        CHECK(heard[static_cast<std::size_t>(at)] == Approx(level).margin(0.01));
    }
}

TEST_CASE("Frames of known times sound as those of any time, in all their steps") {
    const int steps = GENERATE(1, 2, 3, 4);
    CAPTURE(steps);
    constexpr std::size_t kFrame = 4800;
    constexpr std::size_t kCall = 240;
    RendererConfig config = config_for(OutputFormat::mono, 1, 40000);
    config.block = kCall;
    config.frame_s = kFrame / kRate_hz;
    config.steps_hz = 10.0 * steps;
    REQUIRE(frame_steps(config) == static_cast<std::size_t>(steps));
    const Signal input = random_signals(1, 30 * kFrame, 3)[0];

    // Unrelated responses in each step, so that an old one is heard.
    const auto rendered = [&](bool known, bool late) {
        RenderFrameBuilder builder(config, nullptr);
        Renderer renderer(config, nullptr);
        Signal heard(input.size());
        for (std::size_t begin = 0; begin < input.size(); begin += kFrame) {
            std::unique_ptr<RenderFrame> frame = renderer.mailbox().reclaim();
            if (!frame) frame = builder.make_frame();
            const std::size_t told = begin + (late ? kFrame / 2 : 0);
            if (known)
                builder.set_exchange(static_cast<std::int64_t>(told),
                                     static_cast<std::int64_t>(told + kFrame));
            for (std::size_t step = 0; step < static_cast<std::size_t>(steps); ++step) {
                Signals late_part = reverberation(40000, static_cast<unsigned>(begin + step));
                late_part.resize(1);
                late_part[0].resize(builder.step_samples(step));
                builder.prepare(0, sound_of(late_part), 1, *frame, step);
            }
            renderer.mailbox().publish(std::move(frame));
            for (std::size_t n = begin; n < begin + kFrame; n += kCall) {
                const float* const in = input.data() + n;
                float* const out = heard.data() + n;
                renderer.render({&in, 1}, kNoRotation, {&out, 1}, static_cast<int>(kCall));
            }
        }
        return heard;
    };
    const Signal expected = rendered(false, false);
    CHECK((rendered(true, false) == expected));
    // Companion: parts that are needed before the told time are missing. Of longer steps nearly all
    // are prepared at any time.
    if (steps == 4) CHECK((rendered(true, true) != expected));
}

TEST_CASE("Filters of more than 512 MiB have a tail in half precision") {
    // In third order 64 sources have 16 channels each, a tap 4 bytes in either half of a window.
    constexpr std::size_t kTaps = (512U << 20) / (2 * sizeof(float) * 64 * 16);
    RendererConfig config = config_for(OutputFormat::toa, 64, kTaps);
    config.response_samples -= RenderShape(config, nullptr).early_taps;
    CHECK_FALSE(RenderShape(config, nullptr).reverberation.half_precision_tail);
    ++config.response_samples;
    CHECK(RenderShape(config, nullptr).reverberation.half_precision_tail);
}

TEST_CASE("Twenty early paths of all sources move, one to ten of each source") {
    for (const auto& [sources, moving] : {std::pair(1, 10), std::pair(2, 10), std::pair(3, 6),
                                          std::pair(4, 5), std::pair(20, 1), std::pair(50, 1)}) {
        // Whether or not there is room for more sources.
        for (const int room : {sources, 50}) {
            const RendererConfig config =
                config_for(OutputFormat::mono, static_cast<std::size_t>(room));
            RenderFrameBuilder builder(config, nullptr);
            const std::unique_ptr<RenderFrame> frame = builder.make_frame();
            std::vector<SourceSound> sounds(config.sources);
            for (std::size_t s = 0; s < sounds.size(); ++s) {
                sounds[s].absent = s >= static_cast<std::size_t>(sources);
                for (unsigned k = 0; k < 11; ++k) {
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
    // Eleven reflections for ten slots. The output does not reveal which of them move, so the test
    // inspects frames.
    RendererConfig config = config_for(OutputFormat::mono);
    RenderFrameBuilder builder(config, nullptr);
    std::unique_ptr<RenderFrame> frame = builder.make_frame();
    SourceSound sound = eleven_reflections(0.9F);
    const auto moves = [&](std::uint64_t id) {
        builder.prepare({&sound, 1}, *frame);
        const auto& paths = frame->parts->paths[0];
        return std::any_of(paths.begin(), paths.end(),
                           [&](const PathSound& path) { return path.present && path.id == id; });
    };
    CHECK_FALSE(moves(110));
    sound.early[10].band_gain.fill(1.3F);  // 1.7 times the energy
    CHECK_FALSE(moves(110));
    sound.early[10].band_gain.fill(1.5F);
    CHECK(moves(110));
    // At its former level it keeps moving: no other has twice its energy.
    sound.early[10].band_gain.fill(0.9F);
    CHECK(moves(110));
    // A reflection that ends frees its slot.
    sound.early.pop_back();
    CHECK_FALSE(moves(110));
    for (std::uint64_t id = 100; id < 110; ++id) CHECK(moves(id));
}

TEST_CASE("The reflections of a source that was absent are chosen anew") {
    RendererConfig config = config_for(OutputFormat::mono);
    RenderFrameBuilder builder(config, nullptr);
    std::unique_ptr<RenderFrame> frame = builder.make_frame();
    SourceSound sound = eleven_reflections(1.5F);
    const auto last_moves = [&] {
        builder.prepare({&sound, 1}, *frame);
        const auto& paths = frame->parts->paths[0];
        return std::any_of(paths.begin(), paths.end(),
                           [](const PathSound& path) { return path.present && path.id == 110; });
    };
    CHECK(last_moves());
    sound.absent = true;
    CHECK_FALSE(last_moves());
    sound.absent = false;
    sound.early[10].band_gain.fill(0.9F);  // with hysteresis it would move
    CHECK_FALSE(last_moves());
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
