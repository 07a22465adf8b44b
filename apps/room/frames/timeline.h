#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "apps/room/frames/signals.h"
#include "aula/engine/scene.h"

namespace aula {

/// The duration of a rendering or playback. At `input_end_s` the signals that would continue are
/// faded out; from then until `end_s` the room rings out.
struct Timeline {
    double input_end_s = std::numeric_limits<double>::infinity();
    double end_s = std::numeric_limits<double>::infinity();

    static constexpr double kFade_s = 0.02;

    /// Fades a block of a signal that starts at sample `first`: gain 1, from the end of the input a
    /// raised cosine, then 0. [audio thread, wait-free]
    void fade(std::int64_t first, double sample_rate_hz,
              std::span<float> block) const noexcept AULA_NONBLOCKING;

    /// Fades the output in the same shape, silent from `end_s` on. [audio thread, wait-free]
    void end(std::int64_t first, double sample_rate_hz,
             std::span<float> block) const noexcept AULA_NONBLOCKING;
};

/// The input of the timeline functions.
struct TimelineInput {
    const Scene& scene;
    const SignalSet& signals;
    double sample_rate_hz;
    double response_length_s;
    std::optional<double> duration_s;  ///< requested, exact duration
};

/// For rendering: until the end of the last unlooped path or, if later, signal, plus the tail. If
/// there are only loops, one period of the longest; if nothing is finite, 10 s. The tail is the
/// response's length or the travel time from the farthest source, whichever is longer.
Timeline offline_timeline(const TimelineInput& input);

/// For live playback: until the end of the last unlooped path or signal, plus the tail; infinite if
/// no path ends and some signal continues.
Timeline live_timeline(const TimelineInput& input);

}  // namespace aula
