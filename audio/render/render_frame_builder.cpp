#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <utility>

#include "audio/convolution/partition_levels.h"
#include "audio/dsp/band_filter.h"
#include "audio/dsp/fractional_delay.h"
#include "audio/dsp/kernels.h"
#include "audio/render/early_filters.h"
#include "audio/render/render_frame.h"
#include "audio/render/renderer.h"
#include "audio/spatial/ambisonics.h"

namespace aula {

namespace {

// Of the level of an octave, above which a moving path has a long filter: half of the bound.
constexpr float kLevelError_db = 0.25F;

/// Filters of the reverberation, [channel], of one source.
using Responses = std::vector<AlignedVector<float>>;

}  // namespace

struct RenderFrameBuilder::State {
    State(const RendererConfig& settings, std::shared_ptr<const Hrtf> head)
        : config(settings),
          hrtf(std::move(head)),
          shape(config, hrtf.get()),
          transform(shape.reverberation),
          early_bands(config.sample_rate_hz, shape.early_taps, config.air),
          early_filters(early_bands, static_cast<bool>(config.air), kMargin, config.sources),
          path_bands(config.sample_rate_hz, shape.path_taps, config.air),
          delayed(shape.early_taps + kInterpolationTaps - 1),
          moving(config.sources, std::vector<std::uint64_t>(shape.moving_paths - 1)),
          absent(config.sources, 1),
          levels(shape.steps) {
        expect_exchange_at_any_time();
    }

    RendererConfig config;
    std::shared_ptr<const Hrtf> hrtf;  ///< kept alive
    RenderShape shape;
    FilterTransform transform;
    BandFilterDesigner early_bands;
    EarlyFilters early_filters;
    BandFilterDesigner path_bands;
    FractionalDelay interpolator;

    static constexpr std::size_t kMargin = kInterpolationTaps - 1;  // of filters of early paths
    AlignedVector<float> delayed;
    std::vector<std::vector<std::uint64_t>> moving;  ///< [source][slot] moving early paths, 0: none
    std::vector<char> absent;                        ///< [source] in the frame before
    std::vector<std::vector<char>> levels;  ///< [step] of the reverberation, those that it sets

    void expect_exchange_at_any_time();
    void choose_moving(std::size_t source, std::span<const DiscretePath> early, std::size_t max);
    void omit(std::size_t source, RenderFrame& frame, std::size_t step);
    void add_early(std::size_t source, const DiscretePath& path, float gain, Responses& responses);
    void prepare_path(const DiscretePath& path, float gain, PathSound& sound);
};

RenderFrameBuilder::RenderFrameBuilder(const RendererConfig& config,
                                       std::shared_ptr<const Hrtf> hrtf)
    : state_(std::make_unique<State>(config, std::move(hrtf))) {}

RenderFrameBuilder::~RenderFrameBuilder() = default;

void RenderFrameBuilder::restart() {
    for (std::vector<std::uint64_t>& slots : state_->moving)
        std::fill(slots.begin(), slots.end(), 0);
    std::fill(state_->absent.begin(), state_->absent.end(), 1);
    state_->expect_exchange_at_any_time();
}

std::unique_ptr<RenderFrame> RenderFrameBuilder::make_frame() const {
    return std::make_unique<RenderFrame>(std::make_unique<RenderFrame::Parts>(state_->shape));
}

void RenderFrameBuilder::set_exchange(std::int64_t first, std::int64_t next) {
    if (first == 0) return state_->expect_exchange_at_any_time();
    const RenderShape& shape = state_->shape;
    // Frames take effect up to a block later.
    const auto block = static_cast<std::int64_t>(shape.path.block);
    const auto steps = static_cast<std::int64_t>(shape.steps);
    for (std::int64_t step = 0; step < steps; ++step) {
        const auto index = static_cast<std::size_t>(step);
        const auto begins = [&](std::int64_t n) { return first + (next - first) * n / steps; };
        const auto levels_until = [&](std::int64_t end) {
            // An exchange within the fade of the one before it waits.
            const bool waits =
                begins(end) - begins(step) < static_cast<std::int64_t>(shape.fade_samples);
            return levels_in_use(shape.reverberation, shape.fade_samples, begins(step),
                                 waits ? begins(step) : begins(end) + block);
        };
        std::vector<char>& levels = state_->levels[index];
        levels = levels_until(step + 1);
        // The slow levels of a whole step are those of the step after it, too.
        const std::vector<char> slow = levels_until(step + (steps > 1 ? 2 : 1));
        for (std::size_t l = shape.quick_levels; l < levels.size(); ++l)
            levels[l] = shape.is_whole(index) ? slow[l] : 0;
    }
}

/// All levels of whole steps can be in use, and the quick levels of the others.
void RenderFrameBuilder::State::expect_exchange_at_any_time() {
    const std::size_t count = partition_levels(shape.reverberation).size();
    for (std::size_t step = 0; step < shape.steps; ++step) {
        levels[step].assign(count, 1);
        if (shape.is_whole(step)) continue;
        std::fill(levels[step].begin() + static_cast<std::ptrdiff_t>(shape.quick_levels),
                  levels[step].end(), 0);
    }
}

std::size_t RenderFrameBuilder::step_samples(std::size_t step) const {
    const RenderShape& shape = state_->shape;
    return shape.is_whole(step) ? state_->config.response_samples : shape.quick_samples;
}

void RenderFrameBuilder::prepare(std::span<const SourceSound> sources, RenderFrame& frame) {
    assert(sources.size() == state_->config.sources);
    const auto present = static_cast<std::size_t>(std::count_if(
        sources.begin(), sources.end(), [](const auto& source) { return !source.absent; }));
    for (std::size_t step = 0; step < state_->shape.steps; ++step)
        for (std::size_t i = 0; i < sources.size(); ++i)
            prepare(i, sources[i], present, frame, step);
}

void RenderFrameBuilder::prepare(std::size_t index, const SourceSound& source, std::size_t present,
                                 RenderFrame& frame, std::size_t step) {
    State& s = *state_;
    if (source.absent) return s.omit(index, frame, step);
    s.absent[index] = 0;
    // Not kept: of 16 channels it would be a fifth of a renderer's memory.
    Responses responses(s.shape.reverberation.outputs,
                        AlignedVector<float>(s.shape.reverberation.taps));
    for (std::size_t c = 0; c < responses.size(); ++c) {
        const std::span<const float> in = source.ambisonics[c];
        assert(in.size() <= s.config.response_samples);
        // Sound that arrives within the decoder's lead cannot be rendered in time. It is delayed by
        // the lead.
        const auto lead = static_cast<std::ptrdiff_t>(std::min(s.shape.lead_samples, in.size()));
        const auto end = std::transform(in.begin() + lead, in.end(), responses[c].begin(),
                                        [&](float x) { return source.gain * x; });
        std::fill(end, responses[c].end(), 0.0F);
        for (std::ptrdiff_t n = 0; n < lead; ++n) {
            responses[c][static_cast<std::size_t>(n)] +=
                source.gain * in[static_cast<std::size_t>(n)];
        }
    }

    std::vector<PathSound>& paths = frame.parts->paths[index];
    for (PathSound& path : paths) path.present = false;
    const bool is_last = step + 1 == s.shape.steps;
    if (source.direct && is_last) s.prepare_path(*source.direct, source.gain, paths[0]);
    if (step == 0) {
        s.early_filters.next_frame(index);
        s.choose_moving(index, source.early, moving_early_paths(present));
    }
    for (const DiscretePath& path : source.early) {
        const auto slot = std::find(s.moving[index].begin(), s.moving[index].end(), path.id);
        if (path.id != 0 && slot != s.moving[index].end()) {
            if (!is_last) continue;
            s.prepare_path(path, source.gain,
                           paths[1 + static_cast<std::size_t>(slot - s.moving[index].begin())]);
        } else {
            s.add_early(index, path, source.gain, responses);
        }
    }
    const std::vector<std::span<const float>> views(responses.begin(), responses.end());
    s.transform.transform(views, index, frame.parts->reverberation[step], s.levels[step]);
}

void RenderFrameBuilder::State::omit(std::size_t source, RenderFrame& frame, std::size_t step) {
    for (PathSound& path : frame.parts->paths[source]) path.present = false;
    std::fill(moving[source].begin(), moving[source].end(), 0);
    early_filters.next_frame(source);
    if (absent[source]) {
        transform.repeat(source, frame.parts->reverberation[step]);
        return;
    }
    absent[source] = 1;
    // All levels, so that later frames can repeat them.
    const std::vector<std::span<const float>> silence(shape.reverberation.outputs);
    transform.transform(silence, source, frame.parts->reverberation[step]);
}

/// Assigns the strongest `max` early paths to slots of moving paths. A path keeps its slot while it
/// moves.
void RenderFrameBuilder::State::choose_moving(std::size_t source,
                                              std::span<const DiscretePath> early,
                                              std::size_t max) {
    // Hysteresis: a moving path is replaced only by one of twice its energy.
    constexpr float kHysteresis = 2;
    std::vector<std::uint64_t>& slots = moving[source];
    std::vector<std::pair<float, std::uint64_t>> strongest;
    for (const DiscretePath& path : early) {
        if (path.id == 0) continue;
        float energy = 0;
        for (const float gain : path.band_gain) energy += gain * gain;
        if (std::find(slots.begin(), slots.end(), path.id) != slots.end()) energy *= kHysteresis;
        strongest.emplace_back(energy, path.id);
    }
    std::sort(strongest.begin(), strongest.end(), std::greater<>());
    strongest.resize(std::min(strongest.size(), max));
    const auto chosen = [&](std::uint64_t id) {
        return std::any_of(strongest.begin(), strongest.end(),
                           [&](const auto& s) { return s.second == id; });
    };
    for (std::uint64_t& id : slots) {
        if (!chosen(id)) id = 0;
    }
    for (const auto& [energy, id] : strongest) {
        if (std::find(slots.begin(), slots.end(), id) != slots.end()) continue;
        *std::find(slots.begin(), slots.end(), 0U) = id;
    }
}

void RenderFrameBuilder::State::add_early(std::size_t source, const DiscretePath& path, float gain,
                                          Responses& responses) {
    const double delay = std::max(
        0.0, path.delay_s * config.sample_rate_hz - static_cast<double>(shape.lead_samples));
    const double whole = std::floor(delay);
    if (whole >= static_cast<double>(config.response_samples)) return;

    const float greatest = *std::max_element(path.band_gain.begin(), path.band_gain.end());
    if (!(greatest > 0)) return;
    const std::span<const float> shaped =
        early_filters.filter(source, path.band_gain, double{path.length_m});
    const std::array<float, kInterpolationTaps> impulse = interpolator.impulse(delay - whole);
    const std::size_t delayed_samples = shaped.size() - kMargin;
    filter(shaped.data() + kMargin, impulse.data(), impulse.size(), delayed.data(),
           delayed_samples);

    // The interpolator's impulse is delayed by kBefore samples. Samples before the emission are
    // dropped.
    const auto start =
        static_cast<std::ptrdiff_t>(whole) - static_cast<std::ptrdiff_t>(FractionalDelay::kBefore);
    const std::size_t skipped = start < 0 ? static_cast<std::size_t>(-start) : 0;
    const std::size_t first = start < 0 ? 0 : static_cast<std::size_t>(start);
    const std::size_t count = std::min(delayed_samples - skipped, shape.reverberation.taps - first);
    const auto encoding = encode_direction(path.direction);
    for (std::size_t c = 0; c < responses.size(); ++c) {
        const float weight = gain * greatest * encoding[c];
        for (std::size_t n = 0; n < count; ++n) {
            responses[c][first + n] += weight * delayed[skipped + n];
        }
    }
}

void RenderFrameBuilder::State::prepare_path(const DiscretePath& path, float gain,
                                             PathSound& sound) {
    sound.present = true;
    sound.id = path.id;
    sound.delay_samples =
        std::clamp(path.delay_s * config.sample_rate_hz, DelayLine::kShortest_samples,
                   static_cast<double>(shape.longest_delay_samples));
    sound.direction = path.direction;
    sound.distance_m = path.length_m;
    const std::span<float> filter = sound.filter;
    sound.taps = shape.path_taps;
    const float error_db =
        path_bands.design(path.band_gain, double{path.length_m}, filter.first(sound.taps));
    if (error_db > kLevelError_db) {
        sound.taps = filter.size();
        early_bands.design(path.band_gain, double{path.length_m}, filter);
    }
    for (float& x : filter.first(sound.taps)) x *= gain;
}

}  // namespace aula
