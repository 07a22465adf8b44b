#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "aula/engine/simulation.h"
#include "engine/base/worker_pool.h"
#include "engine/cache/diffuse_path_cache.h"
#include "engine/estimate/response_estimator.h"
#include "engine/patches/patch_subdivision.h"
#include "engine/trace/arrival_tracer.h"

namespace aula {

/// The estimators `pt`, `dpc-published` and `dpc`: sources emit rays, and receiver spheres around
/// the listeners detect them. `pt` takes the arrivals of the frame; `dpc*` keep those of many
/// frames in a diffuse path cache for each source and listener. [propagation thread]
class PathPropagation final : public ResponseEstimator {
 public:
    PathPropagation(const RayScene& scene, const SpecularPaths& images,
                    const Simulation& simulation, const TraceSettings& trace,
                    std::size_t source_count, std::size_t listener_count, WorkerPool& workers);
    PathPropagation(const PathPropagation&) = delete;
    PathPropagation& operator=(const PathPropagation&) = delete;

    void restart() override;
    void add_source(std::size_t id, const Vec3& position,
                    const OrientedDirectivity& directivity) override;
    void remove_source(std::size_t source) override;
    void set_rays(int rays) override;
    void step(const PropagationFrame& frame, std::span<const FramePair> pairs,
              FrameStatistics& statistics) override;
    std::vector<Ray> rays(const PropagationFrame& frame) const override;
    std::vector<PathLine> path_lines(const PropagationFrame& frame, std::size_t source, int count,
                                     int order) const override;

 private:
    struct TracedSource {
        std::size_t id = 0;  ///< selects the random numbers
        std::vector<ArrivalBatch> batches;
        std::vector<DiffusePathCache> caches;  ///< [listener]; none for `pt`
    };

    int ray_count() const { return tracer_.rays_of(tracer_.batch_count()); }
    Emitter emitter(std::size_t source, const PropagationFrame& frame) const;
    void divide_memory();
    TracedSource make_source(std::size_t id) const;
    void trace(const PropagationFrame& frame);

    const RayScene& scene_;
    WorkerPool& workers_;
    std::optional<DiffusePathCache::Readout> readout_;  ///< none: no caches
    int window_frames_;
    double memory_bytes_;
    float listener_radius_m_;
    Bands attenuation_per_m_;
    std::size_t listener_count_;
    PatchSubdivision subdivision_;
    ArrivalTracer tracer_;
    std::vector<TracedSource> sources_;
};

}  // namespace aula
