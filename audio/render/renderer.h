#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "audio/base/mailbox.h"
#include "audio/dsp/band_filter.h"
#include "audio/spatial/ambisonics.h"
#include "audio/spatial/hrtf.h"
#include "aula/audio/output_options.h"
#include "aula/audio/realtime.h"

namespace aula {

/// A discrete arrival at the listener, in world axes (x front, y left, z up).
struct DiscretePath {
    double delay_s = 0;  ///< from the emission
    float length_m = 0;  ///< of the path in air; 0: no loss by air, and from afar
    /// Of arrival: from the listener to its origin (HeardDirection).
    std::array<float, 3> direction{1, 0, 0};
    std::array<float, 8> band_gain{};  ///< pressure re that of the source at 1 m, 63 Hz to 8 kHz
    std::uint64_t id = 0;              ///< identifies the path in all frames; 0: unknown
};

/// The sound of one source at the listener in one frame.
struct SourceSound {
    /// Reverberation: ambisonic impulse responses (ACN, SN3D) in world axes, [channel][sample].
    /// Sample 0 is the emission. There are ambisonic_channels(field_order()) channels of one
    /// length, at most RendererConfig::response_samples.
    std::array<std::span<const float>, kMaxAmbisonicChannels> ambisonics;
    /// Early reflections, and direct sound that edges diffract. The strongest of known id are
    /// rendered like the direct sound, the others are added to the reverberation.
    std::vector<DiscretePath> early;
    std::optional<DiscretePath> direct;  ///< rendered through a delay line with continuous motion
    float gain = 1;                      ///< linear gain of the source
    bool absent = false;                 ///< the source is silent; the other members are not read
};

/// The settings of a renderer, whose caller reads the files of OutputOptions and equalises
/// headphones. A call has at most a block of samples. Half precision is also used for filters above
/// 512 MiB.
struct RendererConfig : OutputOptions {
    std::size_t sources = 1;               ///< at most; SourceSound::absent leaves one out
    std::size_t response_samples = 48000;  ///< length of the longest reverberation
    double frame_s = 1.0 / 30;             ///< propagation frame interval
    double steps_hz = 0;                   ///< see frame_steps()
    double longest_delay_s = 3;            ///< of direct sound; longer delays are clamped
    AirAttenuation air{};  ///< between the centres of the octaves, which the gains contain
};

/// Steps in which the reverberation changes within a frame: RendererConfig::steps_hz a second or
/// more, but at most 4, and not shorter than the shortest fade, 512 samples; at least one.
std::size_t frame_steps(const RendererConfig& config);

/// The order of the ambisonic field of an output: mono 0, foa 1, toa 3, binaural ambisonic_order.
int field_order(const RendererConfig& config);

/// Propagation frame interval, samples, at least 1.
int frame_samples(const RendererConfig& config);

/// The data of one propagation frame for the audio thread, already transformed. RenderFrameBuilder
/// creates it; it passes to the renderer through a mailbox and returns for reuse.
struct RenderFrame {
    struct Parts;

    explicit RenderFrame(std::unique_ptr<Parts> filled);
    ~RenderFrame();

    std::unique_ptr<Parts> parts;
    std::int64_t stamp = 0;  ///< set by the caller, see Renderer::newest_stamp()
};

/// Prepares frames. The direct sound and the strongest early paths become a delay and a short
/// filter. The other early paths are added to the reverberation, with fractional delays and
/// minimum-phase octave-band filters. Partitions of the reverberation are transformed. Absent
/// sources cost next to nothing.
/// [propagation thread]
class RenderFrameBuilder {
 public:
    /// `hrtf` may be null unless the output is binaural.
    RenderFrameBuilder(const RendererConfig& config, std::shared_ptr<const Hrtf> hrtf);
    ~RenderFrameBuilder();

    /// Forgets the frames before: the next one is prepared as the first.
    void restart();

    /// Samples of the reverberation that a step takes: all, or the beginning. The rest is then that
    /// of the step before.
    std::size_t step_samples(std::size_t step) const;

    /// An empty frame with all memory allocated.
    std::unique_ptr<RenderFrame> make_frame() const;

    /// Tells that the next frames are exchanged at sample `first` of the renderer's output and
    /// replaced at sample `next`. Parts of the reverberation that do not change in between are then
    /// not prepared. Without this call the time of the exchange is not known.
    void set_exchange(std::int64_t first, std::int64_t next);

    /// Fills a frame with one state. `sources` has RendererConfig::sources elements.
    void prepare(std::span<const SourceSound> sources, RenderFrame& frame);

    /// Sets one source in a step of a frame; all frame_steps() of it in order. `present` is the
    /// number of sources in the frame that are not absent. Moving paths are those of the last step.
    void prepare(std::size_t index, const SourceSound& source, std::size_t present,
                 RenderFrame& frame, std::size_t step);

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Renders sources through the newest frame. Reverberation: partitioned convolution of all sources
/// into an ambisonic field, head rotation, binaural decoding. Direct sound and the strongest early
/// paths: fractional delay lines whose delays, directions and gains move linearly from frame to
/// frame (with the Doppler shift), and filters of the ears. The reverberation, and paths that begin
/// or end, are exchanged by crossfades from frame to frame; the first frame takes effect without a
/// fade, and the output is silent before it. A turn of the head takes effect in the next block. No
/// latency: sample n of the output includes sample n of the input. [audio thread, except the
/// constructor]
class Renderer {
 public:
    /// `hrtf` may be null unless the output is binaural.
    Renderer(const RendererConfig& config, std::shared_ptr<const Hrtf> hrtf);
    ~Renderer();

    /// Largest number of frames taken from the mailbox and not yet returned. The levels of the
    /// convolver exchange their filters one after another.
    std::size_t max_frames_held() const noexcept;

    /// The source of frames. The next frame is taken when the previous one is in effect.
    Mailbox<RenderFrame>& mailbox() noexcept { return mailbox_; }

    /// Duration of the response to an input sample with the newest frame: the length of the
    /// reverberation, or the longest delay. [audio thread]
    std::int64_t tail_samples() const noexcept AULA_NONBLOCKING;

    /// The stamp of the newest frame taken, 0 before the first. [audio thread]
    std::int64_t newest_stamp() const noexcept AULA_NONBLOCKING;

    /// Renders `samples` samples, at most config.block. `inputs` has one signal per source,
    /// `outputs` channel_count() signals, which are overwritten. `head` is the orientation at the
    /// end of the block.
    void render(std::span<const float* const> inputs, const HeadRotation& head,
                std::span<float* const> outputs, int samples) noexcept AULA_NONBLOCKING;

 private:
    struct State;
    std::unique_ptr<State> state_;
    Mailbox<RenderFrame> mailbox_;
};

}  // namespace aula
