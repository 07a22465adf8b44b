#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/rays/ray_scene.h"
#include "engine/waves/grid_lines.h"

namespace aula {

/// The walls between two adjacent points of a line: the first and the last one along it.
struct GridCrossing {
    std::uint32_t high_point = 0;  ///< along the line; 0 before the first
    std::uint32_t line = 0;
    float first_m = 0;
    float last_m = 0;
    std::uint32_t first_triangle = 0;
    std::uint32_t last_triangle = 0;
};

/// Points in the cells of a grid's planes, and the triangles between neighbouring points. Points
/// that are connected within their cell form a part of it.
class GridPoints {
 public:
    using Index = std::array<std::uint32_t, 3>;

    /// Points of a cell along an axis: the position of a wall is found to a sixth of a cell, a
    /// volume to the mean over the 36 lines through a cell.
    static constexpr std::uint32_t kPoints = 6;
    static constexpr std::uint32_t kPointsOfFace = kPoints * kPoints;
    static constexpr std::uint32_t kPointsOfCell = kPoints * kPoints * kPoints;
    /// No part, no cell.
    static constexpr std::uint32_t kNoPart = std::numeric_limits<std::uint32_t>::max();

    GridPoints(const RayScene& scene, const GridLines& lines);

    std::uint32_t cell_count() const { return cells_[0] * cells_[1] * cells_[2]; }
    /// Of the planes, along each axis.
    const Index& cells() const { return cells_; }
    const Index& points() const { return points_; }
    Index cell_index(std::uint32_t cell) const {
        return {cell % cells_[0], cell / cells_[0] % cells_[1], cell / cells_[0] / cells_[1]};
    }
    std::uint32_t cell_at(const Index& index) const {
        return (index[2] * cells_[1] + index[1]) * cells_[0] + index[0];
    }
    std::uint32_t lines_along(std::size_t axis) const {
        return static_cast<std::uint32_t>(part_.size() / points_[axis]);
    }
    Index on_line(std::size_t axis, std::uint32_t line, std::uint32_t along) const;

    /// True if a wall lies in a cell.
    bool is_cut(std::uint32_t cell) const { return (walls_[cell] & kInside) != 0; }
    /// True if a wall lies between a cell and the next one along an axis.
    bool is_cut_after(std::uint32_t cell, std::size_t axis) const {
        return (walls_[cell] & kAfter << axis) != 0;
    }
    bool is_blocked(std::size_t axis, const Index& low) const {
        return blocked_[axis][point(low)] != 0;
    }
    /// By line, and along it.
    const std::vector<GridCrossing>& crossings(std::size_t axis) const { return crossings_[axis]; }

    std::uint32_t parts() const { return static_cast<std::uint32_t>(size_.size()); }
    std::uint32_t first_part(std::uint32_t cell) const { return first_part_[cell]; }
    /// The number of points of a part.
    std::uint32_t size(std::uint32_t part) const { return size_[part]; }
    std::uint32_t cell_of(std::uint32_t part) const { return cell_[part]; }
    /// In the coordinates of the grid.
    Vec3 position(const Index& i) const { return {at_m_[0][i[0]], at_m_[1][i[1]], at_m_[2][i[2]]}; }
    /// The part of a point; kNoPart on a wall.
    std::uint32_t part_at(const Index& point) const;

    /// Forgets what is needed only while a grid is built: all but position() and part_at().
    void shrink();

    /// After shrink().
    std::size_t memory_bytes() const {
        return part_.size() + first_part_.size() * sizeof first_part_[0];
    }

 private:
    // Bits of walls_.
    static constexpr unsigned kInside = 1;
    static constexpr unsigned kAfter = 2;  ///< along the axis x, then those of y and z

    std::size_t point(const Index& i) const {
        return (std::size_t{i[2]} * points_[1] + i[1]) * points_[0] + i[0];
    }
    void trace(const RayScene& scene, const GridLines& lines, std::size_t axis);
    void meet(std::size_t axis, std::uint32_t line, float at, std::uint32_t triangle);
    std::uint32_t cell_of_point(const Index& i) const {
        return cell_at({i[0] / kPoints, i[1] / kPoints, i[2] / kPoints});
    }
    void mark(const Index& i, unsigned wall) {
        std::uint8_t& walls = walls_[cell_of_point(i)];
        walls = static_cast<std::uint8_t>(walls | wall);
    }
    void divide_cells();

    Index cells_{};
    Index points_{};
    std::array<std::vector<float>, 3> at_m_;    ///< positions of the points
    std::array<std::vector<char>, 3> blocked_;  ///< [point] towards the next one of the axis
    std::vector<std::uint8_t> walls_;           ///< [cell] where there are some
    std::array<std::vector<GridCrossing>, 3> crossings_;
    std::vector<std::uint8_t> part_;         ///< [point] part of its cell
    std::vector<std::uint32_t> first_part_;  ///< [cell], and the number of parts
    std::vector<std::uint32_t> size_;        ///< [part] points
    std::vector<std::uint32_t> cell_;        ///< [part]
};

}  // namespace aula
