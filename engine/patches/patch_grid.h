#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/worker_pool.h"
#include "engine/patches/cell_grid.h"
#include "engine/patches/patch_index.h"
#include "engine/patches/reach_walks.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// Patches defined by area, independent of the triangles: cells of lambda x lambda x lambda, each
/// divided by the dominant direction (+-x, +-y, +-z) of the surface normal on the side that faces
/// the sound. A patch's area is its effective area: exact by clipping, times the share of sample
/// points that sound can reach (one of coincident faces, no faces buried in solids). [propagation
/// thread]
class PatchGrid {
 public:
    static constexpr std::uint32_t kNone = PatchIndex::kNone;

    /// `inside`: points in the space that sound can reach, such as sources and listeners. Patches
    /// are larger than requested if those that sound reaches would otherwise have more than
    /// `max_rows` rows.
    PatchGrid(const RayScene& scene, float patch_size_m, std::span<const Vec3> inside,
              std::uint64_t seed, WorkerPool& workers,
              double max_rows = std::numeric_limits<double>::infinity());
    ~PatchGrid();

    /// The number of patches that sound reaches in such a grid, and their size, if no panel divides
    /// them. The areas, which take most of the time, are not computed.
    struct Extent {
        std::size_t reached = 0;
        float patch_size_m = 0;
    };
    static Extent extent(const RayScene& scene, float patch_size_m, std::span<const Vec3> inside,
                         std::uint64_t seed, double max_patches);

    /// The patch of a point (off the surface by tolerances::kOffset_m) with its facing normal, or
    /// kNone.
    std::uint32_t find(const Vec3& point, const Vec3& facing_normal) const;

    /// The cache rows for the energies that leave the first `count` points, and factors for the
    /// energies. The row is the patch's own, which has the same number, or, where panels cross its
    /// cell, that of the point's side of the panels (PatchSides). kNone for no row.
    void find_rows(const LanePoints& points, const LanePoints& facing_normals, std::size_t count,
                   std::array<std::uint32_t, kLanes>& rows,
                   std::array<float, kLanes>& factors) const;

    /// The row whose energy is radiated at a point, or kNone, with its share per square metre.
    struct Radiator {
        std::uint32_t row = kNone;
        float per_m2 = 0;
    };

    /// What radiates at a point of a triangle: the row that find_rows() returns for it.
    Radiator find_radiator(std::uint32_t triangle, const Vec3& point,
                           const Vec3& facing_normal) const;

    /// Effective area; 0 if no part of the patch can be reached.
    float area_m2(std::uint32_t patch) const;

    /// The share of a row's energy that a square metre of its patch radiates, as a mean over the
    /// patch.
    float per_m2(std::uint32_t row) const;

    /// Irradiance around a point of a patch relative to the mean of the patch; 1 where it is
    /// uniform.
    float relative_irradiance(std::uint32_t patch, std::uint32_t triangle, const Vec3& point,
                              const Vec3& facing_normal) const;

    /// The cell of a row's patch.
    PatchCell cell(std::uint32_t row) const;

    /// Updates the patches and areas of moving objects after RayScene::move. Patches that only
    /// moving objects occupied, and the rows of sides, are released as soon as the objects have
    /// left them. New ones reuse their numbers: energies from before the move are invalid.
    void scene_moved();

    /// Finds the patches behind walls that did not transmit sound before a change of materials;
    /// where there are none, it does nothing. Energies from before the change are invalid.
    void materials_changed();

    /// Number of rows, of patches and of their sides.
    std::size_t size() const;

    /// Number of patches that sound reaches with all walls that have transmitted so far.
    std::size_t reached() const;

    /// Number of rows for the energies of these patches: one for each, or one for each of its
    /// sides.
    std::size_t reached_rows() const;

    /// The requested size, or larger to limit the number of patches or the extent to 2^17 cells.
    float patch_size_m() const;

 private:
    struct State;
    static std::unique_ptr<State> with_at_most(double max_patches, const RayScene& scene,
                                               float patch_size_m, ReachWalks& walks,
                                               std::uint64_t seed, WorkerPool& workers);

    std::unique_ptr<State> state_;
};

}  // namespace aula
