#include "engine/rays/nudge_off_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/sampling.h"
#include "engine/base/tolerances.h"

namespace aula {

namespace {

/// Points closer than this to a surface are on it. Image sources have no reflection in a plane that
/// is as near.
constexpr auto kOnSurface_m = static_cast<float>(tolerances::kOnSurface_m);

/// The distance by which a point is moved, and the length of the rays that search for a surface.
constexpr float kStep_m = 2 * kOnSurface_m;

/// The triangle index of the nearest surface within kOnSurface_m, or kNoTriangle.
std::uint32_t surface_at(const RayScene& scene, const Vec3& position) {
    // A surface through the point stops a ray along the axis nearest to its normal. One of two
    // opposite rays is sufficient, but near an edge rounding may lose either.
    std::array<Ray, 6> probes;
    for (std::size_t i = 0; i < probes.size(); ++i) {
        Vec3 direction(0);
        direction[static_cast<int>(i / 2)] = i % 2 == 0 ? 1.0F : -1.0F;
        probes[i] = {position - kStep_m * direction, direction, 2 * kStep_m};
    }
    std::array<Hit, 6> hits;
    scene.intersect(probes, hits);
    std::uint32_t nearest = kNoTriangle;
    float nearest_m = kOnSurface_m;
    for (const Hit& hit : hits) {
        if (!hit.any()) continue;
        const RayScene::Triangle& triangle = scene.triangle(hit.triangle);
        const float distance_m =
            std::abs(glm::dot(position - triangle.vertices[0], triangle.normal));
        if (distance_m >= nearest_m || triangle.normal == Vec3(0)) continue;
        nearest = hit.triangle;
        nearest_m = distance_m;
    }
    return nearest;
}

/// The number of directions, of 64, in which a surface is visible from a point.
std::ptrdiff_t enclosing_hits(const RayScene& scene, const Vec3& position) {
    const ScrambledSobol sobol(1);
    std::array<Ray, 64> probes;
    for (std::uint32_t i = 0; i < probes.size(); ++i) {
        probes[i] = {position, uniform_direction(sobol.point(i))};
    }
    std::array<Hit, 64> hits;
    scene.intersect(probes, hits);
    return std::count_if(hits.begin(), hits.end(), [](const Hit& hit) { return hit.any(); });
}

}  // namespace

Vec3 nudge_off_surface(const RayScene& scene, const Vec3& position) {
    // In a corner the point is moved one step from each face.
    constexpr int kMaxFaces = 6;
    Vec3 at = position;
    for (int face = 0; face < kMaxFaces; ++face) {
        const std::uint32_t surface = surface_at(scene, at);
        if (surface == kNoTriangle) break;
        const RayScene::Triangle& triangle = scene.triangle(surface);
        const Vec3 foot =
            at - glm::dot(at - triangle.vertices[0], triangle.normal) * triangle.normal;
        const Vec3 front = foot + kStep_m * triangle.normal;
        const Vec3 back = foot - kStep_m * triangle.normal;
        at = enclosing_hits(scene, back) > enclosing_hits(scene, front) ? back : front;
    }
    return at;
}

std::vector<Vec3> nudge_off_surfaces(const RayScene& scene, std::vector<Vec3> positions) {
    for (Vec3& position : positions) position = nudge_off_surface(scene, position);
    return positions;
}

}  // namespace aula
