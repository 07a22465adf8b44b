#pragma once

#include "engine/base/tolerances.h"
#include "engine/edges/diffraction_edge.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// The part of a path that passes closely around an edge, off its faces and its ends.
class EdgePassage {
 public:
    EdgePassage(const DiffractionEdge& edge, double along_m, double from_rad, double to_rad);

    /// A point around the edge: share 0 where the path arrives, 1 where it leaves.
    Vec3 point(double share, double radius_m = kRadius_m) const;

    /// Whether no surface lies between the points at a radius. Such a surface closes the open
    /// angle, as the leaf of a shut door in the plane of its wall.
    bool is_free(const RayScene& scene, double radius_m = kRadius_m) const;

    /// The free width beside the edge relative to kNarrow_m, at most 1, 0 at a blocked edge. A
    /// width of `most_m` counts as wide.
    double opening(const RayScene& scene, double most_m) const;

    /// Of the points about the edge. Rays to them, shortened by kOffset_m, still leave its faces;
    /// within kSame_m there is no other edge.
    static constexpr double kRadius_m = tolerances::kSame_m / 2;
    static_assert(kRadius_m > 2 * double{tolerances::kOffset_m});

    /// Openings are narrow below this width, see EdgePaths::field.
    static constexpr double kNarrow_m = DiffractionEdge::kNarrow_m;

    /// Of the points from an end of the edge, where the faces of other edges may begin kSame_m
    /// earlier. A choice: ten times as much.
    static constexpr double kFromEnd_m = 10 * tolerances::kSame_m;

 private:
    const DiffractionEdge& edge_;
    glm::dvec3 apex_;
    double from_rad_;
    double to_rad_;
};

}  // namespace aula
