#pragma once

#include <algorithm>
#include <span>

#include "engine/trace/path_tracer.h"

namespace aula {

/// Detection spheres of purely specular paths. A ray that has lost little stands alone for much of
/// the late response: on a sphere of half a metre such rays are rare and loud. Each segment
/// therefore has a sphere with a cross-section in proportion to its energy, which makes all hits at
/// one time about equally loud, but not larger than the ray's share of its wave front: then its
/// neighbours cross the sphere as well.

/// Sets PathSegment::growth of a frame's segments from their energies beside those of all segments
/// at about the same path length.
void size_spheres(std::span<TraceBatch> batches);

/// The largest useful growth is this times the square of the path's length in m, where `rays` are
/// emitted: at R^2 growth = 4 L^2 / N one ray of each wave front is expected to cross the sphere.
inline float wave_front_growth_1_m2(double rays, float radius_m) {
    return static_cast<float>(4 / (rays * double{radius_m} * double{radius_m}));
}

/// The cross-section of a segment's sphere over that of sphere 0.
inline float sphere_growth(float segment_growth, float before_m, float wave_front_1_m2) {
    return std::max(1.0F, std::min(segment_growth, wave_front_1_m2 * before_m * before_m));
}

/// Adds to a batch's arrivals what receivers detect of its segments, `rays` being those of the
/// frame. Needs the segments' path identifiers.
void collect_segment_arrivals(const RayScene& scene, std::span<const Receiver> receivers,
                              const Bands& attenuation_per_m, int rays, TraceBatch& batch);

}  // namespace aula
