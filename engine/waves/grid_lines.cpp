#include "engine/waves/grid_lines.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "engine/base/tolerances.h"
#include "engine/patches/flat_walls.h"

namespace aula {

namespace {

/// Triangles tried as main walls, the largest first. A choice: each is compared with all triangles,
/// which takes 0.1 s for a million.
constexpr std::size_t kTriedNormals = 64;

/// Walls of different directions whose areas differ by a smaller share are equally large: which of
/// them comes first must not depend on rounding.
constexpr double kSameArea = 1e-4;
static_assert(kSameArea > 100 * double{tolerances::kRounding});

/// Least area of a wall in a plane of the grid, in faces of cells. A choice: each smaller one, as
/// of furniture, would cut all cells beside it through the room.
constexpr float kLeastFaces = 2;

/// Least distance of two walls in planes of the grid, in cells. Thinner cells raise the highest
/// eigenvalue of the grid, against which modes are filtered.
constexpr float kLeastCells = 0.7F;

struct FlatTriangle {
    Vec3 normal;
    float area_m2 = 0;
};

/// The area of the triangles with a normal along a direction.
double area_along(const std::vector<FlatTriangle>& triangles, const Vec3& direction) {
    double sum = 0;
    for (const FlatTriangle& t : triangles) {
        if (std::abs(glm::dot(t.normal, direction)) >= tolerances::kAlongCosine)
            sum += double{t.area_m2};
    }
    return sum;
}

/// Normals with the largest area, the second perpendicular to the first; the third axis is
/// perpendicular to both. Without a second one any perpendicular axis.
glm::mat3 main_axes(const RayScene& scene) {
    std::vector<FlatTriangle> triangles;
    for (const RayScene::Triangle& t : scene.triangles())
        triangles.push_back({t.normal, t.area_m2()});
    std::vector<FlatTriangle> largest = triangles;
    std::stable_sort(
        largest.begin(), largest.end(),
        [](const FlatTriangle& a, const FlatTriangle& b) { return a.area_m2 > b.area_m2; });
    largest.resize(std::min(largest.size(), kTriedNormals));
    const auto best = [&](const Vec3& across) {
        Vec3 normal(0);
        double largest_m2 = 0;
        for (const FlatTriangle& t : largest) {
            if (double{std::abs(glm::dot(t.normal, across))} > tolerances::kCoplanar_rad) continue;
            const double area_m2 = area_along(triangles, t.normal);
            if (area_m2 > (1 + kSameArea) * largest_m2) {
                largest_m2 = area_m2;
                normal = t.normal;
            }
        }
        return normal;
    };
    const Vec3 first = best(Vec3(0));
    if (first == Vec3(0)) return glm::mat3(1);
    Vec3 second = best(first);
    if (second == Vec3(0)) {
        // One of the two is at least 45 degrees from the first axis.
        const Vec3 other = std::abs(first.z) < std::abs(first.x) ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
        second = glm::cross(first, other);
    }
    second = glm::normalize(second - first * glm::dot(first, second));
    const std::array<Vec3, 3> found{first, second, glm::cross(first, second)};

    // In the order and with the signs that turn the world's axes least.
    glm::mat3 axes;
    std::array<bool, 3> used{};
    for (int axis = 0; axis < 3; ++axis) {
        std::size_t nearest = 3;
        for (std::size_t i = 0; i < 3; ++i) {
            if (used[i]) continue;
            if (nearest == 3 || std::abs(found[i][axis]) > std::abs(found[nearest][axis])) {
                nearest = i;
            }
        }
        used[nearest] = true;
        axes[axis] = found[nearest][axis] < 0 ? -found[nearest] : found[nearest];
        // Exactly the world's axes in rooms along them.
        for (int k = 0; k < 3; ++k) {
            if (std::abs(axes[axis][k]) < tolerances::kRounding) axes[axis][k] = 0;
        }
        axes[axis] = glm::normalize(axes[axis]);
    }
    return axes;
}

std::vector<float> planes_across(std::vector<GridAxis::Wall> walls, float low_m, float high_m,
                                 float cell_m) {
    std::stable_sort(walls.begin(), walls.end(),
                     [](const auto& a, const auto& b) { return a.area_m2 > b.area_m2; });
    std::vector<float> cuts;
    for (const GridAxis::Wall& wall : walls) {
        if (wall.area_m2 < double{kLeastFaces * cell_m * cell_m}) break;
        if (double{wall.at_m} < double{low_m} - tolerances::kSame_m ||
            double{wall.at_m} > double{high_m} + tolerances::kSame_m)
            continue;
        const bool apart = std::all_of(cuts.begin(), cuts.end(), [&](float cut) {
            return std::abs(wall.at_m - cut) >= kLeastCells * cell_m;
        });
        if (apart) cuts.push_back(wall.at_m);
    }
    std::sort(cuts.begin(), cuts.end());
    // Whole cells from the outermost walls to the ends.
    if (cuts.empty()) cuts.push_back(low_m);
    std::vector<float> planes;
    const float before = std::max(0.0F, GridAxis::parts_of(cuts.front() - low_m, cell_m));
    for (float k = before; k > 0; --k) planes.push_back(cuts.front() - k * cell_m);
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const float gap_m = cuts[i + 1] - cuts[i];
        const float parts = std::max(1.0F, GridAxis::parts_of(gap_m, cell_m));
        for (float k = 0; k < parts; ++k) planes.push_back(cuts[i] + gap_m * k / parts);
    }
    planes.push_back(cuts.back());
    const float after = GridAxis::parts_of(high_m - cuts.back(), cell_m);
    for (float k = 1; k <= after; ++k) planes.push_back(cuts.back() + k * cell_m);
    if (planes.size() < 2) planes.push_back(planes.back() + cell_m);
    return planes;
}

}  // namespace

GridLines::GridLines(const RayScene& scene, std::span<const Vec3> points, float cell_m)
    : axes_(main_axes(scene)) {
    Vec3 low(std::numeric_limits<float>::infinity());
    Vec3 high = -low;
    for (const Vec3& point : points) {
        low = glm::min(low, to_grid(point));
        high = glm::max(high, to_grid(point));
    }
    for (int axis = 0; axis < 3; ++axis) {
        planes_[static_cast<std::size_t>(axis)] =
            planes_across(flat_walls(scene, Vec3(0), axes_[axis], WallsOf::all_objects),
                          low[axis] - cell_m, high[axis] + cell_m, cell_m);
    }
}

}  // namespace aula
