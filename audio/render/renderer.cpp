#include "audio/render/renderer.h"

#include <algorithm>
#include <cassert>
#include <limits>
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
    static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

    State(const RendererConfig& settings, std::shared_ptr<const Hrtf> head)
        : config(settings),
          hrtf(std::move(head)),
          shape(settings, hrtf.get()),
          reverberation(shape.reverberation, shape.fade_samples),
          held(reverberation.max_filters() + 1),
          phase(shape.path.frame_samples, shape.path.block, shape.fade_samples),
          rotation(field_order(settings), shape.path.turn_samples),
          ambisonics(ambisonic_channels(field_order(settings))),
          part_inputs(config.sources),
          part_outputs(channel_count(config.output)) {
        // A path that starts reads the history of its filter, delayed further for each ear.
        const std::size_t history = 2 * shape.path.filter_taps;
        const Fade fade(shape.path_fade_samples);
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

    /// Frames in use, from the oldest to the newest, and one whose use has ended in this call.
    std::vector<RenderFrame*> held;
    std::size_t held_count = 0;
    std::int64_t newest_stamp = 0;
    FramePhase phase;
    RenderFrame* waiting = nullptr;  ///< taken, not yet in effect
    std::int64_t reached_at = 0;     ///< by the motion to its state
    std::int64_t frame_begin = 0;    ///< of the newest frame
    std::size_t step = 0;            ///< of the newest frame, the next to begin
    std::int64_t fade_end = 0;       ///< of the last exchange
    std::int64_t path_fade_end = 0;  ///< of paths of the newest frame that differ
    std::int64_t rendered = 0;       ///< samples

    FieldRotation rotation;
    std::vector<DelayLine> lines;                ///< [source]
    std::vector<std::vector<MovingPath>> paths;  ///< [source][path]
    std::unique_ptr<Decoder> decoder;            ///< binaural output only

    std::vector<AlignedVector<float>> ambisonics;  ///< [channel], binaural output only
    std::vector<float*> field;                     ///< pointers to its channels
    std::vector<const float*> const_field;
    std::vector<const float*> part_inputs;  ///< of the part of a call that is being rendered
    std::vector<float*> part_outputs;       ///< likewise

    /// Takes the newest frame, if none is waiting.
    void take(Mailbox<RenderFrame>& mailbox) noexcept AULA_NONBLOCKING {
        if (waiting != nullptr || (!phase.is_exact() && reverberation.fading())) return;
        waiting = mailbox.take();
        if (waiting != nullptr) reached_at = phase.take(rendered);
    }

    /// Begins the frame or the step whose time has come. Returns how many of `samples` samples are
    /// rendered before the next one.
    std::size_t exchange(const HeadRotation& head, std::size_t samples) noexcept AULA_NONBLOCKING {
        const std::int64_t frame = waiting != nullptr ? std::max(rendered, path_fade_end) : kNever;
        const std::int64_t next = std::max(std::min(frame, step_begin()), fade_end);
        if (next > rendered)
            return static_cast<std::size_t>(
                std::min(static_cast<std::int64_t>(samples), next - rendered));
        if (frame <= rendered) {
            begin_frame(head);
        } else {
            begin_step();
        }
        return exchange(head, samples);
    }

    /// When the next step of the newest frame begins.
    std::int64_t step_begin() const noexcept AULA_NONBLOCKING {
        if (held_count == 0 || step == shape.steps) return kNever;
        return frame_begin +
               static_cast<std::int64_t>(step * shape.path.frame_samples / shape.steps);
    }

    void begin_step() noexcept AULA_NONBLOCKING {
        assert(!reverberation.fading());
        reverberation.exchange(&held[held_count - 1]->parts->reverberation[step++]);
        fade_end = rendered + static_cast<std::int64_t>(shape.fade_samples);
    }

    void begin_frame(const HeadRotation& head) noexcept AULA_NONBLOCKING {
        assert(held_count < held.size());
        RenderFrame* const frame = std::exchange(waiting, nullptr);
        // Of the first frame, which takes effect without a fade, only the last step counts.
        step = held_count == 0 ? shape.steps - 1 : 0;
        held[held_count++] = frame;
        newest_stamp = frame->stamp;
        frame_begin = rendered;
        path_fade_end = rendered + static_cast<std::int64_t>(shape.path_fade_samples);
        begin_step();
        for (std::size_t i = 0; i < paths.size(); ++i) {
            for (std::size_t p = 0; p < paths[i].size(); ++p) {
                paths[i][p].exchange(&frame->parts->paths[i][p], lines[i], head,
                                     static_cast<std::size_t>(reached_at - rendered));
            }
        }
    }

    /// Renders samples [offset, offset + samples) of a call.
    void render(std::span<const float* const> inputs, const HeadRotation& head,
                std::span<float* const> outputs, std::size_t offset,
                std::size_t samples) noexcept AULA_NONBLOCKING {
        for (std::size_t i = 0; i < inputs.size(); ++i) part_inputs[i] = inputs[i] + offset;
        for (std::size_t o = 0; o < outputs.size(); ++o) part_outputs[o] = outputs[o] + offset;
        const std::span<float* const> part(part_outputs);
        const std::span<float* const> ambisonic = decoder ? std::span<float* const>(field) : part;
        reverberation.process(part_inputs, ambisonic, samples);
        if (!decoder) add_paths(head, part, samples);
        rotation.process(ambisonic, samples);
        if (decoder) {
            decoder->process(const_field, part, samples);
            add_paths(head, part, samples);
        }
        rendered += static_cast<std::int64_t>(samples);
    }

    /// Adds all moving paths to the outputs: the ears or the field.
    void add_paths(const HeadRotation& head, std::span<float* const> out,
                   std::size_t samples) noexcept AULA_NONBLOCKING {
        for (std::size_t i = 0; i < paths.size(); ++i) {
            lines[i].write(part_inputs[i], samples);
            for (MovingPath& path : paths[i]) path.process(lines[i], head, out, samples);
            lines[i].advance(samples);
        }
    }

    /// Returns unused frames to the mailbox. Moving paths stop using a frame when the first level
    /// of the reverberation does; the other levels use it longer.
    void release(Mailbox<RenderFrame>& mailbox) noexcept AULA_NONBLOCKING {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < held_count; ++i) {
            const std::vector<ConvolutionFilter>& filters = held[i]->parts->reverberation;
            const bool is_newest = i + 1 == held_count;
            bool is_used = is_newest;
            for (std::size_t f = 0; f < (is_newest ? step : filters.size()); ++f) {
                reverberation.release_unused(&filters[f]);
                is_used = is_used || reverberation.uses(&filters[f]);
            }
            if (is_used) {
                held[kept++] = held[i];
            } else {
                mailbox.give_back(held[i]);
            }
        }
        held_count = kept;
    }
};

Renderer::Renderer(const RendererConfig& config, std::shared_ptr<const Hrtf> hrtf)
    : state_(std::make_unique<State>(config, std::move(hrtf))), mailbox_(max_frames_held()) {}

Renderer::~Renderer() {
    for (std::size_t i = 0; i < state_->held_count; ++i) mailbox_.give_back(state_->held[i]);
    if (state_->waiting != nullptr) mailbox_.give_back(state_->waiting);
}

std::size_t Renderer::max_frames_held() const noexcept { return state_->held.size() + 1; }

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

    s.take(mailbox_);
    s.rotation.turn_to(head);
    for (std::size_t done = 0; done < count;) {
        const std::size_t part = s.exchange(head, count - done);
        s.render(inputs, head, outputs, done, part);
        done += part;
    }
    s.release(mailbox_);
}

}  // namespace aula
