#include "apps/session/auralizer/room_renderer.h"

#include <algorithm>
#include <cmath>

namespace aula {

namespace {

/// Of a source that begins or ends while it plays.
constexpr double kSourceFade_s = 0.02;

}  // namespace

RoomRenderer::RoomRenderer(const RendererConfig& config, std::size_t listeners,
                           const std::shared_ptr<const Hrtf>& hrtf)
    : channels_(channel_count(config.output)),
      silence_(static_cast<std::size_t>(config.block)),
      inputs_(config.sources) {
    const Fade fade(static_cast<std::size_t>(std::lround(kSourceFade_s * config.sample_rate_hz)));
    for (std::size_t s = 0; s < config.sources; ++s)
        slots_.push_back({{}, false, fade, std::vector<float>(silence_.size())});
    for (std::size_t l = 0; l < listeners; ++l)
        listeners_.push_back(std::make_unique<Listener>(config, hrtf));
}

void RoomRenderer::set_source(std::size_t index, SourceId source) noexcept {
    Slot& slot = slots_[index];
    const SourceId playing = slot.open ? slot.source : SourceId{};
    if (playing == source) return;
    const bool begins = source.number != 0;
    if (begins && slot.source == source) {
        slot.fade.reverse();  // it was fading out
    } else if (begins) {
        slot.source = source;
        if (started_) slot.fade.start();
    } else if (!started_) {
        slot.source = {};
    } else if (slot.fade.done()) {
        slot.fade.start();
    } else {
        slot.fade.reverse();  // it was fading in
    }
    slot.open = begins;
}

void RoomRenderer::turn_head(std::size_t listener, const Pose& pose) noexcept {
    listeners_[listener]->head.turn_to(pose);
}

/// The signal of a slot, faded as far as the slot is.
const float* RoomRenderer::read(Slot& slot, std::span<const SourceSignal> inputs, int offset,
                                std::span<const float> weights, std::size_t samples) noexcept {
    if (!slot.open && slot.fade.done()) slot.source = {};
    if (slot.source.number == 0) return silence_.data();
    const auto signal = std::find_if(inputs.begin(), inputs.end(), [&](const SourceSignal& input) {
        return input.source == slot.source;
    });
    const bool given = signal != inputs.end() && signal->samples != nullptr;
    const float* const input = given ? signal->samples + offset : silence_.data();
    if (slot.open && slot.fade.done() && weights.empty()) return input;
    const std::span<float> faded(slot.faded.data(), samples);
    std::copy_n(input, samples, faded.data());
    for (std::size_t n = 0; n < weights.size(); ++n) faded[n] *= weights[n];
    if (slot.open)
        slot.fade.fade_in(faded);
    else
        slot.fade.fade_out(faded);
    slot.fade.advance(samples);
    return faded.data();
}

void RoomRenderer::render(std::span<const SourceSignal> inputs, int offset,
                          std::span<const float> weights, std::span<float* const> outputs,
                          int samples) noexcept {
    started_ = true;
    for (std::size_t s = 0; s < slots_.size(); ++s)
        inputs_[s] = read(slots_[s], inputs, offset, weights, static_cast<std::size_t>(samples));
    for (std::size_t l = 0; l < listeners_.size(); ++l) {
        Listener& listener = *listeners_[l];
        listener.renderer.render(inputs_, listener.head.advance(samples),
                                 outputs.subspan(l * channels_, channels_), samples);
    }
}

}  // namespace aula
