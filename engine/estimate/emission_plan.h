#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace aula {

/// Static emitters share the rays of as many. A choice: their rays accumulate, those of a moved one
/// do not, and the frames after a movement should not cost much less than those during one.
inline constexpr int kSharedEmitters = 2;

/// When all pairs have a mean over a window of frames, it is the turn of the listeners in one of as
/// many frames. A choice: a listener has its reserve after six seconds at 30 frames per second.
inline constexpr std::uint64_t kReserveTurn = 6;

/// An emitter's state in this frame, as input to the plan.
struct EmitterStatus {
    bool changed = false;            ///< the emitter or the scene has moved since the last frame
    bool complete = false;           ///< more rays would not reduce the error
    std::uint64_t emitted_rays = 0;  ///< rays in its cache
};

/// The emitters of a frame and the number of batches of each.
struct EmissionPlan {
    std::vector<int> sources;    ///< [source] batches
    std::vector<int> listeners;  ///< [listener] batches
};

/// Plans the emission of a frame. By reciprocity the rays of either end connect a source and a
/// listener. Rays of a static end are preferable, because they remain valid: a static source emits,
/// wherever the listeners move; for moved sources the static listeners emit; where both ends have
/// moved, the end with fewer emitters emits. If nothing has changed and it is the
/// `turn_of_listeners`, the listener with the fewest rays emits half of the rays: a reserve for the
/// next source that moves or is added. A moved emitter traces `max_batches`; static ones share
/// twice that, fewest rays first. Every static emitter without rays gets one batch first.
/// [propagation thread]
EmissionPlan plan_emission(std::span<const EmitterStatus> sources,
                           std::span<const EmitterStatus> listeners, bool turn_of_listeners,
                           int max_batches, int batch_rays);

}  // namespace aula
