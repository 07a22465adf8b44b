#include "engine/patches/cell_grid.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "process/multiversion.h"

namespace aula {

namespace {

constexpr float kAxisAligned = 0.99999F;  // least cosine of a cutting wall's normal and an axis
constexpr float kWallCells = 4;           // least area of such a wall, in cell faces

constexpr int kDirectionBit = 60;  // lowest bit of the direction in a key
constexpr std::int32_t kIndexBias = 1 << 19;
constexpr std::uint32_t kIndexMask = (1U << 20) - 1;

/// The key of a patch: 20 bits for each index of its cell, and the dominant direction of a normal.
/// Without branches.
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
           bits(cell[0]) << 40 | bits(cell[1]) << 20 | bits(cell[2]);
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

/// The static walls perpendicular to an axis. Walls within a millimetre are merged at the position
/// of the largest triangle: otherwise points off their surfaces would be on both sides of the cut.
std::vector<GridAxis::Wall> walls_across(const RayScene& scene, int axis, float from_m,
                                         float cell_m) {
    struct Slice {
        GridAxis::Wall wall;
        float largest_m2 = 0;
    };
    std::map<std::int64_t, Slice> slices;
    for (const RayScene::Triangle& triangle : scene.triangles()) {
        if (std::abs(triangle.normal[axis]) < kAxisAligned || scene.moves(triangle)) continue;
        const float at_m = triangle.vertices[0][axis] - from_m;
        const float area_m2 = triangle.area_m2();
        Slice& slice = slices[std::llround(1000 * at_m)];
        slice.wall.area_m2 += double{area_m2};
        if (area_m2 <= slice.largest_m2) continue;
        slice.largest_m2 = area_m2;
        slice.wall.at_m = at_m;
    }
    std::vector<GridAxis::Wall> walls;
    for (const auto& [at_mm, slice] : slices) {
        if (slice.wall.area_m2 >= double{kWallCells * cell_m * cell_m}) walls.push_back(slice.wall);
    }
    return walls;
}

}  // namespace

CellGrid::CellGrid(const RayScene& scene, float wanted_m) : size_m_(wanted_m) {
    const Bounds bounds = scene.bounds();
    const bool empty = scene.triangle_count() == 0;
    if (!empty) origin_ = bounds.min;
    const Vec3 extent = empty ? Vec3(0) : bounds.max - bounds.min;
    // A key has 20 bits per coordinate; moving objects may need some of them.
    size_m_ =
        std::max(wanted_m, std::max({extent.x, extent.y, extent.z}) / static_cast<float>(1 << 17));
    for (int axis = 0; axis < 3; ++axis) {
        cuts_[static_cast<std::size_t>(axis)] =
            GridAxis(extent[axis], size_m_, walls_across(scene, axis, origin_[axis], size_m_));
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
        const auto bits = static_cast<std::uint32_t>(key >> (40 - 20 * axis)) & kIndexMask;
        const std::int32_t index = static_cast<std::int32_t>(bits) - kIndexBias;
        cell.low[axis] = origin_[axis] + cuts.begin_m(index);
        cell.high[axis] = origin_[axis] + cuts.begin_m(index + 1);
    }
    const std::uint64_t direction = key >> kDirectionBit;
    cell.direction[static_cast<int>(direction / 2)] = direction % 2 == 0 ? 1.0F : -1.0F;
    return cell;
}

}  // namespace aula
