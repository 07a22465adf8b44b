#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "aula/engine/energy_response.h"
#include "engine/cache/patch_cache.h"
#include "engine/rays/oriented_directivity.h"
#include "engine/rays/receiver.h"
#include "engine/trace/specular_sum.h"
#include "engine/trace/trace_batch.h"

namespace aula {

/// Segments as a structure of arrays for vector units; unused lanes have zero length.
struct SegmentLanes {
    /// The lanes of single precision of the widest vector unit, 512 bits.
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

/// Cached last segments of paths that no gather finds, over many frames; independent of the
/// receiver. A receiver detects those that cross its sphere, so they remain valid while receivers
/// move. While emitter and scene are static, frames are evicted only when newer ones need their
/// memory. After a movement, frames are removed from which emitter and scene have moved by more
/// than `reach_m` in total, or which are older than the window. [propagation thread]
class SegmentCache {
 public:
    /// The state on which the rays of a frame depend.
    struct State {
        std::uint64_t frame = 0;
        Vec3 emitter{0};
        double travel_m = 0;  ///< accumulated movement of the scene since the start

        bool changed_since(const State& older) const {
            return emitter != older.emitter || travel_m != older.travel_m;
        }
        double moved_m(const State& older) const;
    };

    /// `window_frames` >= 1 frames are kept even if they exceed `max_segments`, but never more than
    /// fit in `memory_bytes`.
    SegmentCache(int window_frames, float reach_m, const Bands& attenuation_per_m,
                 std::size_t max_segments, std::size_t memory_bytes)
        : window_frames_(static_cast<std::size_t>(window_frames)),
          reach_m_(reach_m),
          attenuation_per_m_(attenuation_per_m),
          max_segments_(max_segments),
          memory_bytes_(memory_bytes) {}

    /// Sets the limits from the next frame on.
    void set_bounds(std::size_t max_segments, std::size_t memory_bytes) {
        max_segments_ = max_segments;
        memory_bytes_ = memory_bytes;
    }

    /// Removes frames that are no longer valid. Call once for each frame, in order.
    void advance(const State& now);

    /// Adds the segments of the present frame's rays, after advance(); a random part of them, which
    /// represents fewer rays, if all exceed the memory. [any thread]
    void add(std::span<const DepositBatch> batches, int rays);

    /// True if no stored frame precedes the last change.
    bool is_current() const;

    /// True if more rays would hardly reduce the error, or need the memory of frames that are
    /// still valid.
    bool full() const { return evicted_ || rays_ >= PatchCache::kEnoughRays; }

    /// Number of rays of the stored frames.
    std::uint64_t rays() const { return rays_; }

    /// Adds a receiver's detections on the segments of all frames, or only of the present frame.
    /// `directivity`: of a source that receives; omnidirectional for a listener. `rays` determines
    /// the maximum size of the detection spheres.
    void add_to(const RayScene& scene, const Receiver& receiver,
                const OrientedDirectivity& directivity, bool only_present, std::uint64_t rays,
                SpecularSum& sum) const;

    std::size_t memory_bytes() const { return bytes_; }

 private:
    struct Frame {
        State state;
        std::uint64_t rays = 0;
        std::vector<SegmentLanes> segments;
        std::vector<SegmentEnergy> sounds;  ///< [segment]

        std::size_t memory_bytes() const { return memory_bytes(sounds.size()); }
        static std::size_t memory_bytes(std::size_t count) {
            return (count + SegmentLanes::kCount - 1) / SegmentLanes::kCount *
                       sizeof(SegmentLanes) +
                   count * sizeof(SegmentEnergy);
        }
    };
    static std::size_t fit(std::size_t memory_bytes);
    bool holds(const Frame& frame) const;
    void forget_oldest();

    std::size_t window_frames_;
    float reach_m_;
    Bands attenuation_per_m_;
    std::size_t max_segments_;
    std::size_t memory_bytes_;
    State now_;
    std::deque<Frame> frames_;
    Frame spare_;  ///< the last frame removed; the next one takes its memory if it needs half of it
    std::size_t segment_count_ = 0;
    std::size_t bytes_ = 0;
    std::uint64_t rays_ = 0;
    bool evicted_ = false;  ///< frames that were still valid have been evicted for newer ones
};

}  // namespace aula
