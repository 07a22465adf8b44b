#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "engine/base/worker_pool.h"
#include "engine/patches/cell_grid.h"
#include "engine/patches/irradiance_map.h"
#include "engine/patches/patch_index.h"
#include "engine/patches/reach_walks.h"
#include "engine/patches/surface_sampler.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// The patches of static surfaces that sound can reach, found by random walks, and a test of single
/// points. [propagation thread]
class SoundReach {
 public:
    SoundReach(const RayScene& scene, const CellGrid& grid, const PatchIndex& index,
               std::uint64_t seed)
        : scene_(scene), grid_(grid), index_(index), seed_(seed) {}

    /// Marks the patches of the index that walks reach, until a round of them adds hardly any.
    /// Patches that an earlier call has marked remain so. Counts the walks' hits after a first
    /// reflection away from their start in `irradiance`. False if more than `max_patches` are
    /// marked.
    bool mark(ReachWalks& walks, double max_patches, IrradianceMap& irradiance);

    /// Marks a patch.
    void mark(std::uint32_t patch);

    /// True if the patch is marked.
    bool marked(std::uint32_t patch) const { return patch < marked_.size() && marked_[patch]; }

    /// Number of marked patches.
    std::size_t count() const { return count_; }

    /// For every sample, whether sound can reach it at the present positions of all objects: a ray
    /// from it ends on a marked patch, on a moving object or in the open. Of coincident faces one
    /// is reached.
    std::vector<char> reaches(std::span<const SurfaceSample> samples, WorkerPool& workers) const;

 private:
    void test(std::span<const SurfaceSample> samples, std::span<char> reached,
              std::uint64_t seed) const;
    bool has_sound(const Ray& ray, const Hit& hit) const;

    const RayScene& scene_;
    const CellGrid& grid_;
    const PatchIndex& index_;
    std::uint64_t seed_;
    std::vector<char> marked_;  ///< [patch]; patches that are added later are not marked
    std::size_t count_ = 0;
};

}  // namespace aula
