#include "apps/session/offline/offline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "apps/session/auralizer/auralizer_options.h"
#include "apps/session/base/formatted.h"
#include "apps/session/frames/signals.h"
#include "apps/session/frames/timeline.h"
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

std::optional<std::vector<std::string>> render_offline(const Scene& scene,
                                                       const SessionOptions& options,
                                                       const std::filesystem::path& file,
                                                       const Progress& progress) {
    const double rate_hz = options.sample_rate_hz;
    const std::size_t channels = channel_count(options.output);
    WavWriter writer(file, rate_hz, channels, options.format);
    const SignalSet signals = read_signals(scene, rate_hz);
    AuralizerOptions settings = auralizer_options(scene, options, rate_hz);
    settings.clock = RenderClock::exact;
    settings.before_frame = follow_paths(scene);
    Auralizer auralizer(scene, settings);
    const Timeline timeline = offline_timeline({.scene = scene,
                                                .signals = signals,
                                                .sample_rate_hz = rate_hz,
                                                .response_length_s = auralizer.response_length_s(),
                                                .duration_s = options.duration_s});
    SignalReader reader(signals, timeline, auralizer, options.block);

    const FlushDenormals flush;
    std::optional<Limiter> limiter;
    if (options.format != SampleFormat::float32) limiter.emplace(rate_hz, channels, options.block);
    // The latency is removed from the start and added at the end.
    std::int64_t skip = auralizer.latency_samples() + (limiter ? limiter->latency_samples() : 0);
    const std::int64_t end_samples = std::llround(timeline.end_s * rate_hz);
    const std::int64_t total = end_samples + skip;
    // Only the paths cause changes, so that frames can be computed ahead.
    auralizer.commit(end_samples);
    PlanarBlock output(channels, static_cast<std::size_t>(options.block));
    std::vector<float> interleaved;
    std::int64_t muted = 0;
    for (std::int64_t first = 0; first < total; first += options.block) {
        auralizer.render(reader.read(first), output.pointers, options.block);
        if (limiter) {
            limiter->process(output.pointers, options.block);
            muted += static_cast<std::int64_t>(limiter->muted_samples());
        }
        const std::int64_t end = std::min<std::int64_t>(options.block, total - first);
        interleaved.clear();
        for (std::int64_t i = std::min(skip, end); i < end; ++i)
            for (const auto& channel : output.samples)
                interleaved.push_back(channel[static_cast<std::size_t>(i)]);
        skip -= std::min(skip, end);
        writer.write(interleaved);
        if (progress && !progress(static_cast<double>(first + end) / static_cast<double>(total)))
            return std::nullopt;
    }
    std::vector<std::string> warnings = warnings_of(signals);
    if (muted += writer.muted_samples(); muted > 0) warnings.push_back(muted_text(muted));
    writer.commit();
    return warnings;
}

}  // namespace aula
