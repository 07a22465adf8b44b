#include "audio/render_frame.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "audio/ambisonic_decoder.h"
#include "audio/fft.h"

namespace aula {

namespace {

// Early reflections carry several walls' absorption: filters that resolve 47 Hz.
constexpr double kEarlyFilter_s = 1024.0 / 48000;
// Direct sound carries the air's absorption only, which is smooth.
constexpr double kDirectFilter_s = 256.0 / 48000;

constexpr double kFade_s = 1024.0 / 48000;
constexpr std::size_t kShortestFade_samples = 512;

std::size_t to_samples(double seconds, double sample_rate_hz) {
    return static_cast<std::size_t>(std::llround(seconds * sample_rate_hz));
}

}  // namespace

std::size_t channel_count(OutputFormat format) {
    switch (format) {
        case OutputFormat::mono:
            return 1;
        case OutputFormat::binaural:
            return 2;
        case OutputFormat::foa:
            break;
    }
    return 4;
}

int field_order(const RendererConfig& config) {
    switch (config.output) {
        case OutputFormat::mono:
            return 0;
        case OutputFormat::foa:
            return 1;
        case OutputFormat::binaural:
            break;
    }
    return config.ambisonic_order;
}

RenderShape::RenderShape(const RendererConfig& config, const Hrtf* hrtf) {
    const bool binaural = config.output == OutputFormat::binaural;
    assert(!binaural || hrtf != nullptr);
    const double rate = config.sample_rate_hz;
    const auto block = static_cast<std::size_t>(config.block);
    lead_samples = binaural ? decoder_lead_samples(rate) : 0;
    early_taps = fast_fft_size(to_samples(kEarlyFilter_s, rate));
    band_taps = fast_fft_size(to_samples(kDirectFilter_s, rate));

    reverberation.inputs = config.sources;
    reverberation.outputs = ambisonic_channels(field_order(config));
    reverberation.block = block;
    reverberation.taps = config.response_samples + early_taps;

    direct.points = binaural ? 2 : 1;
    direct.outputs = channel_count(config.output);
    direct.filter_taps = binaural ? band_taps + hrtf->taps() - 1 : band_taps;
    direct.block = block;
    direct.frame_samples = std::max<std::size_t>(1, to_samples(config.frame_s, rate));
    direct.longest_delay_samples =
        std::max(config.response_samples, to_samples(config.longest_delay_s, rate));

    // A fade is over before the next frame comes, a block's jitter allowed for; only very short
    // frames have to wait, for a shorter fade would be heard.
    const std::size_t frame_left = direct.frame_samples > block ? direct.frame_samples - block : 0;
    fade_samples = std::max(kShortestFade_samples, std::min(to_samples(kFade_s, rate), frame_left));
}

RenderFrame::Parts::Parts(const RenderShape& shape)
    : reverberation(shape.reverberation), direct(shape.reverberation.inputs) {
    for (DirectSound& sound : direct) {
        for (std::size_t p = 0; p < shape.direct.points; ++p) {
            sound.points[p].filter.resize(shape.direct.filter_taps);
        }
    }
}

RenderFrame::RenderFrame(std::unique_ptr<Parts> filled) : parts(std::move(filled)) {}

RenderFrame::~RenderFrame() = default;

}  // namespace aula
