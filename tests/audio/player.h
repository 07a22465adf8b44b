#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "audio/convolution/convolver_levels.h"
#include "audio/render/renderer.h"
#include "tests/audio/convolution/signals.h"

namespace aula::test {

inline constexpr double kRate_hz = 48000;
inline constexpr double kSpeed_m_s = 343.2;

inline RendererConfig config_for(OutputFormat output, std::size_t sources = 1,
                                 std::size_t response_samples = 4800) {
    RendererConfig config;
    config.sample_rate_hz = kRate_hz;
    config.block = 256;
    config.sources = sources;
    config.response_samples = response_samples;
    config.output = output;
    return config;
}

inline DiscretePath path_of(double delay_samples, float gain,
                            std::array<float, 3> direction = {1, 0, 0}) {
    DiscretePath path;
    path.delay_s = delay_samples / kRate_hz;
    path.direction = direction;
    path.band_gain.fill(gain);
    return path;
}

inline Signal impulse(std::size_t samples, std::size_t at = 0) {
    Signal signal(samples);
    signal[at] = 1;
    return signal;
}

/// Decaying noise with an energy of 1 in W and 1/3 in the other channels.
inline Signals reverberation(std::size_t samples, unsigned seed) {
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

/// Renders signals in calls whose sizes cycle through a list. Frames can be published between
/// calls.
class Player {
 public:
    Player(const RendererConfig& config, const std::shared_ptr<const Hrtf>& hrtf, Signals inputs)
        : builder_(config, hrtf),
          renderer_(config, hrtf),
          inputs_(std::move(inputs)),
          outputs_(channel_count(config.output), Signal(inputs_[0].size())) {}

    void publish(const std::vector<SourceSound>& sources) {
        std::unique_ptr<RenderFrame> frame = renderer_.mailbox().reclaim();
        if (!frame) frame = builder_.make_frame();
        builder_.prepare(sources, *frame);
        renderer_.mailbox().publish(std::move(frame));
    }

    void play_until(std::size_t end, const std::vector<std::size_t>& calls = {256},
                    const HeadRotation& head = kNoRotation) {
        for (std::size_t turn = 0; done_ < end; ++turn) {
            const std::size_t samples = std::min(calls[turn % calls.size()], end - done_);
            std::vector<const float*> in;
            std::vector<float*> out;
            for (const Signal& signal : inputs_) in.push_back(signal.data() + done_);
            for (Signal& signal : outputs_) out.push_back(signal.data() + done_);
            renderer_.render(in, head, out, static_cast<int>(samples));
            done_ += samples;
        }
    }

    const Signal& output(std::size_t channel) const { return outputs_[channel]; }
    const Signals& outputs() const { return outputs_; }
    std::size_t done() const { return done_; }

 private:
    RenderFrameBuilder builder_;
    Renderer renderer_;
    Signals inputs_;
    Signals outputs_;
    std::size_t done_ = 0;
};

inline SourceSound sound_of(const Signals& ambisonics) {
    SourceSound sound;
    for (std::size_t c = 0; c < ambisonics.size(); ++c) sound.ambisonics[c] = ambisonics[c];
    return sound;
}

/// The largest deviation of a 1 kHz tone, whose delay changes and whose gain halves, from a
/// crossfade with these weights.
inline double crossfade_error(const SourceSound& before, double delay_before,
                              const SourceSound& after, double delay_after,
                              const std::vector<float>& weights = raised_cosine(1024)) {
    constexpr std::size_t kSamples = 12000;
    constexpr std::size_t kChange = 5120;
    Player player(config_for(OutputFormat::mono), nullptr, {sine(1000, kSamples, kRate_hz)});
    player.publish({before});
    player.play_until(kChange);
    player.publish({after});
    player.play_until(kSamples);
    double worst = 0;
    for (std::size_t n = 3000; n < kSamples; ++n) {
        const std::size_t at = n - std::min(n, kChange);
        const double w = n < kChange ? 0 : at < weights.size() ? double{weights[at]} : 1;
        const auto tone = [&](double delay) {
            return std::sin(2 * std::numbers::pi * 1000 * (static_cast<double>(n) - delay) /
                            kRate_hz);
        };
        const double expected = (1 - w) * tone(delay_before) + w * 0.5 * tone(delay_after);
        worst = std::max(worst, std::abs(double{player.output(0)[n]} - expected));
    }
    return worst;
}

}  // namespace aula::test
