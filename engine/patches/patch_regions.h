#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/worker_pool.h"
#include "engine/patches/patch_grid.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// Groups of a grid's rows that lie in one cell of several patches and face one direction, and
/// before which there is one space: its rows, of any direction, see half of each other. No region
/// extends to the other side of a partition or of a door. [propagation thread]
class PatchRegions {
 public:
    static constexpr std::uint32_t kNone = PatchGrid::kNone;

    /// Regions are larger where there would be more than `most_large` cells with them. All rays are
    /// traced here.
    PatchRegions(const RayScene& scene, const PatchGrid& grid, std::size_t most_large,
                 WorkerPool& workers);

    /// The region of every row, or kNone: of moving objects, without a place that sound reaches,
    /// or of the smallest areas where regions are many.
    std::span<const std::uint32_t> of_rows() const { return of_rows_; }

    /// Number of regions, the largest area first.
    std::size_t count() const { return count_; }

    /// The width of the cells.
    float size_m() const { return size_m_; }

 private:
    std::vector<std::uint32_t> of_rows_;
    std::size_t count_ = 0;
    float size_m_ = 0;
};

}  // namespace aula
