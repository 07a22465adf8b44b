#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/rays/ray_lanes.h"

namespace aula {

/// Nearest hits by testing each ray against every triangle, which is faster than a hierarchy for
/// the few triangles of a plain room. Both sides of a triangle are hit. There are no cracks: two
/// triangles compute bit-identical signs for a shared edge. [propagation thread]
class BruteForceIntersector {
 public:
    /// Above this number a hierarchy is faster.
    static constexpr std::size_t kMax = 48;

    using Vertices = std::array<Vec3, 3>;

    BruteForceIntersector() = default;
    /// At most kMax triangles; degenerate ones are never hit.
    explicit BruteForceIntersector(std::span<const Vertices> triangles);

    /// Nearest hit of the first `count` lanes beyond distance 0.
    void intersect(const RayLanes& rays, std::size_t count, HitLanes& hits) const;

    /// A triangle as its plane and the Pluecker lines of its edges, relative to the triangles'
    /// centre.
    struct Lines {
        struct Edge {
            Vec3 direction{0};
            Vec3 moment{0};  ///< start x end
        };
        std::array<Edge, 3> edges;  ///< [k] opposite vertex k
        Vec3 normal{0};             ///< not normalised
        float offset = 0;           ///< normal . p for points p of the plane
    };

 private:
    Vec3 middle_{0};
    std::vector<Lines> triangles_;
};

}  // namespace aula
