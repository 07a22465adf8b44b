#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/estimate/emission_plan.h"
#include "engine/estimate/final_gather.h"
#include "engine/estimate/frame.h"
#include "engine/estimate/frame_view.h"
#include "engine/estimate/patch_cache.h"
#include "engine/estimate/segment_cache.h"
#include "engine/patches/patch_grid.h"
#include "engine/trace/path_tracer.h"
#include "engine/trace/specular_paths.h"
#include "engine/trace/specular_sum.h"

namespace aula {

/// A frame as the estimators see it.
struct PropagationFrame {
    const FrameInput& input;
    std::uint64_t number = 0;  ///< since the start
    std::uint64_t seed = 0;    ///< of this frame
    double travel_m = 0;       ///< how far anything in the scene has moved since the start
};

/// The estimator `patch`. Every source and every listener has a cache of what the patches radiate
/// of its rays; rays are sent from the ends that serve best (plan_emission), and gathered at the
/// other end. Where the caches of both ends hold rays, each answers with a share in proportion to
/// its rays, so that a change of end is never heard. While source, listener and scene stand, what
/// is gathered is the mean of all frames since, each with the weight of its rays. Purely specular
/// paths whose image sources are not tried come from the rays' segments. [propagation thread]
class PatchPropagation {
 public:
    /// `inside`: points in the space that sound can reach. Patches are as large as `simulation`
    /// says, or larger where memory asks for it.
    PatchPropagation(const RayScene& scene, const SpecularPaths& images,
                     const Simulation& simulation, const TraceSettings& trace, const TimeBins& bins,
                     std::span<const Vec3> inside, std::size_t source_count,
                     std::size_t listener_count, WorkerPool& workers);
    PatchPropagation(const PatchPropagation&) = delete;
    PatchPropagation& operator=(const PatchPropagation&) = delete;

    /// Forgets everything cached.
    void restart();

    /// Adds a source behind the others; `id` is that of its random numbers.
    void add_source(std::size_t id, const Vec3& position);
    void remove_source(std::size_t source);

    /// Follows a change of the scene's materials.
    void materials_changed();

    /// Brings the patches up to date after RayScene::move.
    void scene_moved() { grid_.scene_moved(window_frames_); }

    /// Traces a frame and brings `responses` ([source * listener count + listener], without their
    /// paths) up to date; `images` are the frame's, in the same order. Adds to `statistics`.
    void step(const PropagationFrame& frame, std::span<const SpecularSound> images,
              std::vector<EnergyResponse>& responses, FrameStatistics& statistics);

    /// The rays of the next step if nothing moves.
    std::vector<Ray> rays(const PropagationFrame& frame) const;

    /// The first `count` paths from a source in that frame, up to a reflection order.
    std::vector<PathLine> path_lines(const PropagationFrame& frame, std::size_t source, int count,
                                     int order) const;

    /// What every patch radiates of a source's sound within a time after emission; where only
    /// listeners send rays, what the first one would hear of it.
    std::vector<PatchEnergy> patch_energies(std::size_t source, double begin_s, double end_s) const;

    float patch_size_m() const { return grid_.patch_size_m(); }

    /// Other rays per emitter from the next frame on.
    void set_rays(int rays);

 private:
    /// A source and a listener.
    struct Pair {
        bool changed = false;  ///< since the last frame
        bool is_current =
            false;            ///< what its response has been made of is all of this place and scene
        int frames = 0;       ///< of the mean
        double weight = 0;    ///< of the mean, in rays
        EnergyResponse mean;  ///< of what is gathered
        EnergyResponse newest;  ///< what is gathered in the present frame
        bool segments_current =
            false;  ///< all segments of the last frame were of this place and scene
        SpecularSum specular;
    };
    /// What a pair hears from the cache of each end.
    struct Shares {
        double source = 0;
        double listener = 0;
    };
    struct GatherPlan {
        std::vector<Shares> shares;                      ///< [pair]
        std::vector<std::vector<std::size_t>> pairs_at;  ///< [receiver] that hear there
    };

    std::size_t emitter_count() const { return source_count_ + listener_count_; }
    std::size_t cache_bytes(bool directed) const;
    std::size_t max_segments(bool directed) const;
    std::size_t leg_bytes() const;
    void divide_memory();
    Pair silent_pair() const;
    PatchCache make_cache(bool directed) const;
    SegmentCache make_legs(bool directed) const;
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
    void take_in(std::size_t pair);
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
    PathTracer tracer_;
    GatherSettings gather_settings_;

    // [emitter], sources before listeners
    std::vector<std::size_t> ids_;  // of their random numbers
    std::vector<PatchCache> caches_;
    std::vector<SegmentCache> segment_caches_;
    std::vector<EmitterStatus> status_;
    std::vector<std::vector<TraceBatch>> batches_;  // [emitter][batch]
    std::vector<Vec3> positions_;                   // in the last frame
    std::vector<Receiver> receivers_;
    double travel_m_ = 0;
    std::optional<std::uint64_t> last_move_;  // the frame in which the scene did

    std::vector<Pair> pairs_;  // [source * listener_count + listener]
};

}  // namespace aula
