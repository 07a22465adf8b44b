#pragma once

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

    static constexpr double kRadius_m = 5e-4;
    static constexpr double kNarrow_m = 0.05;
    static constexpr double kFromEnd_m = 0.01;  ///< of the points from an end of the edge

 private:
    const DiffractionEdge& edge_;
    glm::dvec3 apex_;
    double from_rad_;
    double to_rad_;
};

}  // namespace aula
