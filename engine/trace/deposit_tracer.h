#pragma once

#include "aula/engine/time_bins.h"
#include "engine/patches/patch_grid.h"
#include "engine/trace/path_tracer.h"

namespace aula {

/// A path tracer for `patch`. Collects deposits on the cells of a grid, and the segments of paths
/// that no gather finds: purely specular paths and, if the order is limited, all paths that end in
/// a mirror. (A patch does not store the order of its energy, so a gather ray cannot tell whether a
/// further reflection is within the limit.)
class DepositTracer : public PathTracer {
 public:
    DepositTracer(const RayScene& scene, const PatchGrid& grid, const TimeBins& bins,
                  const SpecularPaths& images, const TraceSettings& settings)
        : PathTracer(scene, images, settings, settings.specular), grid_(grid), bins_(bins) {}

    /// Traces one batch of an emitter's rays; adds to `out`.
    void trace(const Emitter& emitter, std::uint64_t frame_seed, int batch,
               DepositBatch& out) const;

 private:
    void collect_segments(const PathBatch& paths, int order, const Emitter& emitter,
                          DepositBatch& out) const;
    void collect_deposits(const PathBatch& paths, DepositBatch& out) const;

    const PatchGrid& grid_;
    const TimeBins& bins_;
};

}  // namespace aula
