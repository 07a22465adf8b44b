#include "engine/polygon.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace aula {
namespace {

using Point = glm::dvec2;

// Twice the signed area, positive if a, b, c turn counter-clockwise.
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

// The corners seen along the axis nearest to the normal, counter-clockwise.
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

// Ear clipping: a corner whose triangle with its neighbours turns the right way and holds no other
// corner is cut off, until a triangle is left.
std::vector<std::array<std::uint32_t, 3>> triangulate(const std::vector<Vec3>& corners) {
    if (corners.size() < 3) return {};
    const glm::dvec3 normal = area_normal(corners);
    const std::vector<Point> points = project(corners, normal);
    // Turns smaller than the rounding of the float coordinates count as straight.
    const double straight = 1e-7 * largest_square_distance(points);
    if (glm::length(normal) <= straight) return {};

    std::vector<std::uint32_t> left(corners.size());
    for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;
    std::vector<std::array<std::uint32_t, 3>> triangles;

    const auto cut_one = [&] {
        for (std::size_t i = 0; i < left.size(); ++i) {
            const std::uint32_t a = left[(i + left.size() - 1) % left.size()];
            const std::uint32_t b = left[i];
            const std::uint32_t c = left[(i + 1) % left.size()];
            const std::array<Point, 3> ear{points[a], points[b], points[c]};
            const double size = turn(ear[0], ear[1], ear[2]);
            if (size < -straight) continue;
            if (size > straight) {
                const bool blocked = std::any_of(left.begin(), left.end(), [&](std::uint32_t k) {
                    return contains(ear, points[k]);
                });
                if (blocked) continue;
                triangles.push_back({a, b, c});
            }
            left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
            return true;
        }
        return false;
    };
    while (left.size() >= 3) {
        if (!cut_one()) return {};
    }
    return triangles;
}

}  // namespace aula
