#pragma once

#include "aula/engine/energy_response.h"
#include "engine/estimate/segment_cache.h"
#include "engine/trace/specular_sum.h"

namespace aula {

/// The response of one source at one listener since source, listener or scene last changed: the
/// mean of the gathered responses, and the detections on the segments of both ends' rays.
/// [propagation thread]
class PairResponse {
 public:
    explicit PairResponse(const EnergyResponse& silent)
        : mean_(silent), gathered_(silent), detected_(silent) {}

    /// Begins a frame. `changed`: source, listener or scene has moved since the last one.
    void begin_frame(bool changed) { changed_ = changed; }

    /// True if the mean holds at least `frames` frames, all since the last change.
    bool holds(int frames) const { return !changed_ && is_current_ && frames_ >= frames; }

    /// Clears gathered().
    void begin_gather() { gathered_.clear_bins(); }

    /// The response to which this frame's gather is added.
    EnergyResponse& gathered() { return gathered_; }

    /// Adds gathered() to the mean of all frames since the last change, weighted by the `rays` in
    /// the caches, because early frames are noisier. Each frame alone is unbiased, hence so is the
    /// mean. `is_current`: the caches hold nothing from before the last change.
    void end_gather(std::uint64_t rays, bool is_current);

    /// Detects the segments of each end's rays at the other end's receiver: those of the present
    /// frame, or all if the earlier detections are no longer valid. `directivity` is the source's.
    void detect(const RayScene& scene, const SegmentCache& of_source, const Receiver& at_listener,
                const SegmentCache& of_listener, const Receiver& at_source,
                const OrientedDirectivity& directivity);

    /// The mean of the gathered responses.
    const EnergyResponse& mean() const { return mean_; }

    /// The sum of the detections.
    const SpecularSum& detected() const { return detected_; }

 private:
    bool changed_ = false;
    bool is_current_ = false;        ///< the mean holds nothing from before the last change
    int frames_ = 0;                 ///< in the mean
    double weight_ = 0;              ///< of the mean, in rays
    EnergyResponse mean_;            ///< of the gathered responses
    EnergyResponse gathered_;        ///< in the present frame
    bool segments_current_ = false;  ///< all segments of the last frame were valid for these
                                     ///< positions and this scene
    SpecularSum detected_;
};

}  // namespace aula
