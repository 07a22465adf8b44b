#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "audio/ambisonics.h"
#include "audio/band_filter.h"
#include "audio/fractional_delay.h"
#include "audio/kernels.h"
#include "audio/render_frame.h"
#include "audio/renderer.h"

namespace aula {

struct RenderFrameBuilder::State {
    State(const RendererConfig& settings, std::shared_ptr<const Hrtf> head)
        : config(settings),
          hrtf(std::move(head)),
          shape(config, hrtf.get()),
          transform(shape.reverberation),
          early_bands(config.sample_rate_hz, shape.early_taps),
          direct_bands(config.sample_rate_hz, shape.band_taps),
          early(kInterpolationTaps - 1 + shape.early_taps + kInterpolationTaps - 1),
          delayed(shape.early_taps + kInterpolationTaps - 1),
          bands(shape.band_taps),
          // A filter of the ears is run through the band filter: silence around it.
          head_response(2 * shape.direct.filter_taps) {
        for (std::size_t c = 0; c < shape.reverberation.outputs; ++c) {
            responses.emplace_back(shape.reverberation.taps);
        }
    }

    RendererConfig config;
    std::shared_ptr<const Hrtf> hrtf;
    RenderShape shape;
    FilterTransform transform;
    BandFilterDesigner early_bands;
    BandFilterDesigner direct_bands;
    FractionalDelay interpolator;

    std::vector<AlignedVector<float>> responses;  ///< [channel] of the source in hand
    AlignedVector<float> early;                   ///< band filter between zeros
    AlignedVector<float> delayed;
    AlignedVector<float> bands;
    AlignedVector<float> head_response;

    void add_early(const DiscretePath& path, float gain);
    void prepare_direct(const DiscretePath& path, float gain, const HeadRotation& head,
                        DirectSound& sound);
};

RenderFrameBuilder::RenderFrameBuilder(const RendererConfig& config,
                                       std::shared_ptr<const Hrtf> hrtf)
    : state_(std::make_unique<State>(config, std::move(hrtf))) {}

RenderFrameBuilder::~RenderFrameBuilder() = default;

std::unique_ptr<RenderFrame> RenderFrameBuilder::make_frame() const {
    return std::make_unique<RenderFrame>(std::make_unique<RenderFrame::Parts>(state_->shape));
}

void RenderFrameBuilder::prepare(std::span<const SourceSound> sources, const HeadRotation& head,
                                 RenderFrame& frame) {
    State& s = *state_;
    assert(sources.size() == s.config.sources);
    for (std::size_t i = 0; i < sources.size(); ++i) {
        const SourceSound& source = sources[i];
        for (std::size_t c = 0; c < s.responses.size(); ++c) {
            const std::span<const float> in = source.ambisonics[c];
            assert(in.size() <= s.config.response_samples);
            // What comes within the decoder's lead of the emission is lost.
            const auto lead =
                static_cast<std::ptrdiff_t>(std::min(s.shape.lead_samples, in.size()));
            const auto end = std::transform(in.begin() + lead, in.end(), s.responses[c].begin(),
                                            [&](float x) { return source.gain * x; });
            std::fill(end, s.responses[c].end(), 0.0F);
        }
        for (const DiscretePath& path : source.early) s.add_early(path, source.gain);
        const std::vector<std::span<const float>> views(s.responses.begin(), s.responses.end());
        s.transform.transform(views, i, frame.parts->reverberation);

        DirectSound& direct = frame.parts->direct[i];
        direct.present = source.direct.has_value();
        if (direct.present) s.prepare_direct(*source.direct, source.gain, head, direct);
    }
}

void RenderFrameBuilder::State::add_early(const DiscretePath& path, float gain) {
    const double delay = std::max(
        0.0, path.delay_s * config.sample_rate_hz - static_cast<double>(shape.lead_samples));
    const double whole = std::floor(delay);
    if (whole >= static_cast<double>(config.response_samples)) return;

    constexpr std::size_t kMargin = kInterpolationTaps - 1;
    early_bands.design(path.band_gain, std::span(early).subspan(kMargin, shape.early_taps));
    const std::array<float, kInterpolationTaps> impulse = interpolator.impulse(delay - whole);
    filter(early.data() + kMargin, impulse.data(), impulse.size(), delayed.data(), delayed.size());

    // The interpolator's impulse comes kBefore samples late; what would come before the emission
    // is cut off.
    const auto start =
        static_cast<std::ptrdiff_t>(whole) - static_cast<std::ptrdiff_t>(FractionalDelay::kBefore);
    const std::size_t skipped = start < 0 ? static_cast<std::size_t>(-start) : 0;
    const std::size_t first = start < 0 ? 0 : static_cast<std::size_t>(start);
    const std::size_t count = std::min(delayed.size() - skipped, shape.reverberation.taps - first);
    const auto encoding = encode_direction(path.direction);
    for (std::size_t c = 0; c < responses.size(); ++c) {
        const float weight = gain * encoding[c];
        for (std::size_t n = 0; n < count; ++n) {
            responses[c][first + n] += weight * delayed[skipped + n];
        }
    }
}

void RenderFrameBuilder::State::prepare_direct(const DiscretePath& path, float gain,
                                               const HeadRotation& head, DirectSound& sound) {
    direct_bands.design(path.band_gain, bands);
    for (float& x : bands) x *= gain;
    const std::array<float, 3> direction = in_head_axes(head, path.direction);
    const auto place = [&](double delay_s) {
        return std::clamp(delay_s * config.sample_rate_hz, DirectPath::kShortestDelay_samples,
                          static_cast<double>(shape.direct.longest_delay_samples));
    };
    if (config.output != OutputFormat::binaural) {
        sound.points[0].delay_samples = place(path.delay_s);
        std::copy(bands.begin(), bands.end(), sound.points[0].filter.begin());
        const auto encoding = encode_direction(direction);
        std::copy_n(encoding.begin(), sound.encoding.size(), sound.encoding.begin());
        return;
    }
    const std::array<Hrtf::Ear, 2> ears = hrtf->ears(direction);
    for (std::size_t e = 0; e < 2; ++e) {
        sound.points[e].delay_samples = place(path.delay_s + ears[e].delay_s);
        const std::size_t margin = bands.size() - 1;
        std::fill(head_response.begin(), head_response.end(), 0.0F);
        std::copy(ears[e].minimum_phase.begin(), ears[e].minimum_phase.end(),
                  head_response.begin() + static_cast<std::ptrdiff_t>(margin));
        filter(head_response.data() + margin, bands.data(), bands.size(),
               sound.points[e].filter.data(), shape.direct.filter_taps);
    }
}

}  // namespace aula
