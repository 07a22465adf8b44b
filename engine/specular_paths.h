#pragma once

#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "engine/energy_response.h"
#include "engine/ray_scene.h"

namespace aula {

/// Direct sound and image sources up to a specular order. Coplanar triangles are merged to planes;
/// candidates are sequences of planes, all of them where they are few, else found by specular
/// chains of rays from the listener and kept while they stay valid; every candidate is validated
/// exactly (each reflection point on a face of its plane, each leg unobstructed).
/// [propagation thread]
class SpecularPaths {
   public:
    /// `order` 0: direct sound only.
    SpecularPaths(const RayScene& scene, int order, std::uint64_t seed);

    /// Brings the planes up to date after RayScene::move.
    void scene_moved();

    /// Traces chains from a listener and adds the sequences of planes they meet to the candidates.
    /// Call once for each listener and frame.
    void discover(const Vec3& listener, std::uint64_t frame);

    /// The valid paths from a source to a listener, ascending in length: the direct sound if
    /// `direct` and visible, then reflections: energy prod (1 - s)(1 - alpha) / (4 pi d^2) times
    /// exp(-attenuation d) in each band.
    std::vector<SpecularPath> find(const Vec3& source, const Vec3& listener, bool direct,
                                   const Bands& attenuation_per_m) const;

   private:
    using Sequence = std::vector<std::uint32_t>;
    struct Plane {
        Vec3 normal;
        float offset_m;  ///< dot(normal, x) on the plane
    };
    void build_planes();

    const RayScene& scene_;
    int order_;
    std::uint64_t seed_;
    std::vector<Plane> planes_;
    std::vector<std::uint32_t> plane_of_triangle_;
    std::set<Sequence> candidates_;
    bool exhaustive_ = false;
};

}  // namespace aula
