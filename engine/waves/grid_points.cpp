#include "engine/waves/grid_points.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/tolerances.h"
#include "engine/rays/follow_rays.h"

namespace aula {

namespace {

/// The part of a point on a wall; no cell has as many.
constexpr std::uint8_t kSolid = 255;
static_assert(GridPoints::kPointsOfCell <= kSolid);

/// A point this near a wall, in distances of points, is on it: rounding must not open a wall. Above
/// the rounding of 400 cells.
constexpr float kOnWall = 1e-3F;
static_assert(kOnWall > 400 * GridPoints::kPoints * tolerances::kRounding);

/// Length of a line before the first plane and beyond the last one: walls in these planes are hit,
/// and no further ones.
constexpr float kBefore_m = 0.01F;
static_assert(double{kBefore_m} > 2 * tolerances::kSame_m);

}  // namespace

GridPoints::GridPoints(const RayScene& scene, const GridLines& lines) {
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const std::vector<float>& planes = lines.planes(axis);
        cells_[a] = static_cast<std::uint32_t>(lines.cells(axis));
        points_[a] = cells_[a] * kPoints;
        for (std::uint32_t p = 0; p < points_[a]; ++p) {
            const float low = planes[p / kPoints];
            const float share = (static_cast<float>(p % kPoints) + 0.5F) / kPoints;
            at_m_[a].push_back(low + (planes[p / kPoints + 1] - low) * share);
        }
    }
    part_.assign(std::size_t{points_[0]} * points_[1] * points_[2], 0);
    walls_.assign(cell_count(), 0);
    for (std::size_t axis = 0; axis < 3; ++axis) trace(scene, lines, axis);
    divide_cells();
}

GridPoints::Index GridPoints::on_line(std::size_t axis, std::uint32_t line,
                                      std::uint32_t along) const {
    const std::size_t b = axis == 0 ? 1 : 0;
    const std::size_t c = axis == 2 ? 1 : 2;
    Index i{};
    i[axis] = along;
    i[b] = line % points_[b];
    i[c] = line / points_[b];
    return i;
}

std::uint32_t GridPoints::part_at(const Index& i) const {
    const std::uint8_t part = part_[point(i)];
    return part == kSolid ? kNoPart : first_part_[cell_of_point(i)] + part;
}

void GridPoints::shrink() {
    blocked_ = {};
    crossings_ = {};
    walls_ = {};
    size_ = {};
    cell_ = {};
}

/// Registers a wall at a position of a line.
void GridPoints::meet(std::size_t axis, std::uint32_t line, float at, std::uint32_t triangle) {
    const std::vector<float>& position = at_m_[axis];
    const auto high = static_cast<std::uint32_t>(
        std::lower_bound(position.begin(), position.end(), at) - position.begin());
    const auto block = [&](std::uint32_t high_point) {
        std::vector<GridCrossing>& all = crossings_[axis];
        if (!all.empty() && all.back().line == line && all.back().high_point == high_point) {
            all.back().last_m = at;
            all.back().last_triangle = triangle;
        } else {
            all.push_back({high_point, line, at, at, triangle, triangle});
        }
        if (high_point == 0) return;
        const Index below = on_line(axis, line, high_point - 1);
        blocked_[axis][point(below)] = 1;
        mark(below, high_point % kPoints == 0 ? kAfter << axis : kInside);
    };
    const auto is_on = [&](std::uint32_t p) {
        const float apart = position[1] - position[0];
        return p < position.size() && std::abs(position[p] - at) < kOnWall * apart;
    };
    const auto fill = [&](std::uint32_t p) {
        const Index solid = on_line(axis, line, p);
        part_[point(solid)] = kSolid;
        mark(solid, kInside);
    };
    if (high > 0 && is_on(high - 1)) {
        fill(high - 1);
        block(high - 1);
    }
    block(high);
    if (is_on(high)) {
        fill(high);
        block(high + 1);
    }
}

/// Finds the walls on all lines along an axis.
void GridPoints::trace(const RayScene& scene, const GridLines& lines, std::size_t axis) {
    const auto a = static_cast<int>(axis);
    blocked_[axis].assign(part_.size(), 0);
    const std::uint32_t count = lines_along(axis);
    const std::vector<float>& planes = lines.planes(a);
    const float begin = planes.front() - kBefore_m;
    const Vec3 direction = lines.axes()[a];

    struct Met {
        std::uint32_t line = 0;
        float at = 0;
        std::uint32_t triangle = 0;
    };
    std::vector<Met> met;
    struct Open {
        std::uint32_t line = 0;
        float from = 0;  // on the line
    };
    std::vector<Open> open;
    for (std::uint32_t line = 0; line < count; ++line) open.push_back({line, begin});
    const float end = planes.back() + kBefore_m;
    const auto segment = [&](const Open& part) -> Ray {
        Vec3 origin = position(on_line(axis, part.line, 0));
        origin[a] = part.from;
        return {lines.to_world(origin), direction, end - part.from};
    };
    follow_rays(scene, open, segment, [&](Open& part, const Ray&, const Hit& hit) {
        if (!hit.any()) return false;
        const float at = part.from + hit.distance_m;
        met.push_back({part.line, at, hit.triangle});
        part.from = at + RayScene::offset_after(std::abs(at));
        return part.from < end;
    });
    std::stable_sort(met.begin(), met.end(),
                     [](const Met& x, const Met& y) { return x.line < y.line; });
    for (const Met& m : met) meet(axis, m.line, m.at, m.triangle);
}

/// Numbers the connected parts of each cell.
void GridPoints::divide_cells() {
    const std::uint32_t count = cells_[0] * cells_[1] * cells_[2];
    std::array<std::uint32_t, kPointsOfCell> open{};
    for (std::uint32_t cell = 0; cell < count; ++cell) {
        first_part_.push_back(parts());
        if (!is_cut(cell)) {
            size_.push_back(kPointsOfCell);
            cell_.push_back(cell);
            continue;
        }
        const Index c = cell_index(cell);
        const Index base{c[0] * kPoints, c[1] * kPoints, c[2] * kPoints};
        std::array<std::uint8_t, kPointsOfCell> part{};  // + 1
        std::uint8_t found = 0;
        const auto at = [&](std::uint32_t k) {
            return point({base[0] + k % kPoints, base[1] + k / kPoints % kPoints,
                          base[2] + k / kPoints / kPoints});
        };
        for (std::uint32_t seed = 0; seed < kPointsOfCell; ++seed) {
            if (part[seed] != 0 || part_[at(seed)] == kSolid) continue;
            ++found;
            std::size_t waiting = 0;
            std::uint32_t members = 0;
            open[waiting++] = seed;
            part[seed] = found;
            while (waiting > 0) {
                const std::uint32_t k = open[--waiting];
                ++members;
                std::uint32_t step = 1;
                for (std::size_t axis = 0; axis < 3; ++axis, step *= kPoints) {
                    const std::uint32_t along = k / step % kPoints;
                    const auto visit = [&](std::uint32_t other, std::uint32_t low) {
                        if (part[other] != 0 || blocked_[axis][at(low)] != 0) return;
                        if (part_[at(other)] == kSolid) return;
                        part[other] = found;
                        open[waiting++] = other;
                    };
                    if (along > 0) visit(k - step, k - step);
                    if (along + 1 < kPoints) visit(k + step, k);
                }
            }
            size_.push_back(members);
            cell_.push_back(cell);
        }
        for (std::uint32_t k = 0; k < kPointsOfCell; ++k) {
            if (part[k] != 0) part_[at(k)] = static_cast<std::uint8_t>(part[k] - 1);
        }
    }
    first_part_.push_back(parts());
}

}  // namespace aula
