#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/worker_pool.h"
#include "engine/patches/cell_grid.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// Patches that follow area, whatever the triangles: cells of lambda x lambda x lambda, each
/// parted by the dominant direction (+-x, +-y, +-z) of the surface normal on the side that faces
/// the sound. A patch's area is its effective area: exact by clipping, times the share of sample
/// points that sound can reach (of coincident faces one counts, of faces buried in solids none).
/// [propagation thread]
class PatchGrid {
 public:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    /// `inside`: points in the space that sound can reach, such as sources and listeners. Patches
    /// are larger than wanted where sound would reach more than `most_patches` of them.
    PatchGrid(const RayScene& scene, float patch_size_m, std::span<const Vec3> inside,
              std::uint64_t seed, WorkerPool& workers,
              double most_patches = std::numeric_limits<double>::infinity());
    ~PatchGrid();

    /// How many patches sound reaches in such a grid, and their size. Their areas, which take most
    /// of the time, are left out.
    struct Extent {
        std::size_t reached = 0;
        float patch_size_m = 0;
    };
    static Extent extent(const RayScene& scene, float patch_size_m, std::span<const Vec3> inside,
                         std::uint64_t seed, double most_patches);

    /// The patch of a point (off the surface by RayScene::kOffset_m) with its facing normal, or
    /// kNone.
    std::uint32_t find(const Vec3& point, const Vec3& facing_normal) const;

    /// Rows of a cache to which the energies that leave the first `count` points are added, times
    /// the factors: a patch's own row, which has its number, or, where panels of moving objects
    /// cross its cell, that of the point's side of them (PatchSides). kNone for no row.
    void find_rows(const LanePoints& points, const LanePoints& facing_normals, std::size_t count,
                   std::array<std::uint32_t, kLanes>& rows,
                   std::array<float, kLanes>& factors) const;

    /// A row whose energy is radiated at a point, with this share to the square metre.
    struct Radiator {
        std::uint32_t row = kNone;
        float per_m2 = 0;
    };

    /// The rows whose sum a point of a triangle radiates.
    void find_radiators(std::uint32_t triangle, const Vec3& point, const Vec3& facing_normal,
                        std::vector<Radiator>& radiators) const;

    /// Effective area; 0 if nothing of the patch can be reached.
    float area_m2(std::uint32_t patch) const;

    /// The share of a row's energy that a square metre of its patch radiates, in the mean of the
    /// patch.
    float per_m2(std::uint32_t row) const;

    /// Sound on an area round a point of a patch over the mean of the patch, 1 where it is even.
    float relative_irradiance(std::uint32_t patch, std::uint32_t triangle, const Vec3& point,
                              const Vec3& facing_normal) const;

    /// Where a row's patch is.
    using Cell = CellGrid::Cell;
    Cell cell(std::uint32_t row) const;

    /// Brings the areas of moving objects up to date after RayScene::move. Patches that objects
    /// came to and have left for more than `keep` such moves are given up, and so are the rows of
    /// their sides; new ones take their numbers.
    void scene_moved(int keep);

    /// Number of rows: of patches and of their sides.
    std::size_t size() const;

    /// Number of patches that sound reached when the grid was made.
    std::size_t reached() const;

    /// As wanted; larger where there would be too many, or more than 2^17 across.
    float patch_size_m() const;

 private:
    struct State;
    static std::unique_ptr<State> with_at_most(double most_patches, const RayScene& scene,
                                               float patch_size_m, std::span<const Vec3> inside,
                                               std::uint64_t seed, WorkerPool& workers);

    std::unique_ptr<State> state_;
};

}  // namespace aula
