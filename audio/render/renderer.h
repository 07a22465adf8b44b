#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "audio/base/mailbox.h"
#include "audio/base/realtime.h"
#include "audio/spatial/ambisonics.h"
#include "audio/spatial/hrtf.h"

namespace aula {

enum class OutputFormat { binaural, mono, foa };

/// Channels of an output format: 2, 1, 4.
std::size_t channel_count(OutputFormat format);

/// One discrete arrival, in world axes (x front, y left, z up).
struct DiscretePath {
    double delay_s = 0;
    std::array<float, 3> direction{1, 0, 0};  ///< unit, from the listener to where it comes from
    std::array<float, 8> band_gain{};  ///< pressure per unit source, octave bands 63 Hz to 8 kHz
    std::uint64_t id = 0;              ///< the same for the same path in every frame; 0: not known
};

/// What one source sounds like at the listener in one frame.
struct SourceSound {
    /// Reverberation, ambisonics ACN/SN3D (W Y Z X ...) in world axes, sample 0 is emission; all of
    /// one length, at most RendererConfig::response_samples. As many channels as field_order() has.
    std::array<std::span<const float>, kMostAmbisonicChannels> ambisonics;
    /// Image sources. The strongest of known id are rendered as the direct sound is, the others
    /// into the reverberation.
    std::vector<DiscretePath> early;
    std::optional<DiscretePath> direct;  ///< rendered through a delay line, moves smoothly
    float gain = 1;                      ///< of the source, linear
};

struct RendererConfig {
    double sample_rate_hz = 48000;
    int block = 256;  ///< largest number of samples of a call
    std::size_t sources = 1;
    std::size_t response_samples = 48000;  ///< longest reverberation
    double frame_s = 1.0 / 30;  ///< time between propagation frames: moves are spread over it
    OutputFormat output = OutputFormat::binaural;
    int ambisonic_order = 1;  ///< of the field that binaural output is decoded from, 1 to 3
    bool half_precision_tail = false;  ///< of late reverberation: half the memory, -74 dB error
    double longest_delay_s = 3;  ///< of direct sound; what is farther is heard as late as this
};

/// The order of the ambisonic field that an output needs: mono 0, foa 1.
int field_order(const RendererConfig& config);

/// Samples from one propagation frame to the next, at least 1.
int frame_samples(const RendererConfig& config);

/// Everything the audio thread needs of one propagation frame, transformed and ready. Made by
/// RenderFrameBuilder, handed over through a mailbox, given back to be filled again.
struct RenderFrame {
    struct Parts;

    explicit RenderFrame(std::unique_ptr<Parts> filled);
    ~RenderFrame();

    std::unique_ptr<Parts> parts;
    std::int64_t stamp = 0;  ///< of the caller's, see Renderer::newest_stamp()
};

/// Prepares frames: early paths are added to the reverberation as fractional-delay taps through
/// minimum-phase octave-band filters, but for the strongest, which become a delay and a short
/// filter as the direct sound does; partitions are transformed. [propagation thread]
class RenderFrameBuilder {
 public:
    /// The HRTF is needed for binaural output only.
    RenderFrameBuilder(const RendererConfig& config, std::shared_ptr<const Hrtf> hrtf);
    ~RenderFrameBuilder();

    /// An empty frame with all memory in place.
    std::unique_ptr<RenderFrame> make_frame() const;

    /// Fills a frame; `sources` as many as in the config.
    void prepare(std::span<const SourceSound> sources, RenderFrame& frame);

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Plays sources through the newest frame: partitioned convolution of all sources into ambisonics,
/// exchanged with a raised-cosine crossfade; head rotation; binaural decoding; direct sound and the
/// strongest early paths through fractional delay lines, whose delay and gain move smoothly from
/// frame to frame (Doppler included), to the ears. The head's turning is heard from the next block
/// on. No latency: sample n of the output hears sample n of the input. The first frame is
/// taken without a fade. Before it all is silent. [audio thread, but for the constructor]
class Renderer {
 public:
    Renderer(const RendererConfig& config, std::shared_ptr<const Hrtf> hrtf);
    ~Renderer();

    /// Frames that the renderer holds at most, taken from the mailbox and not given back: the
    /// levels of the convolver go over to a new frame one after another.
    std::size_t most_frames_held() const noexcept;

    /// Where frames come from; a frame whose predecessor is still fading waits for the next call.
    Mailbox<RenderFrame>& mailbox() noexcept { return mailbox_; }

    /// For how long a sample of the inputs is heard with the newest frame: the reverberation, or
    /// the way that is the longest. [audio thread]
    std::int64_t tail_samples() const noexcept AULA_NONBLOCKING;

    /// The stamp of the frame that was taken last, 0 before the first. [audio thread]
    std::int64_t newest_stamp() const noexcept AULA_NONBLOCKING;

    /// Renders `samples` (any number up to config.block; offline always the full block).
    /// `inputs`: one signal for each source; `outputs`: channel_count() signals, overwritten.
    void render(std::span<const float* const> inputs, const HeadRotation& head,
                std::span<float* const> outputs, int samples) noexcept AULA_NONBLOCKING;

 private:
    struct State;
    std::unique_ptr<State> state_;
    Mailbox<RenderFrame> mailbox_;
};

}  // namespace aula
