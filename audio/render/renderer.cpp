#include "audio/render/renderer.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "audio/dsp/fade.h"
#include "audio/render/frame_phase.h"
#include "audio/render/render_frame.h"

namespace aula {

namespace {

/// Decodes ambisonics in head axes to two ears.
class Decoder {
 public:
    Decoder(const RendererConfig& config, const Hrtf& hrtf)
        : Decoder(static_cast<std::size_t>(config.block), hrtf.decoder(field_order(config))) {}

    void process(std::span<const float* const> field, std::span<float* const> ears,
                 std::size_t samples) noexcept AULA_NONBLOCKING {
        convolver_.process(field, ears, samples);
    }

 private:
    Decoder(std::size_t block, const AmbisonicDecoder& filters)
        : shape_{filters[0].size(), 2, block, filters[0][0].size()},
          filter_(shape_),
          convolver_(shape_, 0) {
        FilterTransform transform(shape_);
        for (std::size_t c = 0; c < shape_.inputs; ++c) {
            const std::array<std::span<const float>, 2> ears{filters[0][c], filters[1][c]};
            transform.transform(ears, c, filter_);
        }
        convolver_.exchange(&filter_);
    }

    ConvolutionShape shape_;
    ConvolutionFilter filter_;
    Convolver convolver_;
};

}  // namespace

struct Renderer::State {
    State(const RendererConfig& settings, std::shared_ptr<const Hrtf> head)
        : config(settings),
          hrtf(std::move(head)),
          shape(settings, hrtf.get()),
          reverberation(shape.reverberation, shape.fade_samples),
          held(reverberation.max_filters()),
          phase(shape.path.frame_samples, shape.path.block, shape.fade_samples),
          rotation(field_order(settings), shape.path.turn_samples),
          ambisonics(ambisonic_channels(field_order(settings))) {
        // A path that starts reads the history of its filter, delayed further for each ear.
        const std::size_t history = 2 * shape.path.filter_taps;
        const Fade fade(shape.fade_samples);
        for (std::size_t i = 0; i < config.sources; ++i) {
            lines.emplace_back(interpolator, shape.longest_delay_samples, history,
                               shape.path.block);
            paths.emplace_back(shape.moving_paths, MovingPath(shape.path, fade));
        }
        const auto block = static_cast<std::size_t>(config.block);
        for (AlignedVector<float>& channel : ambisonics) {
            channel.resize(block);
            field.push_back(channel.data());
        }
        const_field.assign(field.begin(), field.end());
        if (config.output == OutputFormat::binaural) {
            decoder = std::make_unique<Decoder>(config, *hrtf);
        }
    }

    RendererConfig config;
    std::shared_ptr<const Hrtf> hrtf;  ///< kept alive
    RenderShape shape;
    FractionalDelay interpolator;
    Convolver reverberation;

    /// Frames in use, from the oldest to the newest.
    std::vector<RenderFrame*> held;
    std::size_t held_count = 0;
    std::int64_t newest_stamp = 0;
    FramePhase phase;
    std::int64_t rendered = 0;  ///< samples

    FieldRotation rotation;
    std::vector<DelayLine> lines;                ///< [source]
    std::vector<std::vector<MovingPath>> paths;  ///< [source][path]
    std::unique_ptr<Decoder> decoder;            ///< binaural output only

    std::vector<AlignedVector<float>> ambisonics;  ///< [channel], binaural output only
    std::vector<float*> field;                     ///< pointers to its channels
    std::vector<const float*> const_field;

    void exchange(RenderFrame* frame, const HeadRotation& head) noexcept AULA_NONBLOCKING {
        assert(held_count < held.size());
        held[held_count++] = frame;
        newest_stamp = frame->stamp;
        reverberation.exchange(&frame->parts->reverberation);
        const std::size_t samples = phase.take(rendered);
        for (std::size_t i = 0; i < paths.size(); ++i) {
            for (std::size_t p = 0; p < paths[i].size(); ++p) {
                paths[i][p].exchange(&frame->parts->paths[i][p], lines[i], head, samples);
            }
        }
    }

    /// Adds all moving paths to the outputs: the ears or the field.
    void add_paths(std::span<const float* const> inputs, const HeadRotation& head,
                   std::span<float* const> out, std::size_t samples) noexcept AULA_NONBLOCKING {
        for (std::size_t i = 0; i < paths.size(); ++i) {
            lines[i].write(inputs[i], samples);
            for (MovingPath& path : paths[i]) path.process(lines[i], head, out, samples);
            lines[i].advance(samples);
        }
    }

    /// Returns unused frames to the mailbox. Moving paths stop using a frame when the first level
    /// of the reverberation does; the other levels use it longer.
    void release(Mailbox<RenderFrame>& mailbox) noexcept AULA_NONBLOCKING {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < held_count; ++i) {
            reverberation.release_unused(&held[i]->parts->reverberation);
            if (reverberation.uses(&held[i]->parts->reverberation)) {
                held[kept++] = held[i];
            } else {
                mailbox.give_back(held[i]);
            }
        }
        held_count = kept;
    }
};

Renderer::Renderer(const RendererConfig& config, std::shared_ptr<const Hrtf> hrtf)
    : state_(std::make_unique<State>(config, std::move(hrtf))), mailbox_(state_->held.size()) {}

Renderer::~Renderer() {
    for (std::size_t i = 0; i < state_->held_count; ++i) mailbox_.give_back(state_->held[i]);
}

std::size_t Renderer::max_frames_held() const noexcept { return state_->held.size(); }

std::int64_t Renderer::newest_stamp() const noexcept { return state_->newest_stamp; }

std::int64_t Renderer::tail_samples() const noexcept {
    const State& s = *state_;
    double longest = static_cast<double>(s.config.response_samples);
    if (s.held_count > 0) {
        for (const auto& source : s.held[s.held_count - 1]->parts->paths)
            for (const PathSound& path : source)
                if (path.present) longest = std::max(longest, path.delay_samples);
    }
    return static_cast<std::int64_t>(longest);
}

void Renderer::render(std::span<const float* const> inputs, const HeadRotation& head,
                      std::span<float* const> outputs, int samples) noexcept {
    State& s = *state_;
    const auto count = static_cast<std::size_t>(samples);
    assert(inputs.size() == s.config.sources && samples <= s.config.block);
    assert(outputs.size() == channel_count(s.config.output));

    if (!s.reverberation.fading()) {
        if (RenderFrame* const frame = mailbox_.take()) s.exchange(frame, head);
    }

    const std::span<float* const> field = s.decoder ? std::span<float* const>(s.field) : outputs;
    s.reverberation.process(inputs, field, count);
    if (!s.decoder) s.add_paths(inputs, head, field, count);
    s.rotation.turn_to(head);
    s.rotation.process(field, count);
    if (s.decoder) {
        s.decoder->process(s.const_field, outputs, count);
        s.add_paths(inputs, head, outputs, count);
    }
    s.rendered += samples;
    s.release(mailbox_);
}

}  // namespace aula
