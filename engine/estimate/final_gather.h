#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/worker_pool.h"
#include "engine/estimate/patch_cache.h"
#include "engine/patches/patch_grid.h"
#include "engine/rays/ray_scene.h"
#include "engine/response/energy_response.h"

namespace aula {

/// Rays from a receiver that met a patch after about the same length: what the patch radiates
/// arrives with this weight, this much later, from this direction.
struct GatherHit {
    std::uint32_t patch = 0;
    float length_m = 0;
    Vec3 direction{0};  ///< from the receiver, the mean of units
    Bands weight;       ///< 4 / (M A) * mirror segments * air, 1/m2, the sum of them
    bool late = false;  ///< of the rays that stand for all in the late part of the response
};

struct GatherSettings {
    int rays = 1024;      ///< M
    bool mirrors = true;  ///< rays go on as mirror rays
    float max_length_m = 343;
    Bands attenuation_per_m;
};

/// Traces M low-discrepancy rays from a receiver, the listener or, where a listener emits, a
/// source; at partly specular surfaces they go on as mirror rays. Hits come by patch, late
/// ones first. Adds to `segments`. [propagation thread]
std::vector<GatherHit> trace_gather(const RayScene& scene, const PatchGrid& grid,
                                    const Vec3& receiver, const GatherSettings& settings,
                                    std::uint64_t frame_seed, WorkerPool& workers,
                                    std::uint64_t& segments);

/// The rays that trace_gather sends, batch after batch, to be traced elsewhere.
std::vector<Ray> gather_rays(const RayScene& scene, const PatchGrid& grid, const Vec3& receiver,
                             const GatherSettings& settings, std::uint64_t frame_seed);

/// Adds `share` times what the patches radiate to a response. Directions are those in which sound
/// comes to the listener: the hits' own, or, if the cache is a listener's, what it keeps.
/// [propagation thread]
void add_gathered(const std::vector<GatherHit>& hits, const PatchCache& cache, double share,
                  WorkerPool& workers, EnergyResponse& response);

}  // namespace aula
