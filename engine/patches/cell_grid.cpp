#include "engine/patches/cell_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/patches/flat_walls.h"
#include "process/multiversion.h"

namespace aula {

namespace {

/// Least area of a wall at which the grid is cut, in cell faces. A choice: each smaller one, as of
/// furniture, would divide all patches beside it through the scene.
constexpr float kLeastFaces = 4;

/// Of a key: the bits of each index, of which half are negative, and the lowest bit of the
/// direction, which has the rest.
constexpr int kIndexBits = 20;
// Indices are stored above 0.
constexpr std::int32_t kIndexBias = 1 << (kIndexBits - 1);
constexpr std::uint32_t kIndexMask = (1U << kIndexBits) - 1;  // all bits of an index
// Above the three indices.
constexpr int kDirectionBit = 3 * kIndexBits;
static_assert(kDirectionBit + 3 <= 64, "six directions");

/// Cells across a scene at most. A choice: objects may move three times its extent before their
/// indices overflow.
constexpr int kMostCells = 1 << 17;
static_assert(kIndexBias >= 4 * kMostCells);

/// The key of a patch: the indices of its cell, and the dominant direction of a normal. Without
/// branches.
inline std::uint64_t cell_key(const CellIndex& cell, const Vec3& normal) {
    const Vec3 size(std::abs(normal.x), std::abs(normal.y), std::abs(normal.z));
    const bool along_x = size.x >= size.y && size.x >= size.z;
    const bool along_y = size.y >= size.z;
    const std::int32_t axis = along_x ? 0 : along_y ? 2 : 4;
    const float component = along_x ? normal.x : along_y ? normal.y : normal.z;
    const std::int32_t direction = axis + (component > 0 ? 0 : 1);
    const auto bits = [](std::int32_t k) {
        return static_cast<std::uint64_t>(static_cast<std::uint32_t>(k + kIndexBias) & kIndexMask);
    };
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(direction)) << kDirectionBit |
           bits(cell[0]) << 2 * kIndexBits | bits(cell[1]) << kIndexBits | bits(cell[2]);
}

AULA_MULTIVERSION
void cell_keys(const LanePoints& points, const LanePoints& normals, std::size_t count,
               const Vec3& origin, const Cuts& cuts, std::array<std::uint64_t, kLanes>& keys) {
    for (std::size_t i = 0; i < padded_lanes(count); ++i) {
        keys[i] = cell_key(cell_at(cuts, Vec3(points.x[i] - origin.x, points.y[i] - origin.y,
                                              points.z[i] - origin.z)),
                           Vec3(normals.x[i], normals.y[i], normals.z[i]));
    }
}

}  // namespace

CellGrid::CellGrid(const RayScene& scene, float wanted_m) : size_m_(wanted_m) {
    const Bounds bounds = scene.bounds();
    const bool empty = scene.triangle_count() == 0;
    if (!empty) origin_ = bounds.min;
    const Vec3 extent = empty ? Vec3(0) : bounds.max - bounds.min;
    size_m_ = std::max(wanted_m, std::max({extent.x, extent.y, extent.z}) / float{kMostCells});
    for (int axis = 0; axis < 3; ++axis) {
        Vec3 direction(0);
        direction[axis] = 1;
        std::vector<GridAxis::Wall> walls =
            flat_walls(scene, origin_, direction, WallsOf::static_objects);
        std::erase_if(walls, [&](const GridAxis::Wall& wall) {
            return wall.area_m2 < double{kLeastFaces * size_m_ * size_m_};
        });
        cuts_[static_cast<std::size_t>(axis)] = GridAxis(extent[axis], size_m_, std::move(walls));
    }
}

std::uint64_t CellGrid::key(const CellIndex& cell, const Vec3& normal) {
    return cell_key(cell, normal);
}

std::uint64_t CellGrid::cell_of(std::uint64_t key) {
    return key & ((std::uint64_t{1} << kDirectionBit) - 1);
}

std::array<std::uint64_t, 6> CellGrid::keys_of_cell(std::uint64_t cell) {
    std::array<std::uint64_t, 6> keys;
    for (std::uint64_t direction = 0; direction < keys.size(); ++direction) {
        keys[direction] = direction << kDirectionBit | cell;
    }
    return keys;
}

std::uint64_t CellGrid::key_at(const Vec3& point, const Vec3& normal) const {
    return cell_key(cell_at(cuts_, point - origin_), normal);
}

void CellGrid::keys_at(const LanePoints& points, const LanePoints& normals, std::size_t count,
                       std::array<std::uint64_t, kLanes>& keys) const {
    best_version<cell_keys>(points, normals, count, origin_, cuts_, keys);
}

PatchCell CellGrid::cell(std::uint64_t key) const {
    PatchCell cell;
    for (int axis = 0; axis < 3; ++axis) {
        const GridAxis& cuts = cuts_[static_cast<std::size_t>(axis)];
        const auto bits = static_cast<std::uint32_t>(key >> (kIndexBits * (2 - axis))) & kIndexMask;
        const std::int32_t index = static_cast<std::int32_t>(bits) - kIndexBias;
        cell.low[axis] = origin_[axis] + cuts.begin_m(index);
        cell.high[axis] = origin_[axis] + cuts.begin_m(index + 1);
    }
    const std::uint64_t direction = key >> kDirectionBit;
    cell.direction[static_cast<int>(direction / 2)] = direction % 2 == 0 ? 1.0F : -1.0F;
    return cell;
}

}  // namespace aula
