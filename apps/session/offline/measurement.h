#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/session/base/session_options.h"
#include "audio/spatial/hrtf.h"
#include "engine/response/energy_response.h"
#include "engine/scene/scene.h"

namespace aula {

/// What is measured at the listener's first pose with everything at rest.
struct Measurement {
    std::vector<EnergyResponse> responses;  ///< [source]
    std::vector<char> audible;              ///< [source] at the listener
    double length_s = 0;                    ///< of the responses
    int frames = 0;
    std::vector<std::string> warnings;  ///< each a line for the user: sources that are not
                                        ///< audible, errors larger than wanted
};

/// The energy response of every source at the listener.
///
/// Over `frames` consecutive frames from empty caches, or, where absent, the mean over independent
/// windows of frames, each from empty caches with its own seed, until the standard errors of level,
/// C80, T30 and EDT of that mean are below 0.05 dB, 0.1 dB, 1 % and 1 % in every octave from 125 Hz
/// to 4 kHz for each audible source (measurement_error.h); 2000 frames at most.
///
/// Frames from empty caches give the mean of the published responses (`pt`, `dpc-published`), the
/// last (`patch`), or, `dpc`, the last up to 1.5 windows of its cache and beyond them the mean.
///
/// A source is audible if sound finds a way to the listener (connected() in
/// engine/rays/room_survey.h) and is_audible() holds for its response. Empty if `progress` asked to
/// stop. Throws Error.
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
