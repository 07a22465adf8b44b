#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "aula/engine/energy_response.h"
#include "aula/engine/frame.h"
#include "engine/direct/edge_paths.h"
#include "engine/rays/oriented_directivity.h"
#include "engine/rays/ray_scene.h"
#include "engine/trace/specular_paths.h"

namespace aula {

/// A frame as input to the estimators.
struct PropagationFrame {
    const FrameInput& input;
    std::uint64_t number = 0;  ///< since the start
    std::uint64_t seed = 0;    ///< of this frame
    double travel_m = 0;       ///< accumulated movement of the scene since the start
    std::vector<OrientedDirectivity> directivities{};  ///< [source]
};

/// What belongs to a source at one listener, or at a receiver at rest.
struct Pair {
    EnergyResponse response;
    SpecularSound images;  ///< of the newest frame
    PairMemory memory;     ///< of the direct sound
};

/// A pair with its ends in a frame.
struct FramePair {
    const Vec3& source;
    const Vec3& listener;
    const OrientedDirectivity& directivity;  ///< of the source
    Pair& pair;
};

/// From traced rays to energy responses, the part that the estimators do not share. Propagation
/// moves the scene and finds the image sources; an estimator traces rays, maintains its caches and
/// computes the energy that no image source counts. What only patches do is in PatchPropagation.
/// [propagation thread]
class ResponseEstimator {
 public:
    virtual ~ResponseEstimator() = default;

    /// Clears all caches.
    virtual void restart() = 0;

    /// Appends a source; `id` selects its random numbers.
    virtual void add_source(std::size_t id, const Vec3& position,
                            const OrientedDirectivity& directivity) = 0;
    virtual void remove_source(std::size_t source) = 0;

    /// Sets the rays per emitter from the next frame on.
    virtual void set_rays(int rays) = 0;

    /// Traces a frame and updates the responses of its pairs, [source * listener count + listener],
    /// without their paths. Their images are those of the frame. Adds to `statistics`.
    virtual void step(const PropagationFrame& frame, std::span<const FramePair> pairs,
                      FrameStatistics& statistics) = 0;

    /// The rays of the next step if nothing moves.
    virtual std::vector<Ray> rays(const PropagationFrame& frame) const = 0;

    /// The first `count` paths from a source in that frame, up to reflection order `order`.
    virtual std::vector<PathLine> path_lines(const PropagationFrame& frame, std::size_t source,
                                             int count, int order) const = 0;
};

}  // namespace aula
