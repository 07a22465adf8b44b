#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/rays/ray_scene.h"
#include "engine/rays/scene_planes.h"
#include "engine/response/energy_response.h"

namespace aula {

/// Direct sound and image sources up to a specular order. Candidates are sequences of the scene's
/// planes: all of them up to the order at which they become many, beyond that those that specular
/// chains of rays from the listeners meet, kept while they stay valid. Every candidate is validated
/// exactly: each reflection point on a face of its plane, each segment unobstructed. The
/// estimators' rays count the sequences that are not candidates (is_candidate), so that every path
/// is counted once. Candidates depend on no random number of an estimator: what is left to the rays
/// stays unbiased. The same calls give the same paths. [propagation thread]
class SpecularPaths {
 public:
    /// `order` 0: direct sound only. `radius_m` is that of the spheres in which rays are detected.
    SpecularPaths(const RayScene& scene, int order, float radius_m, std::uint64_t seed);

    /// Forgets all candidates that rays have met.
    void restart(std::uint64_t seed);

    /// Brings the planes up to date after RayScene::move.
    void scene_moved();

    /// Traces chains from a listener and adds the sequences of planes they meet to the candidates.
    /// Call once for each listener and frame, before find().
    void discover(const Vec3& listener, std::uint64_t frame);

    /// Highest order of the image sources.
    int order() const { return static_cast<int>(order_); }

    /// Highest order of which every sequence is a candidate, at most order().
    int listed_order() const { return static_cast<int>(listed_order_); }

    /// The plane that a triangle lies in, of a PlaneSequence.
    std::uint32_t plane_of_triangle(std::uint32_t triangle) const {
        return planes_.of_triangle(triangle);
    }

    /// True if find() tries the sequence of planes with this key, of an order above
    /// listed_order(). False for key 0. [several threads at once]
    bool is_candidate(std::uint64_t sequence_key) const {
        return sequence_key != 0 && discovered_.find(sequence_key) != discovered_.end();
    }

    /// The valid paths from a source to a listener, ascending in length: the direct sound if
    /// `direct` and visible, then reflections: energy prod (1 - s)(1 - alpha) / (4 pi d^2) times
    /// exp(-attenuation d) in each band, d at least 0.1 m. A source or listener within 0.5 mm of a
    /// plane has no reflection in it. [several threads at once]
    std::vector<SpecularPath> find(const Vec3& source, const Vec3& listener, bool direct,
                                   const Bands& attenuation_per_m) const;

 private:
    using Sequence = std::vector<std::uint32_t>;  ///< planes from the listener to the source

    /// A sequence that rays have met, and the frame up to which it is of use: one more than that
    /// in which it was last near to a path.
    struct Discovered {
        Discovered(Sequence planes, std::uint64_t frame)
            : sequence(std::move(planes)), last_frame(frame) {}
        Sequence sequence;
        mutable std::atomic<std::uint64_t> last_frame;
    };

    void list_sequences();
    void evict();
    struct Workspace;
    std::optional<SpecularPath> path_along(const Sequence& sequence, const Vec3& source,
                                           const Vec3& listener, const Bands& attenuation_per_m,
                                           Workspace& work) const;

    const RayScene& scene_;
    std::size_t order_;
    double radius_m_;
    std::uint64_t seed_;
    ScenePlanes planes_;
    std::size_t listed_order_ = 0;
    std::vector<Sequence> listed_;                              ///< all up to listed_order_
    std::unordered_map<std::uint64_t, Discovered> discovered_;  ///< by PlaneSequence::key
    std::uint64_t frame_ = 0;                                   ///< of the last discover()
};

}  // namespace aula
