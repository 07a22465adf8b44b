#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// How unevenly sound falls on the surface of a patch. Faces in the inside of furniture or behind
/// a curtain share patches with those in front of them, and share what the patch radiates; in a
/// cluttered cell those that much sound meets are those that are seen as well. So sound is counted
/// where it falls, in small parts: pieces of large triangles, groups of small ones that follow each
/// other. [propagation thread]
class IrradianceMap {
 public:
    IrradianceMap(const RayScene& scene, float patch_size_m);
    ~IrradianceMap();
    IrradianceMap(IrradianceMap&&) noexcept;

    /// Counts a hit of sound in a patch, at a point with its facing normal.
    void add_hit(std::uint32_t patch, std::uint32_t triangle, const Vec3& point,
                 const Vec3& facing_normal);

    /// Ends counting. `patch_of` gives the patch of a point, off the surface, with its normal.
    void finish(
        std::span<const float> area_m2,
        const std::function<std::uint32_t(const Vec3& point, const Vec3& facing_normal)>& patch_of);

    /// Sound on an area round a point of a patch over the mean of the patch; 1 in patches where no
    /// more than chance tells the parts apart.
    float relative(std::uint32_t patch, std::uint32_t triangle, const Vec3& point,
                   const Vec3& facing_normal) const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
