#include "engine/rays/brute_force_intersector.h"

#include <algorithm>
#include <cassert>
#include <glm/geometric.hpp>
#include <limits>

#include "aula/engine/scene.h"
#include "process/multiversion.h"

namespace aula {

namespace {

bool before(const Vec3& a, const Vec3& b) {
    if (a.x != b.x) return a.x < b.x;
    return a.y != b.y ? a.y < b.y : a.z < b.z;
}

/// Gives opposite signs for the two directions of an edge, so that neighbouring triangles agree.
BruteForceIntersector::Lines::Edge edge_between(const Vec3& from, const Vec3& to) {
    if (before(to, from)) {
        const auto [direction, moment] = edge_between(to, from);
        return {-direction, -moment};
    }
    return {to - from, glm::cross(from, to)};
}

/// The rays' state during the loop over triangles.
struct Search {
    LanePoints origin;                               // relative to the triangles' centre
    LanePoints moment;                               // origin x direction
    alignas(64) std::array<float, kLanes> weight_1;  // of the nearest hit so far, see test()
    alignas(64) std::array<float, kLanes> weight_2;
    alignas(64) std::array<float, kLanes> sum;
};

/// The sign of d . (p x q) + (q - p) . (o x d) is the side on which a ray's line passes an edge,
/// with the edge from p to q and the ray o + t d (Pluecker coordinates). A ray that passes all
/// edges of a triangle on the same side crosses the triangle, and the three values are the weights
/// of the opposite vertices.
inline void test(const BruteForceIntersector::Lines& t, std::int32_t index, const LanePoints& d,
                 std::size_t lanes, Search& search, HitLanes& hits) {
    const auto& [e0, e1, e2] = t.edges;
    const LanePoints& o = search.origin;
    const LanePoints& m = search.moment;
    for (std::size_t i = 0; i < lanes; ++i) {
        const float w0 =
            (d.x[i] * e0.moment.x + d.y[i] * e0.moment.y + d.z[i] * e0.moment.z) +
            (m.x[i] * e0.direction.x + m.y[i] * e0.direction.y + m.z[i] * e0.direction.z);
        const float w1 =
            (d.x[i] * e1.moment.x + d.y[i] * e1.moment.y + d.z[i] * e1.moment.z) +
            (m.x[i] * e1.direction.x + m.y[i] * e1.direction.y + m.z[i] * e1.direction.z);
        const float w2 =
            (d.x[i] * e2.moment.x + d.y[i] * e2.moment.y + d.z[i] * e2.moment.z) +
            (m.x[i] * e2.direction.x + m.y[i] * e2.direction.y + m.z[i] * e2.direction.z);
        const float min = std::min(std::min(w0, w1), w2);
        const float max = std::max(std::max(w0, w1), w2);
        const float height =
            t.offset - (o.x[i] * t.normal.x + o.y[i] * t.normal.y + o.z[i] * t.normal.z);
        const float distance =
            height / (d.x[i] * t.normal.x + d.y[i] * t.normal.y + d.z[i] * t.normal.z);
        const bool hit =
            ((min >= 0) | (max <= 0)) & (distance > 0) & (distance <= hits.distance_m[i]);
        hits.distance_m[i] = hit ? distance : hits.distance_m[i];
        hits.triangle[i] = hit ? static_cast<std::uint32_t>(index) : hits.triangle[i];
        search.weight_1[i] = hit ? w1 : search.weight_1[i];
        search.weight_2[i] = hit ? w2 : search.weight_2[i];
        search.sum[i] = hit ? w0 + w1 + w2 : search.sum[i];
    }
}

AULA_MULTIVERSION
void nearest_hits(std::span<const BruteForceIntersector::Lines> triangles, const Vec3& middle,
                  const RayLanes& rays, std::size_t count, HitLanes& hits) {
    const std::size_t lanes = padded_lanes(count);
    Search search;
    for (std::size_t i = 0; i < lanes; ++i) {
        const LanePoints& d = rays.direction;
        const float x = rays.origin.x[i] - middle.x;
        const float y = rays.origin.y[i] - middle.y;
        const float z = rays.origin.z[i] - middle.z;
        search.origin.x[i] = x;
        search.origin.y[i] = y;
        search.origin.z[i] = z;
        search.moment.x[i] = y * d.z[i] - z * d.y[i];
        search.moment.y[i] = z * d.x[i] - x * d.z[i];
        search.moment.z[i] = x * d.y[i] - y * d.x[i];
        search.weight_1[i] = 0;
        search.weight_2[i] = 0;
        search.sum[i] = 1;
        hits.distance_m[i] = rays.max_m[i];
        hits.triangle[i] = kNoTriangle;
    }
    std::int32_t index = 0;
    for (const BruteForceIntersector::Lines& t : triangles) {
        test(t, index++, rays.direction, lanes, search, hits);
    }
    for (std::size_t i = 0; i < lanes; ++i) {
        // All weights round to 0 where a ray lies in the plane and meets a vertex.
        const float sum = search.sum[i] != 0 ? search.sum[i] : 1;
        hits.u[i] = search.weight_1[i] / sum;
        hits.v[i] = search.weight_2[i] / sum;
        hits.distance_m[i] = hits.triangle[i] == kNoTriangle
                                 ? std::numeric_limits<float>::infinity()
                                 : hits.distance_m[i];
    }
}

}  // namespace

BruteForceIntersector::BruteForceIntersector(std::span<const Vertices> triangles) {
    assert(triangles.size() <= kMax);
    if (triangles.empty()) return;
    Bounds bounds;
    for (const Vertices& vertices : triangles) bounds.add(vertices);
    middle_ = 0.5F * (bounds.min + bounds.max);
    for (const Vertices& vertices : triangles) {
        const Vec3 a = vertices[0] - middle_;
        const Vec3 b = vertices[1] - middle_;
        const Vec3 c = vertices[2] - middle_;
        Lines lines;
        lines.normal = glm::cross(b - a, c - a);
        lines.offset = glm::dot(lines.normal, a);
        // Without a normal the distance is NaN, so that the triangle is never hit.
        if (lines.normal == Vec3(0)) lines.offset = std::numeric_limits<float>::quiet_NaN();
        lines.edges = {edge_between(b, c), edge_between(c, a), edge_between(a, b)};
        triangles_.push_back(lines);
    }
}

void BruteForceIntersector::intersect(const RayLanes& rays, std::size_t count,
                                      HitLanes& hits) const {
    best_version<nearest_hits>(triangles_, middle_, rays, count, hits);
}

}  // namespace aula
