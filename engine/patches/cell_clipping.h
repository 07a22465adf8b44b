#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "aula/engine/scene.h"
#include "engine/patches/grid_axis.h"

namespace aula {

/// A cell of a grid: its index along each axis.
using CellIndex = std::array<std::int32_t, 3>;
using Cuts = std::array<GridAxis, 3>;

/// The cell of a point relative to the grid's origin.
inline CellIndex cell_at(const Cuts& cuts, const Vec3& point) {
    return {cuts[0].cell(point.x), cuts[1].cell(point.y), cuts[2].cell(point.z)};
}

/// A triangle clipped to a convex polygon: three corners and one more for each of six cuts.
class ClippedPolygon {
 public:
    void add(const Vec3& p) { corner_[static_cast<std::size_t>(count_++)] = p; }
    const Vec3& at(int i) const { return corner_[static_cast<std::size_t>(i)]; }
    int count() const { return count_; }

    float area_m2() const;

    /// A uniformly distributed point of the polygon for uniform u.
    Vec3 point(std::array<float, 2> u) const;

    /// The part where sign * (x_axis - at_m) <= 0.
    ClippedPolygon cut(int axis, float at_m, float sign) const;

 private:
    std::array<Vec3, 9> corner_;
    int count_ = 0;
};

/// Calls `visit(cell, polygon)` for the part of a polygon in every cell that it intersects.
template <typename Visit>
void for_each_cell(const ClippedPolygon& polygon, const Cuts& cuts, std::size_t axis,
                   CellIndex cell, const Visit& visit) {
    if (axis == 3) {
        visit(cell, polygon);
        return;
    }
    const auto along = static_cast<int>(axis);
    float low = polygon.at(0)[along];
    float high = low;
    for (int i = 1; i < polygon.count(); ++i) {
        low = std::min(low, polygon.at(i)[along]);
        high = std::max(high, polygon.at(i)[along]);
    }
    const std::int32_t first = cuts[axis].cell(low);
    const std::int32_t last = cuts[axis].cell(high);
    for (std::int32_t k = first; k <= last; ++k) {
        ClippedPolygon part = polygon;
        if (k > first) part = part.cut(along, cuts[axis].begin_m(k), -1);
        if (k < last && part.count() > 2) part = part.cut(along, cuts[axis].begin_m(k + 1), 1);
        if (part.count() < 3) continue;
        cell[axis] = k;
        for_each_cell(part, cuts, axis + 1, cell, visit);
    }
}

}  // namespace aula
