#pragma once

#include <array>
#include <cstdint>

#include "aula/engine/frame.h"
#include "engine/patches/cell_clipping.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// A grid of cells over a scene, cut at large walls; each cell is divided by the dominant direction
/// of the normals. A key identifies a cell and a direction. [propagation thread]
class CellGrid {
 public:
    /// Cells of `wanted_m`, or larger in scenes of more than 2^17 such cells across.
    CellGrid(const RayScene& scene, float wanted_m);

    float size_m() const { return size_m_; }
    const Vec3& origin() const { return origin_; }  ///< origin of the cell indices
    const Cuts& cuts() const { return cuts_; }

    static std::uint64_t key(const CellIndex& cell, const Vec3& normal);
    /// A number of a key's cell, the same for all directions.
    static std::uint64_t cell_of(std::uint64_t key);
    /// The keys of a cell with this number, one for each dominant direction.
    static std::array<std::uint64_t, 6> keys_of_cell(std::uint64_t cell);
    std::uint64_t key_at(const Vec3& point, const Vec3& normal) const;
    /// The keys of the first `count` points.
    void keys_at(const LanePoints& points, const LanePoints& normals, std::size_t count,
                 std::array<std::uint64_t, kLanes>& keys) const;

    /// The cell of a key.
    PatchCell cell(std::uint64_t key) const;

 private:
    Vec3 origin_{0};  ///< the scene's lowest corner
    float size_m_;
    Cuts cuts_;
};

}  // namespace aula
