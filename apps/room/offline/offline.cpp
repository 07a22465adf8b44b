#include "apps/room/offline/offline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "apps/output/formatted.h"
#include "apps/room/auralizer/auralizer_options.h"
#include "apps/room/base/patch_warning.h"
#include "apps/room/frames/ray_budget.h"
#include "apps/room/frames/signals.h"
#include "apps/room/frames/timeline.h"
#include "audio/dsp/limiter.h"
#include "aula/audio/realtime.h"

namespace aula {

namespace {

/// Planar buffers of one block, and pointers to them for the audio functions.
struct PlanarBlock {
    PlanarBlock(std::size_t channel_count, std::size_t sample_count)
        : samples(channel_count, std::vector<float>(sample_count)) {
        for (auto& channel : samples) pointers.push_back(channel.data());
    }
    std::vector<std::vector<float>> samples;
    std::vector<float*> pointers;
};

/// The signals of all sources, block by block, as input to an auralizer.
class SignalReader {
 public:
    SignalReader(const SignalSet& signals, const Timeline& timeline, const Auralizer& auralizer,
                 int block)
        : signals_(signals),
          timeline_(timeline),
          rate_hz_(auralizer.sample_rate_hz()),
          samples_(signals.size(), static_cast<std::size_t>(block)) {
        const std::vector<SourceId> sources = auralizer.sources();
        for (std::size_t s = 0; s < signals.size(); ++s)
            inputs_.push_back({sources[s], samples_.pointers[s]});
    }

    /// Reads the block that starts at sample `first`.
    std::span<const SourceSignal> read(std::int64_t first) {
        for (std::size_t s = 0; s < signals_.size(); ++s) {
            signals_[s]->read(first, first, samples_.samples[s]);
            timeline_.fade(first, rate_hz_, samples_.samples[s]);
        }
        return inputs_;
    }

 private:
    const SignalSet& signals_;
    const Timeline& timeline_;
    double rate_hz_;
    PlanarBlock samples_;
    std::vector<SourceSignal> inputs_;
};

}  // namespace

struct OfflineRendering::State {
    State(const Scene& scene, SignalSet signal_set, const PlaybackOptions& given)
        : options(given),
          signals(std::move(signal_set)),
          auralizer(scene, exact_options(scene, options)),
          timeline(offline_timeline({.scene = scene,
                                     .signals = signals,
                                     .sample_rate_hz = options.sample_rate_hz,
                                     .response_length_s = auralizer.heard_length_s(),
                                     .duration_s = options.duration_s})),
          samples(std::llround(timeline.end_s * options.sample_rate_hz)) {}

    static AuralizerOptions exact_options(const Scene& scene, const PlaybackOptions& options) {
        AuralizerOptions settings = auralizer_options(scene, options);
        settings.clock = RenderClock::exact;
        settings.before_frame = follow_paths(scene);
        return settings;
    }

    PlaybackOptions options;
    SignalSet signals;
    Auralizer auralizer;
    Timeline timeline;
    std::int64_t samples;
};

OfflineRendering::OfflineRendering(const Scene& scene, SignalSet signals,
                                   const PlaybackOptions& options)
    : state_(std::make_unique<State>(scene, std::move(signals), options)) {}

OfflineRendering::~OfflineRendering() = default;

std::int64_t OfflineRendering::samples() const { return state_->samples; }

AuralizerStatus OfflineRendering::status() const { return state_->auralizer.status(); }

float OfflineRendering::patch_size_m() const { return state_->auralizer.patch_size_m(); }

bool OfflineRendering::render(const Sink& sink, const Progress& progress) {
    State& s = *state_;
    const int block = s.options.block;
    const std::size_t channels = channel_count(s.options.output);
    SignalReader reader(s.signals, s.timeline, s.auralizer, block);

    const FlushDenormals flush;
    std::optional<Limiter> limiter;
    if (s.options.format != SampleFormat::float32)
        limiter.emplace(s.options.sample_rate_hz, channels, block);
    // The latency is removed from the start and added at the end.
    std::int64_t skip = s.auralizer.latency_samples() + (limiter ? limiter->latency_samples() : 0);
    const std::int64_t total = s.samples + skip;
    // Only the paths cause changes, so that frames can be computed ahead.
    s.auralizer.commit(s.samples);
    PlanarBlock output(channels, static_cast<std::size_t>(block));
    std::vector<std::span<const float>> rendered(channels);
    for (std::int64_t first = 0; first < total; first += block) {
        s.auralizer.render(reader.read(first), output.pointers, block);
        if (limiter) limiter->process(output.pointers, block);
        const std::int64_t end = std::min<std::int64_t>(block, total - first);
        const std::int64_t begin = std::min(skip, end);
        skip -= begin;
        for (std::size_t c = 0; c < channels; ++c)
            rendered[c] = std::span<const float>(output.samples[c])
                              .subspan(static_cast<std::size_t>(begin),
                                       static_cast<std::size_t>(end - begin));
        if (begin < end) sink(rendered);
        if (progress && !progress(static_cast<double>(first + end) / static_cast<double>(total)))
            return false;
    }
    return true;
}

std::optional<std::vector<std::string>> render_offline(const Scene& scene,
                                                       const PlaybackOptions& options,
                                                       const std::filesystem::path& file,
                                                       const Progress& progress) {
    std::optional<std::uint64_t> dither_seed;
    if (options.dither) dither_seed = scene.simulation.seed;
    WavWriter writer(file, options.sample_rate_hz, channel_count(options.output), options.format,
                     dither_seed);
    const SignalSet signals = read_signals(scene, options.sample_rate_hz);
    OfflineRendering rendering(scene, signals, options);
    std::vector<float> interleaved;
    bool silent = true;
    const auto write = [&](std::span<const std::span<const float>> channels) {
        interleaved.clear();
        for (std::size_t i = 0; i < channels[0].size(); ++i)
            for (const auto& channel : channels) interleaved.push_back(channel[i]);
        silent = silent && std::all_of(interleaved.begin(), interleaved.end(),
                                       [](float sample) { return sample == 0; });
        writer.write(interleaved);
    };
    if (!rendering.render(write, progress)) return std::nullopt;
    std::vector<std::string> warnings = warnings_of(signals);
    warn_of_patch_size(scene.simulation, rendering.patch_size_m(), warnings);
    const AuralizerStatus status = rendering.status();
    if (std::string text = over_budget_text(scene.simulation, scene.sources.size(), status.rays,
                                            status.counted_mean_ms / 1000);
        !text.empty())
        warnings.push_back(std::move(text));
    const std::int64_t muted = status.muted_samples + writer.muted_samples();
    if (muted > 0)
        warnings.push_back(muted_text(muted));
    else if (silent)
        warnings.push_back(file.string() +
                           ": is silent; aula check tells if sound can reach the listener");
    writer.commit();
    return warnings;
}

}  // namespace aula
