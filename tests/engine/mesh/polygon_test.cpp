#include "engine/mesh/polygon.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>

using aula::Vec3;

namespace {

// Sum of the signed areas of the triangles, positive if counter-clockwise about `normal`.
double area_along(const std::vector<Vec3>& corners, const Vec3& normal) {
    double area = 0;
    for (const auto& [a, b, c] : aula::triangulate(corners)) {
        const Vec3 cross = glm::cross(corners[b] - corners[a], corners[c] - corners[a]);
        CHECK(glm::dot(cross, normal) > 0);
        area += double{glm::length(cross)} / 2;
    }
    return area;
}

}  // namespace

TEST_CASE("a square gives two triangles of its winding") {
    const std::vector<Vec3> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    CHECK(aula::triangulate(square).size() == 2);
    CHECK(area_along(square, {0, 0, 1}) == Approx(1));
    CHECK(area_along({square.rbegin(), square.rend()}, {0, 0, -1}) == Approx(1));
}

TEST_CASE("a concave polygon is covered once for every first corner") {
    // An L of 3 squares, vertical in the plane y = x.
    std::vector<Vec3> l{{0, 0, 0}, {2, 2, 0}, {2, 2, 1}, {1, 1, 1}, {1, 1, 2}, {0, 0, 2}};
    for (std::size_t turn = 0; turn < l.size(); ++turn) {
        std::rotate(l.begin(), l.begin() + 1, l.end());
        CHECK(area_along(l, {1, -1, 0}) == Approx(3 * std::sqrt(2.0)));
    }
}

TEST_CASE("corners on a straight edge change nothing") {
    const std::vector<Vec3> square{{0, 0, 0}, {0.5F, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    CHECK(area_along(square, {0, 0, 1}) == Approx(1));
}

TEST_CASE("a wall with a doorway connected by a slit is covered without the doorway") {
    const std::vector<Vec3> wall{{0, 0, 0}, {4, 0, 0}, {4, 0, 3}, {0, 0, 3}, {0, 0, 0},
                                 {1, 0, 1}, {1, 0, 2}, {3, 0, 2}, {3, 0, 1}, {1, 0, 1}};
    CHECK(area_along(wall, {0, -1, 0}) == Approx(12 - 2));
}

TEST_CASE("a polygon without area gives no triangles") {
    CHECK(aula::triangulate({{0, 0, 0}, {1, 0, 0}}).empty());
    CHECK(aula::triangulate({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}).empty());
    CHECK(aula::triangulate({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}).empty());
    CHECK(aula::triangulate({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).empty());
}
