#pragma once

#include <algorithm>
#include <span>

#include "engine/rays/receiver.h"
#include "engine/trace/trace_batch.h"

namespace aula {

/// Detection spheres of purely specular paths. In a sphere of half a metre late detections are
/// rare, and those of a ray with little loss are loud. The spheres of all segments that no image
/// source may count therefore grow to four times the cross-section, and further in proportion to
/// the segment's energy, which makes loud hits at one time about equally loud. The cross-section is
/// limited to the ray's share of its wave front, where neighbouring rays begin to cross the sphere
/// as well.

/// Sets PathSegment::growth of a frame's segments: a quarter of the ratio of their energies to the
/// mean energy of all segments at about the same path length, at least 4; 0 for those that an image
/// source may count.
template <typename Batch>  // ArrivalBatch or DepositBatch
void size_spheres(std::span<Batch> batches);

/// The largest useful growth is this value times the square of the path length in m, for `rays`
/// emitted rays: at R^2 growth = 4 L^2 / N one ray of each wave front is expected to cross the
/// sphere.
inline float wave_front_growth_1_m2(double rays, float radius_m) {
    return static_cast<float>(4 / (rays * double{radius_m} * double{radius_m}));
}

/// Ratio of the cross-sections of a segment's sphere and sphere 0.
inline float sphere_growth(float segment_growth, float before_m, float wave_front_1_m2) {
    return std::max(1.0F, std::min(segment_growth, wave_front_1_m2 * before_m * before_m));
}

/// Adds the arrivals that receivers detect on a batch's segments. `rays` is the number of rays of
/// the frame.
void collect_segment_arrivals(const RayScene& scene, std::span<const Receiver> receivers,
                              const Bands& attenuation_per_m, int rays, ArrivalBatch& batch);

}  // namespace aula
