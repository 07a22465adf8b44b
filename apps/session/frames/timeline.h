#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "apps/session/frames/signals.h"
#include "engine/scene/scene.h"

namespace aula {

/// How long a session plays. From `input_end_s` on the signals that would go on are faded out;
/// what is left until `end_s` is the room ringing out.
struct Timeline {
    double input_end_s = std::numeric_limits<double>::infinity();
    double end_s = std::numeric_limits<double>::infinity();

    static constexpr double kFade_s = 0.02;

    /// Fades a block of a signal that starts at sample `first`: gain 1, from the end of the input
    /// a raised cosine, then 0. [audio thread, wait-free]
    void fade(std::int64_t first, double sample_rate_hz,
              std::span<float> block) const noexcept AULA_NONBLOCKING;

    /// Fades what is heard alike, to be silent from `end_s` on. [audio thread, wait-free]
    void end(std::int64_t first, double sample_rate_hz,
             std::span<float> block) const noexcept AULA_NONBLOCKING;
};

/// What a timeline is made from.
struct TimelineInput {
    const Scene& scene;
    const SignalSet& signals;
    double sample_rate_hz;
    double response_length_s;
    std::optional<double> duration_s;  ///< as asked for: exactly that long
};

/// For rendering: to the end of the last unlooped path or, if later, signal, and its tail; if
/// there are only loops one round of the longest; if nothing is finite 10 s. The tail is the
/// response's length or the time that sound takes from the farthest source, whichever is longer.
Timeline offline_timeline(const TimelineInput& input);

/// For playing: to the end of the last unlooped path or signal, and its tail; without an end if no
/// path ends and some signal goes on.
Timeline live_timeline(const TimelineInput& input);

}  // namespace aula
