#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "aula/engine/energy_response.h"
#include "engine/base/shifted_histogram.h"
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
/// continue as mirror rays.
class FinalGather {
 public:
    /// `scene` and `grid` must outlive the gather.
    FinalGather(const RayScene& scene, const PatchGrid& grid, const Emitter& receiver,
                const GatherSettings& settings, std::uint64_t frame_seed);

    std::size_t batch_count() const { return batches_.size(); }

    /// Traces one batch of the rays. Call once for each batch. [any thread]
    void trace(std::size_t batch);

    /// After all batches: the hits sorted by patch, late ones first.
    const std::vector<GatherHit>& hits() const { return hits_; }

    /// After all batches: the number of ray segments.
    std::uint64_t segments() const;

    /// The rays of all batches, one after another, for tracing by other code.
    std::vector<Ray> rays() const;

 private:
    struct Batch {
        std::vector<GatherHit> hits;
        std::uint64_t segments = 0;
    };
    template <typename Sent>
    void trace(std::size_t batch, std::vector<GatherHit>& out, const Sent& sent) const;
    void join();

    const RayScene& scene_;
    const PatchGrid& grid_;
    Emitter receiver_;
    GatherSettings settings_;
    std::uint64_t frame_seed_;
    std::vector<Batch> batches_;
    std::atomic<std::size_t> batches_left_;
    std::vector<GatherHit> hits_;
};

/// The energy that a pair's gathers add to its response. The directions of arrival at the listener
/// are those of the hits or, for a listener's cache, those stored in the cache.
class GatheredEnergy {
 public:
    /// Adds `share` times the energy radiated by the patches. Hits and cache must remain unchanged
    /// until the last part has been summed.
    void add(const std::vector<GatherHit>& hits, const PatchCache& cache, double share);

    /// 0 if nothing is added.
    std::size_t part_count() const { return parts_.size(); }

    /// Sums one part. Call once for each part, after all add(). True in the last call, which has
    /// added all parts to `response`: the same to the bit for any order of the calls. [any thread]
    bool sum(std::size_t part, EnergyResponse& response);

 private:
    struct Gather {
        const std::vector<GatherHit>& hits;
        const PatchCache& cache;
        float scale;
    };
    std::vector<Gather> gathers_;
    std::vector<std::optional<ShiftedHistogram>> parts_;  ///< those of each gather in turn
    std::atomic<std::size_t> parts_summed_ = 0;
};

}  // namespace aula
