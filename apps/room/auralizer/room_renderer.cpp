#include "apps/room/auralizer/room_renderer.h"

#include <algorithm>
#include <cmath>

#include "audio/base/mute.h"

namespace aula {

namespace {

/// Fade of a source that begins or ends during playback.
constexpr double kSourceFade_s = 0.02;

}  // namespace

RoomRenderer::RoomRenderer(const RendererConfig& config, std::size_t listeners,
                           const std::shared_ptr<const Hrtf>& hrtf,
                           const HeadphoneFilter* headphones)
    : channels_(channel_count(config.output)),
      rest_samples_(frame_samples(config)),
      silence_(static_cast<std::size_t>(config.block)),
      inputs_(config.sources) {
    const Fade fade(static_cast<std::size_t>(std::lround(kSourceFade_s * config.sample_rate_hz)));
    for (std::size_t s = 0; s < config.sources; ++s)
        slots_.push_back({{}, {}, 0, fade, std::vector<float>(silence_.size())});
    for (std::size_t l = 0; l < listeners; ++l) {
        listeners_.push_back(std::make_unique<Listener>(config, hrtf));
        if (headphones != nullptr) listeners_.back()->headphones.emplace(*headphones, config.block);
    }
}

void RoomRenderer::set_source(std::size_t index, SourceId source) noexcept {
    Slot& slot = slots_[index];
    if (time_samples_ == 0) {
        slot.source = slot.next = source;
        return;
    }
    if (slot.next == source) return;
    const bool ends = slot.next == slot.source && slot.source.number != 0;
    slot.next = source;
    if (!ends) return;
    if (slot.fade.done())
        slot.fade.start();
    else
        slot.fade.reverse();  // it was fading in
}

void RoomRenderer::turn_head(std::size_t listener, const Pose& pose) noexcept {
    listeners_[listener]->head.turn_to(pose);
}

/// The signal that a slot plays.
const float* RoomRenderer::signal(const Slot& slot, std::span<const SourceSignal> inputs,
                                  std::size_t offset) const noexcept {
    if (slot.source.number == 0) return silence_.data();
    const auto input = std::find_if(inputs.begin(), inputs.end(),
                                    [&](const SourceSignal& i) { return i.source == slot.source; });
    const bool given = input != inputs.end() && input->samples != nullptr;
    return given ? input->samples + offset : silence_.data();
}

/// Silences samples that are not usable, and counts them.
void RoomRenderer::mute(std::span<float> samples) noexcept {
    muted_ += static_cast<std::int64_t>(mute_beyond(kLargestSample, samples));
}

/// The signal of a slot, faded as far as its source is, without samples that are not usable.
const float* RoomRenderer::read(Slot& slot, std::span<const SourceSignal> inputs,
                                std::size_t offset, std::span<const float> weights,
                                std::size_t samples) noexcept {
    if (slot.next == slot.source && slot.fade.done() && weights.empty()) {
        const float* const given = signal(slot, inputs, offset);
        if (all_within(kLargestSample, {given, samples})) return given;
    }
    for (std::size_t done = 0; done < samples;) {
        const std::int64_t now = time_samples_ + static_cast<std::int64_t>(done);
        if (slot.next != slot.source && slot.fade.done()) {
            if (slot.source.number != 0) slot.free_at = now + rest_samples_;
            slot.source = {};
            if (slot.next.number != 0 && now >= slot.free_at) {
                slot.source = slot.next;
                slot.fade.start();
            }
        }
        std::size_t part = samples - done;
        if (!slot.fade.done())
            part = std::min(part, slot.fade.remaining());
        else if (slot.next != slot.source)
            part = std::min(part, static_cast<std::size_t>(slot.free_at - now));
        const std::span<float> changed(slot.changed.data() + done, part);
        std::copy_n(signal(slot, inputs, offset + done), part, changed.data());
        mute(changed);
        if (slot.next == slot.source)
            slot.fade.fade_in(changed);
        else
            slot.fade.fade_out(changed);
        slot.fade.advance(part);
        done += part;
    }
    for (std::size_t n = 0; n < weights.size(); ++n) slot.changed[n] *= weights[n];
    return slot.changed.data();
}

void RoomRenderer::render(std::span<const SourceSignal> inputs, int offset,
                          std::span<const float> weights, std::span<float* const> outputs,
                          int samples) noexcept {
    for (std::size_t s = 0; s < slots_.size(); ++s)
        inputs_[s] = read(slots_[s], inputs, static_cast<std::size_t>(offset), weights,
                          static_cast<std::size_t>(samples));
    for (std::size_t l = 0; l < listeners_.size(); ++l) {
        Listener& listener = *listeners_[l];
        const std::span<float* const> heard = outputs.subspan(l * channels_, channels_);
        listener.renderer.render(inputs_, listener.head.advance(samples), heard, samples);
        for (float* const channel : heard) mute({channel, static_cast<std::size_t>(samples)});
        if (!listener.headphones) continue;
        listener.headphones->process(heard, samples);
        for (float* const channel : heard) mute({channel, static_cast<std::size_t>(samples)});
    }
    time_samples_ += samples;
}

}  // namespace aula
