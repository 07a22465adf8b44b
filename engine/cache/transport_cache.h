#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "aula/engine/time_bins.h"
#include "engine/base/worker_pool.h"
#include "engine/cache/patch_cache.h"
#include "engine/patches/patch_grid.h"
#include "engine/patches/patch_regions.h"
#include "engine/trace/trace_batch.h"

namespace aula {

/// The transport of sound between surfaces: the energy that the patches of a region radiate at a
/// time after the patches of another region have radiated unit energy. A diffuse reflection forgets
/// where its path has come from, so the reflections of all paths are samples of it, whichever end
/// the paths have left: it stays valid while source and listener move, as in acoustic radiance
/// transfer (Siltanen et al. 2007), where it is computed and not learnt. Inside a region, energies
/// are distributed as late in the response.
/// [propagation thread]
class TransportCache {
 public:
    /// `memory_bytes` limits the number of regions.
    TransportCache(const RayScene& scene, const PatchGrid& grid, const TimeBins& bins,
                   double memory_bytes, WorkerPool& workers);

    /// Forgets everything.
    void restart();

    /// Finds the regions of the grid's present rows, and forgets everything.
    void find_regions();

    /// The region of every row of the grid, or PatchRegions::kNone.
    std::span<const std::uint32_t> regions() const { return regions_->of_rows(); }
    std::size_t region_count() const { return regions_->count(); }
    float region_size_m() const { return regions_->size_m(); }

    /// Number of regions from which transport is learnt: the first, largest ones.
    std::size_t start_count() const { return std::min(region_count(), most_starts_); }

    /// See DepositTracer::Regions::hand_over_m.
    float hand_over_m() const;

    /// For every row: how much of the energy that leaves it arrives elsewhere, relative to other
    /// rows of its region. By reciprocity it is proportional to the irradiance.
    std::span<const float> importance() const { return importance_; }

    /// The share of a row in the energy that its region radiates, in each band.
    const Bands& share(std::uint32_t row) const { return shares_[row]; }

    /// Learns from the paths of `rays` rays.
    void learn(std::span<const DepositBatch> batches, int rays);

    /// Number of rays that it has learnt from.
    std::uint64_t rays() const { return transport_.emitted(); }

    /// Sets the energy that regions radiate from hand_over_m() after the energy that
    /// was `handed_over`, times the importance of its rows, by each of them. `radiated` has no
    /// energy yet.
    void predict(const PatchCache& handed_over, PatchCache& radiated) const;

    std::size_t memory_bytes() const { return transport_.memory_bytes(); }

 private:
    /// What is known of a row from late in the response.
    struct Late {
        float hits = 0;
        float arrived = 0;  ///< energy relative to the mean of its time bin
        Bands radiated;     ///< the same
    };

    void count_late(std::span<const DepositBatch> batches);
    void find_shares();
    std::vector<Bands> per_start() const;

    const RayScene& scene_;
    const PatchGrid& grid_;
    TimeBins bins_;
    WorkerPool& workers_;
    std::size_t most_starts_;
    std::optional<PatchRegions> regions_;
    std::vector<Late> late_;           ///< [row]
    std::vector<double> late_energy_;  ///< [bin]
    std::vector<double> late_hits_;    ///< [bin]
    std::vector<float> importance_;    ///< [row]
    std::vector<Bands> shares_;        ///< [row]

    PatchCache transport_;        ///< [from * region_count() + to]
    std::vector<Bands> starts_;   ///< [from][first bin that is not observed] energy that has left
    std::vector<float> started_;  ///< [row] number of starts
};

}  // namespace aula
