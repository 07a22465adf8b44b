#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "apps/session/session_options.h"
#include "audio/hrtf.h"
#include "engine/energy_response.h"
#include "engine/scene.h"

namespace aula {

/// What is measured at the listener's first pose, all standing still.
struct Measurement {
    std::vector<EnergyResponse> responses;  ///< one for each source, the mean over all frames
    double length_s = 0;                    ///< of the responses
    int frames = 0;
};

/// The arithmetic mean of the responses that the estimator publishes: over `frames` consecutive
/// frames from empty caches, or, where absent, over as many windows of frames, each from empty
/// caches with a seed of its own, as bring the standard error of the level of every octave of
/// every source below 0.1 dB; 2000 frames at most. Empty if `progress` asked to stop. Throws Error.
std::optional<Measurement> measure(const Scene& scene, std::optional<int> frames,
                                   const Progress& progress = {});

/// The impulse response of one source as the renderer plays it for a standing listener: sample 0 is
/// emission, the source's gain is applied. [channel][sample], the response's length long, or as
/// long as direct sound from farther away needs. The HRTF (at the options' rate) is needed for
/// binaural output only.
std::vector<std::vector<float>> impulse_response(const Scene& scene, std::size_t source,
                                                 const Measurement& measurement,
                                                 const SessionOptions& options,
                                                 const std::shared_ptr<const Hrtf>& hrtf);

}  // namespace aula
