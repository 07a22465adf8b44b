#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "aula/engine/simulation.h"
#include "engine/cache/patch_cache.h"
#include "engine/cache/row_pool.h"
#include "engine/cache/segment_cache.h"
#include "engine/estimate/emission_plan.h"
#include "engine/estimate/final_gather.h"
#include "engine/estimate/gather_plan.h"
#include "engine/estimate/pair_response.h"
#include "engine/estimate/response_estimator.h"
#include "engine/patches/patch_grid.h"
#include "engine/rays/receiver.h"
#include "engine/trace/deposit_tracer.h"

namespace aula {

/// The estimator `patch`: time-resolved radiosity by particle tracing with final gather (Jensen
/// 1996). As in acoustic radiance transfer (Siltanen et al. 2007), surfaces store time-dependent
/// energy that is gathered at the receiver; here rays deposit it, and no patch-to-patch transfer is
/// computed.
///
/// Every source and every listener has a cache of the energy that patches radiate for its rays.
/// plan_emission() selects the ends that emit; the other end gathers. If the caches of both ends
/// hold rays, each contributes in proportion to its rays, so that a change of the emitting end is
/// inaudible. While source, listener and scene are static, the gathered response is the mean of all
/// frames since the last change, weighted by their rays. Purely specular paths whose image sources
/// are not tried come from the rays' segments. [propagation thread]
class PatchPropagation final : public ResponseEstimator {
 public:
    /// `inside`: points in the space that sound can reach. The patch size is that of `simulation`,
    /// or larger if memory requires it.
    PatchPropagation(const RayScene& scene, const SpecularPaths& images,
                     const Simulation& simulation, const TraceSettings& trace, const TimeBins& bins,
                     std::span<const Vec3> inside, std::size_t source_count,
                     std::size_t listener_count, WorkerPool& workers);
    PatchPropagation(const PatchPropagation&) = delete;
    PatchPropagation& operator=(const PatchPropagation&) = delete;

    /// The number of patches for whose energies a memory suffices, in the caches of these emitters.
    static double max_rows(double memory_bytes, const TimeBins& bins, std::size_t source_count,
                           std::size_t listener_count);

    void restart() override;
    void add_source(std::size_t id, const Vec3& position,
                    const OrientedDirectivity& directivity) override;
    void remove_source(std::size_t source) override;
    void set_rays(int rays) override { tracer_.set_rays(rays); }
    void step(const PropagationFrame& frame, std::span<const FramePair> pairs,
              FrameStatistics& statistics) override;
    std::vector<Ray> rays(const PropagationFrame& frame) const override;
    std::vector<PathLine> path_lines(const PropagationFrame& frame, std::size_t source, int count,
                                     int order) const override;

    /// See Propagation::emit_from_listeners.
    void emit_from_listeners() { from_listeners_ = true; }

    /// Updates the patches after a change of the scene's materials.
    void materials_changed();

    /// Updates the patches after RayScene::move.
    void scene_moved();

    /// Adds to the responses of `pairs` what their paths do not contain, [source * receivers +
    /// receiver], from the caches of the last step, whose frame `frame` is except for its
    /// listeners: these are the receivers. Adds to `statistics`.
    void gather_at(const PropagationFrame& frame, std::span<const FramePair> pairs,
                   FrameStatistics& statistics);

    /// See Propagation::patch_energies. If only listeners emit: the energy that would reach the
    /// first listener.
    std::vector<PatchEnergy> patch_energies(std::size_t source, double begin_s, double end_s) const;

    float patch_size_m() const { return grid_.patch_size_m(); }

 private:
    /// An emitter, which is also a receiver: a source or a listener.
    struct End {
        std::size_t id = 0;  ///< selects the random numbers
        PatchCache cache;
        SegmentCache segments;
        EmitterStatus status;
        std::optional<SegmentCache::State> state;  ///< in the last frame
        Receiver receiver;
        // Of sources.
        OrientedDirectivity directivity{};  ///< in the last frame
        double turned_m = 0;                ///< see OrientedDirectivity::turned_m
        std::vector<PairResponse> pairs{};  ///< [listener]
    };

    /// The ends of a pair, by their index in a frame.
    struct PairEnds {
        std::size_t source = 0;
        std::size_t listener = 0;
    };

    void find_mirrors();
    void clear_caches();

    std::size_t emitter_count() const { return ends_.size(); }
    std::size_t source_count() const { return ends_.size() - listener_count_; }
    PairEnds ends_of(std::size_t pair) const {
        return {pair / listener_count_, source_count() + pair % listener_count_};
    }
    PairResponse& response_of(std::size_t pair) {
        return ends_[pair / listener_count_].pairs[pair % listener_count_];
    }
    std::size_t max_segments(bool directed) const;
    std::size_t segment_bytes() const;
    void divide_segments();
    void reserve_rows(std::uint64_t frame);
    End make_end(std::size_t id, bool directed) const;
    Emitter emitter(std::size_t e, const PropagationFrame& frame) const;
    void advance(const PropagationFrame& frame);
    std::vector<int> plan_batches(std::span<const EmitterStatus> status, std::uint64_t frame) const;
    void trace(const PropagationFrame& frame, const std::vector<int>& batches,
               FrameStatistics& statistics);
    void update(const std::vector<int>& batches);
    std::vector<EmitterStatus> status() const;
    std::vector<std::uint64_t> emitted() const;
    std::vector<PairStatus> pair_status() const;
    bool scene_moved_recently(std::uint64_t frame) const;
    GatherPlan plan_gather(std::uint64_t frame, std::span<const char> wanted,
                           std::span<const std::uint64_t> emitted) const;
    void gather(const PropagationFrame& frame, std::span<const FramePair> pairs,
                FrameStatistics& statistics);
    void gather_at_receivers(std::size_t first, std::size_t end, const PropagationFrame& frame,
                             const GatherPlan& plan, std::vector<std::function<void()>> jobs,
                             FrameStatistics& statistics);
    GatherSettings gather_settings(int rays) const;
    std::uint64_t gather_seed(const PropagationFrame& frame, std::size_t receiver) const;
    void detect(std::size_t pair);
    void complete_pair(std::size_t i, bool gathered, Pair& pair);

    const RayScene& scene_;
    WorkerPool& workers_;
    TimeBins bins_;
    int window_frames_;
    bool from_listeners_ = false;
    bool rays_may_mirror_ = false;
    bool mirrors_ = false;  ///< paths that end in a mirror are left to the rays
    float listener_radius_m_;
    float speed_of_sound_m_s_;
    double memory_bytes_;
    std::size_t listener_count_;
    PatchGrid grid_;
    DepositTracer tracer_;
    GatherSettings gather_settings_;

    std::shared_ptr<RowPool> row_pool_;  // of all caches
    std::vector<End> ends_;              // sources before listeners

    std::vector<DepositBatch> batches_;  // of the emitters in this frame, in order

    std::vector<std::optional<Receiver>> resting_;  // of the newest gather_at()

    double travel_m_ = 0;
    std::optional<std::uint64_t> last_move_;  // the last frame in which the scene moved
};

}  // namespace aula
