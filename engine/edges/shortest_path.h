#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "engine/edges/diffraction_edge.h"

namespace aula {

/// The shortest path between two points that touches edges in a given order.
struct ShortestPath {
    std::vector<double> along_m;  ///< [edge] where the path touches it, from its start to its end
    double length_m = 0;
};

/// Minimises the length over the points of the edges, a convex function. One edge has a closed
/// form; for more, Newton's method with the tridiagonal Hessian holds points at the ends of their
/// edges while the length would decrease beyond them.
ShortestPath shortest_path(const glm::dvec3& from, std::span<const DiffractionEdge* const> edges,
                           const glm::dvec3& to);

}  // namespace aula
