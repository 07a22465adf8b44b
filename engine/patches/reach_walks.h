#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// The static surfaces that random walks hit, by which SoundReach marks patches. Walks do not
/// depend on the grid: grids of several sizes share them. [propagation thread]
class ReachWalks {
 public:
    /// The end of a segment at a static surface.
    struct End {
        std::uint32_t triangle = 0;
        bool back = false;      ///< the side to which the triangle's normal does not point
        Vec3 point{0};          ///< just above this side
        float farthest_m = -1;  ///< largest distance of the walk's earlier reflections from its
                                ///< start, -1 without any
    };

    /// Walks from `inside`, at the present positions of all objects and with the present materials.
    ReachWalks(const RayScene& scene, std::span<const Vec3> inside, std::uint64_t seed);

    static constexpr int kRounds = 12;

    /// The ends of a round, 0 to kRounds - 1; traced when it is first asked for.
    std::span<const End> round(int number);

    /// The points from which walks start.
    std::span<const Vec3> inside() const { return inside_; }

    /// Rounds that have been traced.
    std::size_t traced() const { return rounds_.size(); }

    /// The unit normal of the side of an end.
    Vec3 normal(const End& end) const {
        const Vec3& normal = scene_.surface(end.triangle).normal;
        return end.back ? -normal : normal;
    }

 private:
    const RayScene& scene_;
    std::vector<Vec3> inside_;
    std::uint64_t seed_;
    std::vector<std::vector<End>> rounds_;
};

}  // namespace aula
