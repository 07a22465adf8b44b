#include "audio/renderer.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "audio/render_frame.h"

namespace aula {

namespace {

/// The head's rotation, moved to a new one in a straight line over a set time: as short as a block,
/// long enough not to click.
class RotationGlide {
 public:
    explicit RotationGlide(std::size_t samples) : samples_(samples) {}

    void move_to(const HeadRotation& target) noexcept {
        if (!started_) {
            started_ = true;
            value_ = target_ = target;
        } else if (target != target_) {
            target_ = target;
            remaining_ = samples_;
            for (std::size_t i = 0; i < 3; ++i) {
                for (std::size_t j = 0; j < 3; ++j) {
                    step_[i][j] = (target[i][j] - value_[i][j]) / static_cast<float>(samples_);
                }
            }
        }
    }

    /// Turns Y Z X, one sample each.
    void turn(float& y, float& z, float& x) noexcept {
        if (remaining_ > 0) {
            --remaining_;
            for (std::size_t i = 0; i < 3; ++i) {
                for (std::size_t j = 0; j < 3; ++j) value_[i][j] += step_[i][j];
            }
            if (remaining_ == 0) value_ = target_;
        }
        const HeadRotation& r = value_;
        const float turned_x = r[0][0] * x + r[0][1] * y + r[0][2] * z;
        const float turned_y = r[1][0] * x + r[1][1] * y + r[1][2] * z;
        z = r[2][0] * x + r[2][1] * y + r[2][2] * z;
        x = turned_x;
        y = turned_y;
    }

 private:
    std::size_t samples_;
    std::size_t remaining_ = 0;
    bool started_ = false;
    HeadRotation target_{};
    HeadRotation value_{};
    HeadRotation step_{};
};

ConvolutionShape decoder_shape(const RendererConfig& config, const Hrtf& hrtf) {
    return {4, 2, static_cast<std::size_t>(config.block), hrtf.taps()};
}

ConvolutionFilter decoder_filter(const ConvolutionShape& shape, const Hrtf& hrtf) {
    FilterTransform transform(shape);
    ConvolutionFilter filter(shape);
    for (std::size_t c = 0; c < 4; ++c) {
        const std::array<std::span<const float>, 2> ears{hrtf.decoder()[0][c],
                                                         hrtf.decoder()[1][c]};
        transform.transform(ears, c, filter);
    }
    return filter;
}

/// Ambisonics in head axes to the two ears.
struct Decoder {
    Decoder(const RendererConfig& config, const Hrtf& hrtf)
        : filter(decoder_filter(decoder_shape(config, hrtf), hrtf)),
          convolver(decoder_shape(config, hrtf), 0) {
        convolver.exchange(&filter);
    }

    ConvolutionFilter filter;
    Convolver convolver;
};

}  // namespace

struct Renderer::State {
    State(const RendererConfig& settings, const Hrtf* hrtf)
        : config(settings),
          shape(settings, hrtf),
          fade(raised_cosine(shape.fade_samples)),
          reverberation(shape.reverberation, shape.fade_samples),
          rotation(static_cast<std::size_t>(settings.block)) {
        for (std::size_t i = 0; i < config.sources; ++i) {
            direct.emplace_back(shape.direct, interpolator, fade);
        }
        const auto block = static_cast<std::size_t>(config.block);
        for (AlignedVector<float>& channel : ambisonics) channel.resize(block);
        if (config.output == OutputFormat::binaural) {
            decoder = std::make_unique<Decoder>(config, *hrtf);
        }
    }

    RendererConfig config;
    RenderShape shape;
    std::vector<float> fade;
    FractionalDelay interpolator;
    Convolver reverberation;
    RotationGlide rotation;
    std::vector<DirectPath> direct;
    std::unique_ptr<Decoder> decoder;  ///< binaural output only

    RenderFrame* current = nullptr;
    RenderFrame* next = nullptr;  ///< being faded in

    std::array<AlignedVector<float>, 4> ambisonics;

    void exchange(const RenderFrame& frame) noexcept {
        reverberation.exchange(&frame.parts->reverberation);
        for (std::size_t i = 0; i < direct.size(); ++i) {
            direct[i].exchange(&frame.parts->direct[i]);
        }
    }
};

Renderer::Renderer(const RendererConfig& config, std::shared_ptr<const Hrtf> hrtf)
    : state_(std::make_unique<State>(config, hrtf.get())) {}

Renderer::~Renderer() {
    if (state_->current != nullptr) mailbox_.give_back(state_->current);
    if (state_->next != nullptr) mailbox_.give_back(state_->next);
}

void Renderer::render(std::span<const float* const> inputs, const HeadRotation& head,
                      std::span<float* const> outputs, int samples) noexcept {
    State& s = *state_;
    const auto count = static_cast<std::size_t>(samples);
    assert(inputs.size() == s.config.sources && samples <= s.config.block);
    assert(outputs.size() == channel_count(s.config.output));

    if (s.next == nullptr) {
        if (RenderFrame* const frame = mailbox_.take()) {
            (s.current == nullptr ? s.current : s.next) = frame;
            s.exchange(*frame);
        }
    }

    std::array<float*, 4> ambisonics;
    for (std::size_t c = 0; c < 4; ++c) ambisonics[c] = s.ambisonics[c].data();
    switch (s.config.output) {
        case OutputFormat::mono:
            s.reverberation.process(inputs, outputs, count);
            break;
        case OutputFormat::foa:
            std::copy(outputs.begin(), outputs.end(), ambisonics.begin());
            [[fallthrough]];
        case OutputFormat::binaural:
            s.reverberation.process(inputs, ambisonics, count);
            s.rotation.move_to(head);
            for (std::size_t n = 0; n < count; ++n) {
                s.rotation.turn(ambisonics[1][n], ambisonics[2][n], ambisonics[3][n]);
            }
            break;
    }
    if (s.decoder) {
        const std::array<const float*, 4> in{ambisonics[0], ambisonics[1], ambisonics[2],
                                             ambisonics[3]};
        s.decoder->convolver.process(in, outputs, count);
    }
    for (std::size_t i = 0; i < s.direct.size(); ++i) {
        s.direct[i].process(inputs[i], outputs, count);
    }

    // All parts of an exchange fade over the same samples.
    if (s.next != nullptr && !s.reverberation.fading()) {
        mailbox_.give_back(s.current);
        s.current = std::exchange(s.next, nullptr);
    }
}

}  // namespace aula
