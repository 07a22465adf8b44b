#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/rays/ray_scene.h"
#include "engine/waves/grid_lines.h"
#include "engine/waves/grid_points.h"
#include "engine/waves/wave_grid.h"

namespace aula {

/// The places and points of the surfaces that sound from the places reaches.
std::vector<Vec3> room_extent(const RayScene& scene, std::span<const Vec3> places);

/// The finite volumes of the air that sound reaches from given places, cut from the triangles of a
/// scene. Each cell of the grid's planes contains points, whose connections along the axes are
/// blocked by triangles. Points that are connected within a cell form a finite volume, so that a
/// thin wall divides a cell. Volumes, open faces and the areas of walls are those of the points and
/// connections. Which side of a triangle is inside does not matter, nor do coincident or missing
/// triangles, if they leave no opening of more than a twelfth of a face of a cell.
class RoomGrid {
 public:
    /// Within the bounds of `extent`, with cells of at most `cell_m`. Without air at the places the
    /// grid is empty. The objects of the scene must remain where they are.
    RoomGrid(std::shared_ptr<const RayScene> scene, std::span<const Vec3> extent,
             std::span<const Vec3> places, float cell_m);

    const WaveGrid& cells() const { return grid_; }
    const GridLines& lines() const { return lines_; }

    /// The cell of the air at a place in world coordinates, without a wall between; empty beyond
    /// the air of the grid.
    std::optional<std::uint32_t> cell_at(const Vec3& place) const;

    /// [cell] the cell of another grid of the same world with the same air, which is that of one of
    /// the points of each cell; empty where the other one has none.
    std::vector<std::optional<std::uint32_t>> cells_of(const RoomGrid& other) const;

    std::size_t memory_bytes() const;

 private:
    struct Builder;

    std::optional<GridPoints::Index> nearest_point(const Vec3& place) const;
    std::optional<std::uint32_t> cell_of(const GridPoints::Index& point) const;

    std::shared_ptr<const RayScene> scene_;
    GridLines lines_;
    GridPoints points_;
    WaveGrid grid_;
    std::vector<std::uint32_t> cell_of_;  ///< [part] finite volume, or kNoCell
};

}  // namespace aula
