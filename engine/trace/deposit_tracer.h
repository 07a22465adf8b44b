#pragma once

#include <span>

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

    /// What paths are followed for.
    enum class Extent {
        whole,        ///< all deposits
        teaching,     ///< the same, and to learn the transport between regions
        handed_over,  ///< the same, and to be predicted after the hand-over
        near          ///< to be predicted after the hand-over, where they end
    };

    /// The regions of a TransportCache, [row]. The spans must remain valid.
    struct Regions {
        std::span<const std::uint32_t> of_row;
        std::span<const float> importance;
        std::size_t count = 0;
        std::size_t start_count = 0;  ///< the first regions, to which energy is handed over
        /// From this length after its first diffuse reflection on, a path's energy is predicted by
        /// the transport between regions. Before, it depends on the places inside them.
        float hand_over_m = 0;

        bool is_start(std::uint32_t row) const { return of_row[row] < start_count; }
    };

    /// To be called before paths of another extent than `whole` are traced.
    void set_regions(const Regions& regions) { regions_ = regions; }

    /// Traces one batch of an emitter's rays; adds to `out`.
    void trace(const Emitter& emitter, std::uint64_t frame_seed, int batch, Extent extent,
               DepositBatch& out) const;

 private:
    void collect_segments(const PathBatch& paths, int order, const Emitter& emitter,
                          DepositBatch& out) const;
    void collect_deposits(PathBatch& paths, Extent extent, DepositBatch& out) const;

    const PatchGrid& grid_;
    const TimeBins& bins_;
    Regions regions_;
};

}  // namespace aula
