#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/rays/ray_lanes.h"

namespace aula {

/// Nearest hits among so few triangles that testing each ray with every one of them is faster than
/// a hierarchy: plain rooms. Both sides, and without cracks: two triangles see a shared edge on the
/// same side of a ray to the bit. [propagation thread]
class BruteForceIntersector {
 public:
    /// More than these are better left to a hierarchy.
    static constexpr std::size_t kMost = 48;

    using Vertices = std::array<Vec3, 3>;

    BruteForceIntersector() = default;
    /// At most kMost; degenerate ones are never hit.
    explicit BruteForceIntersector(std::span<const Vertices> triangles);

    /// Nearest hit of the first `count` lanes beyond distance 0.
    void intersect(const RayLanes& rays, std::size_t count, HitLanes& hits) const;

    /// A triangle as its plane and the lines along its edges, from the middle of all.
    struct Lines {
        struct Edge {
            Vec3 direction{0};
            Vec3 moment{0};  ///< start x end
        };
        std::array<Edge, 3> edges;  ///< [k] opposite vertex k
        Vec3 normal{0};             ///< not of unit length
        float offset = 0;           ///< normal . p for points p of the plane
    };

 private:
    Vec3 middle_{0};
    std::vector<Lines> triangles_;
};

}  // namespace aula
