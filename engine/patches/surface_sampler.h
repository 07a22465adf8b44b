#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "engine/base/tolerances.h"
#include "engine/patches/cell_grid.h"
#include "engine/patches/patch_index.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// A point on one side of a triangle that represents a part of the area of its patch.
struct SurfaceSample {
    Vec3 point{0};   ///< on the surface
    Vec3 normal{0};  ///< of this side
    std::uint32_t triangle = 0;
    std::uint32_t patch = 0;
    float area_m2 = 0;

    /// The point at the distance from the surface at which points belong to cells: the same for
    /// deposits, gathers and areas, so that rounding cannot divide a wall in a plane of the grid.
    Vec3 nudged_off_surface() const { return point + tolerances::kOffset_m * normal; }
};

/// Clips both sides of triangles at the cells of a grid, at their present positions. Uses the
/// patches of these cells in an index. [propagation thread]
class SurfaceSampler {
 public:
    SurfaceSampler(const RayScene& scene, const CellGrid& grid, PatchIndex& index,
                   std::uint64_t seed)
        : scene_(scene), grid_(grid), index_(index), seed_(seed) {}

    /// Calls `visit(patch, normal, area)` for every part of both sides of a triangle.
    void for_each_patch(std::uint32_t triangle,
                        const std::function<void(std::uint32_t, const Vec3&, float)>& visit);

    /// The share of the samples that a patch gets, 0 to 1.
    using ShareOf = std::function<float(std::uint32_t patch)>;

    /// Samples triangles in proportion to area, with `per_cell` samples for a full cell times the
    /// share of its patch. Where many faces cross in each cell they are fewer: about kFullCells *
    /// `per_cell` for a patch on the mean. The areas of a patch's samples add up to its area.
    std::vector<SurfaceSample> sample(std::span<const std::uint32_t> triangles, int per_cell,
                                      const ShareOf& share_of);

    /// Twice the area of the patches of furnished rooms, which is up to that of one full cell on
    /// the mean: these have all samples.
    static constexpr double kFullCells = 2;

 private:
    float density(std::span<const std::uint32_t> triangles, int per_cell, const ShareOf& share_of);
    template <typename Visit>
    void for_each_part(std::uint32_t triangle, const Visit& visit);

    const RayScene& scene_;
    const CellGrid& grid_;
    PatchIndex& index_;
    std::uint64_t seed_;
};

}  // namespace aula
