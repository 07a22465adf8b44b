#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "apps/room/frames/sound_at_listener.h"
#include "audio/dsp/fade.h"
#include "audio/render/headphones.h"
#include "audio/render/renderer.h"
#include "aula/auralizer.h"

namespace aula {

/// The audio thread's part of an auralizer: feeds the sources' signals, one slot each, to the
/// renderer of each listener. Samples that are not finite, or beyond kLargestSample, are silence in
/// the inputs, where a single one would remain audible for the length of a response, and in the
/// outputs. [audio thread, except the constructor]
class RoomRenderer {
 public:
    /// `headphones`: of binaural output; null: none.
    RoomRenderer(const RendererConfig& config, std::size_t listeners,
                 const std::shared_ptr<const Hrtf>& hrtf,
                 const HeadphoneFilter* headphones = nullptr);

    /// The mailbox that delivers a listener's frames.
    Mailbox<RenderFrame>& frames(std::size_t listener) noexcept {
        return listeners_[listener]->renderer.mailbox();
    }

    /// Assigns a source to a slot from the next sample on; number 0 clears the slot. A source that
    /// ends fades out; one that begins after the first sample fades in, a frame after the end of
    /// the slot's source before it.
    void set_source(std::size_t slot, SourceId source) noexcept AULA_NONBLOCKING;

    /// Turns a listener's head from the next sample on. Before the first sample it has the
    /// orientation immediately.
    void turn_head(std::size_t listener, const Pose& pose) noexcept AULA_NONBLOCKING;

    /// Renders at most a block of samples, from `offset` of the signals on. `weights`: a factor for
    /// each sample, or empty.
    void render(std::span<const SourceSignal> inputs, int offset, std::span<const float> weights,
                std::span<float* const> outputs, int samples) noexcept AULA_NONBLOCKING;

    /// Samples of all inputs and outputs that were silenced since the last call.
    std::int64_t take_muted() noexcept AULA_NONBLOCKING { return std::exchange(muted_, 0); }

    /// The stamp of a listener's newest frame; see Renderer.
    std::int64_t newest_stamp(std::size_t listener) const noexcept AULA_NONBLOCKING {
        return listeners_[listener]->renderer.newest_stamp();
    }

 private:
    struct Slot {
        SourceId source;  ///< that plays; fading out if another is next
        SourceId next;
        std::int64_t free_at = 0;  ///< for the next source, after the end of the source
        Fade fade;
        std::vector<float> changed;  ///< a block of the signal, faded or with silenced samples
    };
    struct Listener {
        Listener(const RendererConfig& config, std::shared_ptr<const Hrtf> hrtf)
            : renderer(config, std::move(hrtf)), head(frame_samples(config)) {}
        Renderer renderer;
        HeadMotion head;
        std::optional<HeadphoneEqualizer> headphones{};
    };

    const float* signal(const Slot& slot, std::span<const SourceSignal> inputs,
                        std::size_t offset) const noexcept AULA_NONBLOCKING;
    const float* read(Slot& slot, std::span<const SourceSignal> inputs, std::size_t offset,
                      std::span<const float> weights,
                      std::size_t samples) noexcept AULA_NONBLOCKING;
    void mute(std::span<float> samples) noexcept AULA_NONBLOCKING;

    std::size_t channels_;       ///< of a listener
    std::int64_t rest_samples_;  ///< of a slot between two sources: a frame, for one without them
    std::int64_t time_samples_ = 0;
    std::int64_t muted_ = 0;  ///< samples
    std::vector<Slot> slots_;
    std::vector<std::unique_ptr<Listener>> listeners_;
    std::vector<float> silence_;
    std::vector<const float*> inputs_;  ///< [slot]
};

}  // namespace aula
