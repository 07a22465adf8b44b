#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "engine/estimate/patch_cache.h"
#include "engine/response/energy_response.h"
#include "engine/trace/path_tracer.h"
#include "engine/trace/specular_sum.h"

namespace aula {

/// Segments side by side, as vector units take them; the last may have no length.
struct SegmentLanes {
    static constexpr std::size_t kCount = 16;
    using Lanes = std::array<float, kCount>;

    std::array<Lanes, 3> origin{};     ///< [axis]
    std::array<Lanes, 3> direction{};  ///< [axis]
    Lanes length_m{};
    Lanes before_m{};
    Lanes growth{};

    void set(std::size_t lane, const PathSegment& segment);
    PathSegment at(std::size_t lane) const;
};

/// The segments of an emitter's paths that no gather finds, over many frames: a receiver hears
/// those that cross its sphere, wherever it is. No receiver is in them, so that they stay right
/// while receivers move: while emitter and scene stand a frame holds until newer ones need its
/// room. Once either has moved, those frames are left out from which they have moved by more than
/// `reach_m` together, or that are older than the window. [propagation thread]
class SegmentCache {
 public:
    using State = PatchCache::State;

    /// `window_frames` >= 1 are held though their segments be more than `max_segments`, but never
    /// more than fit in `memory_bytes`.
    SegmentCache(int window_frames, float reach_m, const Bands& attenuation_per_m,
                 std::size_t max_segments, std::size_t memory_bytes)
        : window_frames_(static_cast<std::size_t>(window_frames)),
          reach_m_(reach_m),
          attenuation_per_m_(attenuation_per_m),
          max_segments_(max_segments),
          memory_bytes_(memory_bytes) {}

    /// Other bounds, from the next frame on.
    void set_bounds(std::size_t max_segments, std::size_t memory_bytes) {
        max_segments_ = max_segments;
        memory_bytes_ = memory_bytes;
    }

    /// Forgets what no longer holds. Call once for each frame, in order.
    void advance(const State& now);

    /// Takes the segments of the present frame's rays, after advance().
    void add(std::span<const TraceBatch> batches, int rays);

    /// True if every frame held is as the present one: none is from before a change.
    bool is_current() const;

    /// True if more rays would hardly make what is held more certain.
    bool full() const { return evicted_ || rays_ >= PatchCache::kEnoughRays; }

    /// Rays of the frames held.
    std::uint64_t rays() const { return rays_; }

    /// Adds what a receiver detects of the frames' segments, or only of the present frame's. `rays`
    /// is the number that decides how far detection spheres grow.
    void add_to(const RayScene& scene, const Receiver& receiver, bool only_present,
                std::uint64_t rays, SpecularSum& sum) const;

    std::size_t memory_bytes() const { return bytes_; }

 private:
    struct Frame {
        State state;
        std::uint64_t rays = 0;
        std::vector<SegmentLanes> segments;
        std::vector<SegmentEnergy> sounds;  ///< [segment]

        std::size_t memory_bytes() const {
            return segments.size() * sizeof(SegmentLanes) + sounds.size() * sizeof(SegmentEnergy);
        }
    };
    bool holds(const Frame& frame) const;
    void forget_oldest();

    std::size_t window_frames_;
    float reach_m_;
    Bands attenuation_per_m_;
    std::size_t max_segments_;
    std::size_t memory_bytes_;
    State now_;
    std::deque<Frame> frames_;
    std::size_t segment_caches_ = 0;
    std::size_t bytes_ = 0;
    std::uint64_t rays_ = 0;
    bool evicted_ = false;  ///< frames that still held have made room for newer ones
};

}  // namespace aula
