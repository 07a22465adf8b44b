#pragma once

#include "apps/session/base/session_options.h"
#include "audio/render/renderer.h"
#include "engine/response/impulse_response.h"
#include "engine/scene/scene.h"

namespace aula {

/// The engine's impulse response, of the renderer's order, as the renderer takes it: the
/// reverberation's samples stay where they are (keep `response` alive), arrivals get delays in
/// seconds and pressure gains.
SourceSound source_sound(const ImpulseResponse& response, double speed_of_sound_m_s, float gain_db);

/// The longest delay of direct sound in a scene, for the renderer: from every place of a source to
/// every place of the listener, with a kilometre to spare for walks by hand.
double longest_delay_s(const Scene& scene);

/// What of a sound at a listener is not simulated.
struct FrameSettings {
    double sample_rate_hz = 48000;
    int block = 256;  ///< samples
    OutputFormat output = OutputFormat::binaural;
    int ambisonic_order = 1;           ///< of the reverberation in binaural output, 1 to 3
    bool half_precision_tail = false;  ///< of late reverberation, see RendererConfig
    std::size_t most_sources = 0;      ///< with those that ring out; at least the scene's
    std::size_t listeners = 1;
};

/// Those of a session, for the sources of its scene.
FrameSettings frame_settings(const SessionOptions& options, double sample_rate_hz);

/// The renderer's settings for a scene.
RendererConfig renderer_config(const Scene& scene, double response_length_s,
                               const FrameSettings& settings);

/// The impulse response of what a source sounds like at a listener, as the renderer plays it:
/// [channel][sample], sample 0 is emission, `length_s` long, or as long as direct sound from
/// farther away needs. Of the config the number of sources is not used.
std::vector<std::vector<float>> render_response(const SourceSound& sound, RendererConfig config,
                                                double length_s, const Pose& head,
                                                const std::shared_ptr<const Hrtf>& hrtf);

/// The head's axes as the renderer takes them.
HeadRotation head_rotation(const Pose& pose) noexcept AULA_NONBLOCKING;

/// The head's turning between poses: it moves evenly to each new orientation, the short way round,
/// in the time that has passed between the last two, at most a frame. [audio thread]
class HeadMotion {
 public:
    explicit HeadMotion(int frame_samples) : frame_samples_(frame_samples) {}

    /// Where to turn to from here on. The first time the head is there at once.
    void turn_to(const Pose& pose) noexcept AULA_NONBLOCKING;

    /// The orientation after so many more samples.
    HeadRotation advance(int samples) noexcept AULA_NONBLOCKING;

 private:
    int frame_samples_;
    int since_samples_ = 0;       ///< since the last pose, at most a frame
    int remaining_samples_ = -1;  ///< -1: no orientation yet
    Pose now_;
    Pose target_;
};

}  // namespace aula
