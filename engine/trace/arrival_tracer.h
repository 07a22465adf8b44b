#pragma once

#include <span>

#include "engine/patches/patch_subdivision.h"
#include "engine/rays/receiver.h"
#include "engine/trace/path_tracer.h"

namespace aula {

/// A path tracer for `pt` and `dpc*`. Collects the arrivals of diffusely reflected paths at
/// receivers, and the segments of purely specular paths, each with its path identifier.
class ArrivalTracer : public PathTracer {
 public:
    ArrivalTracer(const RayScene& scene, const PatchSubdivision& subdivision,
                  const SpecularPaths& images, const TraceSettings& settings)
        : PathTracer(scene, images, settings), subdivision_(subdivision) {}

    /// Traces one batch of an emitter's rays; adds to `out`.
    void trace(const Emitter& emitter, std::span<const Receiver> receivers,
               std::uint64_t frame_seed, int batch, ArrivalBatch& out) const;

 private:
    void collect_segments(const PathBatch& paths, int order, const Emitter& emitter,
                          ArrivalBatch& out) const;
    void collect_arrivals(const PathBatch& paths, const Emitter& emitter,
                          std::span<const Receiver> receivers, ArrivalBatch& out) const;
    void extend_identifiers(PathBatch& paths) const;

    const PatchSubdivision& subdivision_;
};

}  // namespace aula
