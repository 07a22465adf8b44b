#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace aula {

/// What the plan knows of an emitter in this frame.
struct EmitterStatus {
    bool changed = false;            ///< it or the scene has moved since the last frame
    bool complete = false;           ///< more rays would bring nothing
    std::uint64_t emitted_rays = 0;  ///< rays that its cache holds
};

/// From which ends rays are sent in a frame, and how many batches of them.
struct EmissionPlan {
    std::vector<int> sources;    ///< [source] batches
    std::vector<int> listeners;  ///< [listener] batches
};

/// Sound travels both ways alike, so that a source and a listener are joined by the rays of either.
/// Best are rays from an end that stands, as they go on holding:
///
/// * a source that stands sends rays itself, wherever the listeners go;
/// * for sources that have moved rays are sent by the listeners that stand;
/// * where both ends have moved, by the fewer of them.
///
/// Whoever has moved sends `most` batches. Those that stand share twice as many, who has gathered
/// least first; all of them begin at once. [propagation thread]
EmissionPlan plan_emission(std::span<const EmitterStatus> sources,
                           std::span<const EmitterStatus> listeners, int most, int batch_rays);

}  // namespace aula
