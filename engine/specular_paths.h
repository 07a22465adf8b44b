#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "engine/energy_response.h"
#include "engine/ray_scene.h"
#include "engine/scene_planes.h"

namespace aula {

/// Direct sound and image sources up to a specular order. Candidates are sequences of the scene's
/// planes: all of them up to the order at which they become many, beyond that those that specular
/// chains of rays from the listeners meet, kept while they stay valid. Every candidate is validated
/// exactly: each reflection point on a face of its plane, each leg unobstructed. The same calls
/// give the same paths. [propagation thread]
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
    /// exp(-attenuation d) in each band, d at least 0.1 m. A source or listener within 0.5 mm of a
    /// plane has no reflection in it. [several threads at once]
    std::vector<SpecularPath> find(const Vec3& source, const Vec3& listener, bool direct,
                                   const Bands& attenuation_per_m) const;

 private:
    using Sequence = std::vector<std::uint32_t>;  ///< planes from the listener to the source

    /// A sequence that rays have met, and when it was last a path, in calls of discover().
    struct Discovered {
        explicit Discovered(std::uint64_t now) : last_valid(now) {}
        mutable std::atomic<std::uint64_t> last_valid;
    };

    void list_sequences();
    void forget_the_oldest();
    struct Workspace;
    std::optional<SpecularPath> path_along(const Sequence& sequence, const Vec3& source,
                                           const Vec3& listener, const Bands& attenuation_per_m,
                                           Workspace& work) const;

    const RayScene& scene_;
    std::size_t order_;
    std::uint64_t seed_;
    ScenePlanes planes_;
    std::size_t listed_order_ = 0;
    std::vector<Sequence> listed_;  ///< all up to listed_order_
    std::map<Sequence, Discovered> discovered_;
    std::uint64_t discoveries_ = 0;
};

}  // namespace aula
