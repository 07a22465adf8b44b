#include "engine/mesh/polygon.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "engine/base/tolerances.h"

namespace aula {
namespace {

using Point = glm::dvec2;

// Twice the signed area; positive if a, b, c are in counter-clockwise order.
double turn(const Point& a, const Point& b, const Point& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool contains(const std::array<Point, 3>& triangle, const Point& p) {
    const auto& [a, b, c] = triangle;
    if (p == a || p == b || p == c) return false;
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

// Newell's normal: its length is twice the polygon's area.
glm::dvec3 area_normal(const std::vector<Vec3>& corners) {
    glm::dvec3 normal(0);
    const glm::dvec3 origin(corners[0]);
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        normal += glm::cross(glm::dvec3(corners[i]) - origin, glm::dvec3(corners[i + 1]) - origin);
    }
    return normal;
}

// The corners projected along the axis nearest to the normal, in counter-clockwise order.
std::vector<Point> project(const std::vector<Vec3>& corners, const glm::dvec3& normal) {
    const glm::dvec3 size = glm::abs(normal);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    std::vector<Point> points;
    for (const Vec3& corner : corners) {
        const glm::dvec3 d = glm::dvec3(corner) - glm::dvec3(corners[0]);
        points.push_back(normal[axis] > 0 ? Point(d[u], d[v]) : Point(d[v], d[u]));
    }
    return points;
}

double largest_square_distance(const std::vector<Point>& points) {
    double largest = 0;
    for (const Point& p : points) largest = std::max(largest, glm::dot(p, p));
    return largest;
}

}  // namespace

// Ear clipping: a convex corner whose triangle with its neighbours contains no other corner is cut
// off, until one triangle is left. A cut affects its neighbours only, so the search continues
// there.
std::vector<std::array<std::uint32_t, 3>> triangulate(const std::vector<Vec3>& corners) {
    if (corners.size() < 3) return {};
    const glm::dvec3 normal = area_normal(corners);
    const std::vector<Point> points = project(corners, normal);
    // Angles below the rounding of the coordinates count as straight.
    const double straight = tolerances::kNoHeight * largest_square_distance(points);
    if (glm::length(normal) <= straight) return {};

    const auto count = static_cast<std::uint32_t>(corners.size());
    std::vector<std::uint32_t> next(count);  // ring of the remaining corners
    std::vector<std::uint32_t> previous(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        next[i] = (i + 1) % count;
        previous[i] = (i + count - 1) % count;
    }
    std::vector<std::array<std::uint32_t, 3>> triangles;
    const auto is_blocked = [&](const std::array<Point, 3>& ear, std::uint32_t tip) {
        for (std::uint32_t k = next[tip]; k != tip; k = next[k]) {
            if (contains(ear, points[k])) return true;
        }
        return false;
    };
    // Fewer than 3 failures per corner occur for a simple polygon.
    std::size_t failures_left = 8 * corners.size() + 4096;
    std::uint32_t left = count;
    std::uint32_t first = 0;
    std::uint32_t failures = 0;  // since the last cut
    for (std::uint32_t b = 0; left >= 3;) {
        const std::uint32_t a = previous[b];
        const std::uint32_t c = next[b];
        const std::array<Point, 3> ear{points[a], points[b], points[c]};
        const double size = turn(ear[0], ear[1], ear[2]);
        if (size < -straight || (size > straight && is_blocked(ear, b))) {
            if (++failures == left || --failures_left == 0) return {};
            b = c;
            continue;
        }
        if (size > straight) triangles.push_back({a, b, c});
        next[a] = c;
        previous[c] = a;
        --left;
        failures = 0;
        if (b == first) first = c;
        b = c == first ? c : a;
    }
    return triangles;
}

}  // namespace aula
