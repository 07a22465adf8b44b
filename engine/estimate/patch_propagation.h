#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "aula/engine/frame.h"
#include "engine/estimate/emission_plan.h"
#include "engine/estimate/final_gather.h"
#include "engine/estimate/frame_view.h"
#include "engine/estimate/patch_cache.h"
#include "engine/estimate/segment_cache.h"
#include "engine/patches/patch_grid.h"
#include "engine/rays/receiver.h"
#include "engine/trace/deposit_tracer.h"
#include "engine/trace/specular_paths.h"
#include "engine/trace/specular_sum.h"

namespace aula {

/// A frame as input to the estimators.
struct PropagationFrame {
    const FrameInput& input;
    std::uint64_t number = 0;  ///< since the start
    std::uint64_t seed = 0;    ///< of this frame
    double travel_m = 0;       ///< accumulated movement of the scene since the start
};

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
class PatchPropagation {
 public:
    /// `inside`: points in the space that sound can reach. The patch size is that of `simulation`,
    /// or larger if memory requires it.
    PatchPropagation(const RayScene& scene, const SpecularPaths& images,
                     const Simulation& simulation, const TraceSettings& trace, const TimeBins& bins,
                     std::span<const Vec3> inside, std::size_t source_count,
                     std::size_t listener_count, WorkerPool& workers);
    PatchPropagation(const PatchPropagation&) = delete;
    PatchPropagation& operator=(const PatchPropagation&) = delete;

    /// Clears all caches.
    void restart();

    /// Appends a source; `id` selects its random numbers.
    void add_source(std::size_t id, const Vec3& position);
    void remove_source(std::size_t source);

    /// Updates the estimator after a change of the scene's materials.
    void materials_changed();

    /// Updates the patches after RayScene::move.
    void scene_moved() { grid_.scene_moved(window_frames_); }

    /// Traces a frame and updates `responses` ([source * listener count + listener], without their
    /// paths). `images` are those of the frame, in the same order. Adds to `statistics`.
    void step(const PropagationFrame& frame, std::span<const SpecularSound> images,
              std::vector<EnergyResponse>& responses, FrameStatistics& statistics);

    /// The rays of the next step if nothing moves.
    std::vector<Ray> rays(const PropagationFrame& frame) const;

    /// The first `count` paths from a source in that frame, up to reflection order `order`.
    std::vector<PathLine> path_lines(const PropagationFrame& frame, std::size_t source, int count,
                                     int order) const;

    /// The energy that every patch radiates for a source within a time interval after emission. If
    /// only listeners emit, the part that would reach the first listener.
    std::vector<PatchEnergy> patch_energies(std::size_t source, double begin_s, double end_s) const;

    float patch_size_m() const { return grid_.patch_size_m(); }

    /// Sets the rays per emitter from the next frame on.
    void set_rays(int rays);

 private:
    /// A source and a listener.
    struct Pair {
        bool changed = false;           ///< since the last frame
        bool is_current = false;        ///< the response holds nothing from before the last change
        int frames = 0;                 ///< in the mean
        double weight = 0;              ///< of the mean, in rays
        EnergyResponse mean;            ///< of the gathered responses
        EnergyResponse newest;          ///< gathered in the present frame
        bool segments_current = false;  ///< all segments of the last frame were valid for these
                                        ///< positions and this scene
        SpecularSum specular;
    };
    /// Weights of the caches of both ends in a pair's response.
    struct Shares {
        double source = 0;
        double listener = 0;
    };
    struct GatherPlan {
        std::vector<Shares> shares;                      ///< [pair]
        std::vector<std::vector<std::size_t>> pairs_at;  ///< [receiver] pairs that gather there
    };

    std::size_t emitter_count() const { return source_count_ + listener_count_; }
    std::size_t cache_bytes(bool directed) const;
    std::size_t max_segments(bool directed) const;
    std::size_t segment_bytes() const;
    void divide_memory();
    Pair silent_pair() const;
    PatchCache make_cache(bool directed) const;
    SegmentCache make_segment_cache(bool directed) const;
    Emitter emitter(std::size_t id, const FrameInput& input) const;
    void advance(const PropagationFrame& frame);
    std::vector<int> plan_batches(std::span<const EmitterStatus> status) const;
    void trace(const PropagationFrame& frame, const std::vector<int>& batches,
               FrameStatistics& statistics);
    void update(const std::vector<int>& batches);
    std::vector<std::uint64_t> emitted() const;
    std::vector<char> pairs_to_gather(std::uint64_t frame) const;
    GatherPlan plan_gather(const std::vector<char>& wanted,
                           const std::vector<std::uint64_t>& emitted) const;
    void gather(const PropagationFrame& frame, const std::vector<char>& wanted,
                FrameStatistics& statistics);
    GatherSettings gather_settings(std::uint64_t frame) const;
    std::uint64_t gather_seed(const PropagationFrame& frame, std::size_t receiver) const;
    bool segments_current(std::size_t pair) const;
    bool is_current(std::size_t pair) const;
    void accumulate(std::size_t pair);
    void detect_segments(std::size_t pair);
    void sum_up(std::size_t pair, const SpecularSound& images, EnergyResponse& response) const;

    const RayScene& scene_;
    WorkerPool& workers_;
    TimeBins bins_;
    int window_frames_;
    bool rays_may_mirror_ = false;
    bool mirrors_ = false;  ///< paths that end in a mirror are left to the rays
    float listener_radius_m_;
    float speed_of_sound_m_s_;
    double memory_bytes_;
    std::size_t source_count_;
    std::size_t listener_count_;
    PatchGrid grid_;
    DepositTracer tracer_;
    GatherSettings gather_settings_;

    // [emitter], sources before listeners
    std::vector<std::size_t> ids_;  // select the random numbers
    std::vector<PatchCache> caches_;
    std::vector<SegmentCache> segment_caches_;
    std::vector<EmitterStatus> status_;
    std::vector<std::vector<DepositBatch>> batches_;  // [emitter][batch]
    std::vector<Vec3> positions_;                     // in the last frame
    std::vector<Receiver> receivers_;
    double travel_m_ = 0;
    std::optional<std::uint64_t> last_move_;  // the last frame in which the scene moved

    std::vector<Pair> pairs_;  // [source * listener_count + listener]
};

}  // namespace aula
