#include "engine/rays/convex_room.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <vector>

#include "engine/base/tolerances.h"

namespace aula {

namespace {

/// The share of all directions in which triangles are seen from the mean of their corners, each
/// triangle by itself (Van Oosterom and Strackee 1983): 1 if together they surround it once.
double seen_share(const std::vector<RayScene::Triangle>& triangles) {
    glm::dvec3 middle(0);
    for (const RayScene::Triangle& t : triangles)
        for (const Vec3& vertex : t.vertices) middle += glm::dvec3(vertex);
    middle /= static_cast<double>(3 * triangles.size());
    double sum = 0;
    for (const RayScene::Triangle& t : triangles) {
        const glm::dvec3 a = glm::dvec3(t.vertices[0]) - middle;
        const glm::dvec3 b = glm::dvec3(t.vertices[1]) - middle;
        const glm::dvec3 c = glm::dvec3(t.vertices[2]) - middle;
        const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
        const double below =
            la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
        sum += 2 * std::atan2(std::abs(glm::dot(a, glm::cross(b, c))), below);
    }
    return sum / (4 * std::numbers::pi);
}

/// A crack of a mesh may have this share of all directions.
constexpr double kCrack = 1e-4;

}  // namespace

bool is_convex_room(const RayScene& scene, std::span<const Vec3> inside) {
    if (inside.empty() || scene.triangle_count() > kMostConvexTriangles) return false;
    const auto& all = scene.triangles();
    if (std::abs(seen_share(all) - 1) > kCrack) return false;
    return std::none_of(all.begin(), all.end(), [&](const RayScene::Triangle& t) {
        const auto height_m = [&](const Vec3& p) { return glm::dot(t.normal, p - t.vertices[0]); };
        const float side = height_m(inside[0]) > 0 ? 1 : -1;
        const auto is_behind = [&](const Vec3& p) {
            return side * height_m(p) < -tolerances::kOffset_m;
        };
        return scene.moves(t) || std::any_of(inside.begin(), inside.end(), is_behind) ||
               std::any_of(all.begin(), all.end(), [&](const RayScene::Triangle& other) {
                   return std::any_of(other.vertices.begin(), other.vertices.end(), is_behind);
               });
    });
}

}  // namespace aula
