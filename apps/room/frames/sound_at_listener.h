#pragma once

#include <cstdint>
#include <limits>

#include "apps/room/frames/source_trajectory.h"
#include "apps/room/waves/frame_waves.h"
#include "audio/render/renderer.h"
#include "aula/engine/impulse_response.h"
#include "aula/engine/scene.h"

namespace aula {

/// Converts the engine's impulse response, of the renderer's order, to the renderer's input. The
/// reverberation's samples are not copied (keep `response` alive); arrivals get delays in seconds
/// and pressure gains. `direct_gain` applies to all paths of the direct sound, `early_gain` to
/// reflections. `trajectory`: of a source that moves; null: it stands.
SourceSound source_sound(const ImpulseResponse& response, double speed_of_sound_m_s, float gain_db,
                         float direct_gain = 1, float early_gain = 1,
                         const SourceTrajectory* trajectory = nullptr);

/// The longest delay of direct sound in a scene, for the renderer: the largest distance between a
/// source and a listener position, plus a kilometre for interactive movement.
double longest_delay_s(const Scene& scene);

/// The settings of the sound at a listener that do not affect the simulation.
struct FrameSettings : OutputOptions {
    std::size_t max_sources = 0;  ///< including sources that ring out; at least the scene's
    std::size_t listeners = 1;
    WavesReady waves_ready = WavesReady::at_once;
    std::uint64_t headphones_bytes = 0;  ///< see equalizer_bytes()
    /// Of the renderers and equalizers of all listeners, see renderer_bytes().
    std::uint64_t max_memory_bytes = std::numeric_limits<std::uint64_t>::max();
};

/// The renderer's settings for a scene.
RendererConfig renderer_config(const Scene& scene, double response_length_s,
                               const FrameSettings& settings);

/// Makes impulse responses as the renderer plays them. [one thread at a time]
class ResponseRenderer {
 public:
    /// The number of sources in `config` is not used.
    ResponseRenderer(RendererConfig config, double length_s, std::shared_ptr<const Hrtf> hrtf);

    /// The impulse response of a source at a listener: [channel][sample], sample 0 is emission. It
    /// is as long as the constructor was told, or longer if distant direct sound requires it.
    std::vector<std::vector<float>> response(const SourceSound& sound, const Pose& head);

 private:
    RendererConfig config_;
    double length_s_;
    std::shared_ptr<const Hrtf> hrtf_;
    RenderFrameBuilder frames_;
};

/// The head's axes in the renderer's format.
HeadRotation head_rotation(const Pose& pose) noexcept AULA_NONBLOCKING;

/// Head rotation between poses: uniform rotation to each new orientation in the shorter direction,
/// within the time between the last two poses, at most a frame. [audio thread]
class HeadMotion {
 public:
    explicit HeadMotion(int frame_samples) : frame_samples_(frame_samples) {}

    /// Sets the target orientation. The first call sets the orientation immediately.
    void turn_to(const Pose& pose) noexcept AULA_NONBLOCKING;

    /// The orientation `samples` later.
    HeadRotation advance(int samples) noexcept AULA_NONBLOCKING;

 private:
    int frame_samples_;
    int since_samples_ = 0;       ///< since the last pose, at most a frame
    int remaining_samples_ = -1;  ///< -1: no orientation yet
    Pose now_;
    Pose target_;
};

}  // namespace aula
