#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// The irradiance on parts of a patch relative to the patch's mean. Faces inside furniture or
/// behind a curtain share patches with the faces in front of them, and share the radiated energy of
/// the patch. In a cluttered cell the faces that receive much sound are also those that are
/// visible. Hits are therefore counted on small parts: pieces of large triangles, and groups of
/// connected small ones. [propagation thread]
class IrradianceMap {
 public:
    /// The patch of a point, off the surface, with its normal.
    using PatchOf = std::function<std::uint32_t(const Vec3& point, const Vec3& facing_normal)>;

    IrradianceMap(const RayScene& scene, float patch_size_m);
    ~IrradianceMap();
    IrradianceMap(IrradianceMap&&) noexcept;

    /// Counts a hit in a patch, at a point with its facing normal.
    void add_hit(std::uint32_t patch, std::uint32_t triangle, const Vec3& point,
                 const Vec3& facing_normal);

    /// Ends counting.
    void finish(std::span<const float> area_m2, const PatchOf& patch_of);

    /// Irradiance around a point of a patch relative to the mean of the patch; 1 in patches whose
    /// parts do not differ significantly.
    float relative(std::uint32_t patch, std::uint32_t triangle, const Vec3& point,
                   const Vec3& facing_normal) const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
