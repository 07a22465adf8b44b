#include "audio/render/render_frame.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <utility>

#include "audio/convolution/partition_levels.h"
#include "audio/dsp/fft.h"
#include "audio/spatial/ambisonic_decoder.h"

namespace aula {

namespace {

// Filters of early reflections contain the absorption of several walls: they resolve 47 Hz.
constexpr double kEarlyFilter_s = 1024.0 / 48000;
// Filters of moving paths run in the time domain and are shorter, to limit the cost, where they
// resolve the octaves: next to walls of steep absorption they are as long as those of early
// reflections.
constexpr double kPathFilter_s = 256.0 / 48000;

// A faster turn of the head would be audible.
constexpr std::size_t kShortestTurn_samples = 64;

// Largest numbers of early paths on delay lines: of all sources, and of one source (the direct
// sound over edges and through a wall, and the strongest of the first order).
constexpr std::size_t kMovingEarly = 20;
constexpr std::size_t kMaxMovingEarly = 10;

// The reverberation changes in all steps of a frame before this tap, 0.17 s at 48 kHz, and in every
// second one after it, where partitions of least cost follow 12 or 6 times a second.
constexpr std::size_t kQuickTaps = 8192;

// Each has a filter.
constexpr double kMostSteps = 4;

constexpr double kPathFade_s = 1024.0 / 48000;
constexpr std::size_t kShortestFade_samples = 512;

// Several filters are in use at a time. Larger ones have a tail of half precision.
constexpr std::size_t kLargeFilter_bytes = std::size_t{512} << 20;

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
            return ambisonic_channels(1);
        case OutputFormat::toa:
            break;
    }
    return ambisonic_channels(kHighestAmbisonicOrder);
}

int field_order(const RendererConfig& config) {
    switch (config.output) {
        case OutputFormat::mono:
            return 0;
        case OutputFormat::foa:
            return 1;
        case OutputFormat::toa:
            return kHighestAmbisonicOrder;
        case OutputFormat::binaural:
            break;
    }
    return config.ambisonic_order;
}

int frame_samples(const RendererConfig& config) {
    return static_cast<int>(std::max(1L, std::lround(config.frame_s * config.sample_rate_hz)));
}

std::size_t frame_steps(const RendererConfig& config) {
    const double most = std::floor(config.frame_s * config.sample_rate_hz /
                                   static_cast<double>(kShortestFade_samples));
    return static_cast<std::size_t>(std::clamp(std::ceil(config.frame_s * config.steps_hz - 1e-6),
                                               1.0, std::clamp(most, 1.0, kMostSteps)));
}

RenderShape::RenderShape(const RendererConfig& config, const Hrtf* hrtf) {
    const bool binaural = config.output == OutputFormat::binaural;
    assert(!binaural || hrtf != nullptr);
    const double rate = config.sample_rate_hz;
    const auto block = static_cast<std::size_t>(config.block);
    lead_samples = binaural ? decoder_lead_samples(rate) : 0;
    early_taps = fast_fft_size(to_samples(kEarlyFilter_s, rate));
    reverberation.inputs = config.sources;
    reverberation.outputs = ambisonic_channels(field_order(config));
    reverberation.block = block;
    reverberation.taps = config.response_samples + early_taps;
    reverberation.quick_taps = kQuickTaps;
    const std::size_t filter_bytes =
        2 * sizeof(float) * reverberation.inputs * reverberation.outputs * reverberation.taps;
    reverberation.half_precision_tail =
        config.half_precision_tail || filter_bytes > kLargeFilter_bytes;
    const std::vector<PartitionLevel> levels = partition_levels(reverberation);
    const auto slow = std::find_if(levels.begin(), levels.end(), [](const PartitionLevel& level) {
        return level.first_tap >= kQuickTaps;
    });
    quick_levels = static_cast<std::size_t>(slow - levels.begin());
    quick_samples = std::min(config.response_samples, std::prev(slow)->end_tap() + lead_samples);

    path.hrtf = binaural ? hrtf : nullptr;
    path.order = field_order(config);
    path.sample_rate_hz = rate;
    path.filter_taps = early_taps;
    path_taps = fast_fft_size(to_samples(kPathFilter_s, rate));
    path.block = block;
    path.frame_samples = static_cast<std::size_t>(frame_samples(config));
    path.turn_samples = std::max(block, kShortestTurn_samples);
    moving_paths = 1 + moving_early_paths(1);
    longest_delay_samples =
        std::max(config.response_samples, to_samples(config.longest_delay_s, rate));

    // From step to step, so that what moves steadily does so without a pause. Very short frames
    // have to wait, since a shorter fade would be audible.
    steps = frame_steps(config);
    const double step_samples = config.frame_s * rate / static_cast<double>(steps);
    fade_samples =
        std::max(kShortestFade_samples, static_cast<std::size_t>(std::floor(step_samples + 1e-6)));
    path_fade_samples = std::min(to_samples(kPathFade_s, rate),
                                 std::max(kShortestFade_samples, path.frame_samples));
}

std::size_t moving_early_paths(std::size_t sources) {
    return std::clamp<std::size_t>(kMovingEarly / std::max<std::size_t>(1, sources), 1,
                                   kMaxMovingEarly);
}

RenderFrame::Parts::Parts(const RenderShape& shape)
    : paths(shape.reverberation.inputs, std::vector<PathSound>(shape.moving_paths)) {
    for (std::size_t step = 0; step < shape.steps; ++step)
        reverberation.emplace_back(shape.reverberation);
    for (std::vector<PathSound>& source : paths) {
        for (PathSound& path : source) path.filter.resize(shape.path.filter_taps);
    }
}

RenderFrame::RenderFrame(std::unique_ptr<Parts> filled) : parts(std::move(filled)) {}

RenderFrame::~RenderFrame() = default;

}  // namespace aula
