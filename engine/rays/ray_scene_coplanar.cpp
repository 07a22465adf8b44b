#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <tuple>

#include "engine/base/tolerances.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/scene_planes.h"

namespace aula {

/// Finds the static faces that overlap in one plane, and moves their vertices into it, with all
/// vertices at the same places: what is heard on a face is then at the same distance. Layers stay.
void RayScene::find_coplanar_faces(const std::vector<bool>& is_omitted) {
    const ScenePlanes planes(*this);
    coplanar_faces_ = CoplanarFaces(*this, planes, is_omitted);
    struct Less {
        bool operator()(const Vec3& a, const Vec3& b) const {
            return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
        }
    };
    std::map<Vec3, ScenePlanes::Point, Less> moved;
    const auto flatten = [&](std::uint32_t triangle) {
        const ScenePlanes::Plane& plane = planes[planes.of_triangle(triangle)];
        for (const Vec3& v : triangles_[triangle].vertices) {
            if (std::abs(plane.distance_m(ScenePlanes::Point(v))) <= double{tolerances::kFlat_m})
                continue;
            ScenePlanes::Point& to = moved.try_emplace(v, v).first->second;
            to -= plane.distance_m(to) * plane.normal;
        }
    };
    for (const CoplanarFaces::Overlap& overlap : coplanar_faces_.overlaps()) {
        if (overlap.is_layer) continue;
        flatten(overlap.covered);
        flatten(overlap.heard);
    }
    if (moved.empty()) return;
    for (std::uint32_t o = 0; o < objects_.size(); ++o) {
        if (objects_[o].moves()) continue;
        for (Vec3& v : world_vertices_[o])
            if (const auto to = moved.find(v); to != moved.end()) v = Vec3(to->second);
        update_triangles(o);
    }
}

void RayScene::hear_smaller(std::size_t count, HitLanes& hits) const {
    if (coplanar_faces_.overlaps().empty()) return;
    for (std::size_t i = 0; i < count; ++i) {
        if (!coplanar_faces_.is_covered(hits.triangle[i])) continue;
        const Hit hit = heard({hits.triangle[i], hits.distance_m[i], hits.u[i], hits.v[i]});
        hits.triangle[i] = hit.triangle;
        hits.u[i] = hit.u;
        hits.v[i] = hit.v;
    }
}

/// The same hit on the face that is heard there.
Hit RayScene::heard(const Hit& hit) const {
    const auto& v = triangles_[hit.triangle].vertices;
    const Vec3 point = v[0] + hit.u * (v[1] - v[0]) + hit.v * (v[2] - v[0]);
    for (const std::uint32_t t : coplanar_faces_.candidates(hit.triangle, point)) {
        const Triangle& other = triangles_[t];
        const glm::dvec3 a(other.vertices[0]);
        const glm::dvec3 d = glm::dvec3(point) - a;
        const glm::dvec3 normal(other.normal);
        // A point behind a face would be in another room.
        if (std::abs(glm::dot(d, normal)) > 2 * double{tolerances::kFlat_m}) continue;
        const glm::dvec3 ab = glm::dvec3(other.vertices[1]) - a;
        const glm::dvec3 ac = glm::dvec3(other.vertices[2]) - a;
        const double twice_area_m2 = glm::dot(glm::cross(ab, ac), normal);
        const double u = glm::dot(glm::cross(d, ac), normal) / twice_area_m2;
        const double w = glm::dot(glm::cross(ab, d), normal) / twice_area_m2;
        constexpr double kOutside = -1e-6;  // rounding: points of the edge between two triangles
        if (u < kOutside || w < kOutside || u + w > 1 - kOutside) continue;
        // A third face of the first one's material may be heard on the second.
        return heard({t, hit.distance_m, static_cast<float>(u), static_cast<float>(w)});
    }
    return hit;
}

std::uint32_t RayScene::heard_at(std::uint32_t triangle, const Vec3& point) const {
    if (!coplanar_faces_.is_covered(triangle)) return triangle;
    const auto& v = triangles_[triangle].vertices;
    const Vec3 ab = v[1] - v[0];
    const Vec3 ac = v[2] - v[0];
    const Vec3 normal = glm::cross(ab, ac);
    const float square = glm::dot(normal, normal);
    return heard({triangle, 0, glm::dot(glm::cross(point - v[0], ac), normal) / square,
                  glm::dot(glm::cross(ab, point - v[0]), normal) / square})
        .triangle;
}

}  // namespace aula
