#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/session/base/session_options.h"
#include "audio/spatial/hrtf.h"
#include "aula/engine/energy_response.h"
#include "aula/engine/scene.h"

namespace aula {

/// The result of a measurement at the listener's first pose with everything static.
struct Measurement {
    std::vector<EnergyResponse> responses;  ///< [source]
    std::vector<char> audible;              ///< [source] whether it is audible at the listener
    double length_s = 0;                    ///< of the responses
    int frames = 0;
    std::vector<std::string> warnings;  ///< lines for the user: sources that are not
                                        ///< audible, errors larger than wanted
};

/// Computes the energy response of every source at the listener.
///
/// With `frames`: over that number of consecutive frames from empty caches. Without: the mean over
/// independent windows of frames, each from empty caches with a separate seed, until the standard
/// errors of level, C80, T30 and EDT of that mean are below 0.05 dB, 0.1 dB, 1 % and 1 % in every
/// octave from 125 Hz to 4 kHz for each audible source (measurement_error.h); at most 2000 frames.
///
/// The result of frames from empty caches is the mean of the published responses (`pt`,
/// `dpc-published`), the last response (`patch`) or, for `dpc`, the last up to 1.5 windows of its
/// cache and the mean beyond them.
///
/// A source is audible if sound can reach the listener (connected() in engine/rays/room_survey.h)
/// and is_audible() is true for its response. Returns empty if `progress` requested a stop. Throws
/// InputError.
std::optional<Measurement> measure(const Scene& scene, std::optional<int> frames,
                                   const Progress& progress = {});

/// The impulse response of one source as the renderer plays it for a static listener: sample 0 is
/// emission, the source's gain is applied. [channel][sample], of the response's length, or longer
/// if distant direct sound requires it. The HRTF (at the options' rate) is needed for binaural
/// output only.
std::vector<std::vector<float>> impulse_response(const Scene& scene, std::size_t source,
                                                 const Measurement& measurement,
                                                 const SessionOptions& options,
                                                 const std::shared_ptr<const Hrtf>& hrtf);

}  // namespace aula
