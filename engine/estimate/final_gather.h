#pragma once

#include <cstdint>
#include <vector>

#include "aula/engine/energy_response.h"
#include "engine/base/worker_pool.h"
#include "engine/cache/patch_cache.h"
#include "engine/patches/patch_grid.h"
#include "engine/rays/ray_scene.h"
#include "engine/trace/path_tracer.h"

namespace aula {

/// Gather rays from a receiver that met a patch at about the same length: the patch's radiated
/// energy arrives with this weight, delay and direction.
struct GatherHit {
    std::uint32_t patch = 0;
    float length_m = 0;
    Vec3 direction{0};  ///< from the receiver, the mean of unit vectors
    Bands weight;       ///< sum of 4 / (M A) * mirror reflections * air, 1/m2
    bool late = false;  ///< of the subset that represents all rays in the late response
};

struct GatherSettings {
    int rays = 1024;      ///< M
    bool mirrors = true;  ///< rays continue as mirror rays
    float max_length_m = 343;
    Bands attenuation_per_m;
};

/// Final gather (Jensen 1996): traces M low-discrepancy rays from a receiver, which is the listener
/// or, where a listener emits, a source with its directivity. At partly specular surfaces rays
/// continue as mirror rays. Hits are sorted by patch, late ones first. Adds the ray segments to
/// `segments`. [propagation thread]
std::vector<GatherHit> trace_gather(const RayScene& scene, const PatchGrid& grid,
                                    const Emitter& receiver, const GatherSettings& settings,
                                    std::uint64_t frame_seed, WorkerPool& workers,
                                    std::uint64_t& segments);

/// The rays that trace_gather emits, batch after batch, for tracing by other code.
std::vector<Ray> gather_rays(const RayScene& scene, const PatchGrid& grid, const Emitter& receiver,
                             const GatherSettings& settings, std::uint64_t frame_seed);

/// Adds `share` times the energy radiated by the patches to a response. The directions of arrival
/// at the listener are those of the hits or, for a listener's cache, those stored in the cache.
/// [propagation thread]
void add_gathered(const std::vector<GatherHit>& hits, const PatchCache& cache, double share,
                  WorkerPool& workers, EnergyResponse& response);

}  // namespace aula
