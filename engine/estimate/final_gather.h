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
    DirectionMoments directions;  ///< from the receiver, of unit energy
    Bands weight;                 ///< sum of 4 / (M A) * mirror reflections * air, 1/m2
    bool late = false;            ///< of the subset that represents all rays in the late response
};

struct GatherSettings {
    int rays = 1024;      ///< M
    bool mirrors = true;  ///< rays continue as mirror rays
    float max_length_m = 343;
    Bands attenuation_per_m{};
};

/// Final gather (Jensen 1996): traces M low-discrepancy rays from a receiver, which is the listener
/// or, where a listener emits, a source with its directivity. At partly specular surfaces rays
/// continue as mirror rays.
class FinalGather {
 public:
    /// `scene` and `grid` must outlive the gather.
    FinalGather(const RayScene& scene, const PatchGrid& grid, const Emitter& receiver,
                const GatherSettings& settings, std::uint64_t frame_seed);

    /// Rays of a batch, which one job traces. A choice: smaller ones divide a gather of 1000 rays
    /// evenly among eight threads.
    static constexpr int kBatchRays = 128;

    std::size_t batch_count() const { return batches_.size(); }

    /// Traces one batch of the rays. Call once for each batch. [any thread]
    void trace(std::size_t batch);

    /// The hits, sorted by patch, late ones first; empty before all batches are traced.
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

    const RayScene& scene_;
    const PatchGrid& grid_;
    Emitter receiver_;
    GatherSettings settings_;
    std::uint64_t frame_seed_;
    std::vector<Batch> batches_;
    std::atomic<std::size_t> batches_left_;
    std::vector<GatherHit> hits_;
};

/// Adds the energy of a pair's gathers to its response. The directions of arrival at the listener
/// are those of the hits or, for a listener's cache, those stored in the cache.
class GatheredEnergy {
 public:
    /// The response must outlive it. The hits of each gather are summed in `divisions` parts.
    GatheredEnergy(EnergyResponse& response, std::size_t divisions)
        : response_(response), divisions_(divisions) {}

    /// Takes `share` times the energy that the patches radiate. The hits, which may follow after
    /// this call, and the cache must remain unchanged while parts are summed.
    void add(const std::vector<GatherHit>& hits, const PatchCache& cache, double share);

    std::size_t part_count() const { return parts_.size(); }

    /// Sums one part. Call once for each part, after all add(). The last call adds all parts to the
    /// response: the same to the bit for any order of the calls. [any thread]
    void sum(std::size_t part);

    /// After all parts: the number of time bins of patches that were added.
    std::uint64_t summed_bins() const { return summed_bins_; }

 private:
    struct Gather {
        const std::vector<GatherHit>& hits;
        const PatchCache& cache;
        float scale;
    };
    EnergyResponse& response_;
    std::size_t divisions_;
    std::vector<Gather> gathers_;
    std::vector<std::optional<ShiftedHistogram>> parts_;  ///< those of each gather in turn
    std::atomic<std::size_t> parts_summed_ = 0;
    std::atomic<std::uint64_t> summed_bins_ = 0;
};

}  // namespace aula
