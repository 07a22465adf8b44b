#pragma once

#include "aula/engine/energy_response.h"
#include "engine/cache/segment_cache.h"
#include "engine/estimate/response_follower.h"
#include "engine/trace/specular_sum.h"

namespace aula {

/// The response of one source at one listener: the gathered responses and the detections on the
/// segments of both ends' rays. Of each, at rest the mean since source, listener or scene last
/// changed, in motion that of a ResponseFollower. [propagation thread]
class PairResponse {
 public:
    /// `window_frames` >= 1: see ResponseFollower.
    PairResponse(const EnergyResponse& silent, int window_frames)
        : mean_(silent),
          gathered_(silent),
          follower_(silent, window_frames),
          detected_(silent),
          detected_mean_(silent),
          detected_follower_(silent, window_frames) {}

    /// Begins a frame. `moved_m`: how far source, listener and scene have moved since the last one,
    /// together.
    void begin_frame(double moved_m);

    /// True if the mean holds at least `frames` frames, all since the last change.
    bool holds(int frames) const { return moved_m_ == 0 && frames_ >= frames; }

    /// Clears gathered().
    void begin_gather() { gathered_.clear_bins(); }

    /// The response to which this frame's gather is added.
    EnergyResponse& gathered() { return gathered_; }

    /// Takes gathered(). At rest it is added to the mean of all frames since the last change,
    /// weighted by the `rays` in the caches, because early frames are noisier. Each frame alone is
    /// unbiased, hence so is the mean.
    void end_gather(std::uint64_t rays);

    /// Number of frames in the mean.
    int frames() const { return frames_; }

    /// Detects the segments of each end's rays at the other end's receiver: those of the present
    /// frame, or all if the earlier detections are no longer valid. `directivity` is the source's.
    void detect(const RayScene& scene, const SegmentCache& of_source, const Receiver& at_listener,
                const SegmentCache& of_listener, const Receiver& at_source,
                const OrientedDirectivity& directivity);

    /// The gathered response, with less noise than a single frame.
    const EnergyResponse& response() const { return follower_.response(); }

    /// Adds the detections to a response, but for those that `images` counts.
    void add_detected_to(const SpecularSound& images, EnergyResponse& response) const;

 private:
    double moved_m_ = 0;       ///< since the last frame
    int frames_ = 0;           ///< in the mean
    double weight_ = 0;        ///< of the mean, in rays
    EnergyResponse mean_;      ///< of the gathered responses
    EnergyResponse gathered_;  ///< in the present frame
    ResponseFollower follower_;
    bool segments_current_ = false;  ///< all segments of the last frame were valid for these
                                     ///< positions and this scene
    SpecularSum detected_;
    int detected_frames_ = 0;             ///< of detected_
    EnergyResponse detected_mean_;        ///< of the paths that no image source may count
    ResponseFollower detected_follower_;  ///< of detected_mean_
};

}  // namespace aula
