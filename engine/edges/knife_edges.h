#pragma once

#include <span>

#include "engine/edges/wedge_integral.h"

namespace aula {

/// An edge that a path passes closely: a half plane across it, below the path.
struct KnifeEdge {
    double at_m = 0;         ///< length of the path from the source, above 0 and below its length
    double turn_rad = 0;     ///< by which the path bends around the edge, at least 0
    double clearance_m = 0;  ///< of the path above the edge, at least 0; 0 where it bends
};

/// The pressure behind parallel knife edges of a path, relative to free field over the path: the
/// Fresnel-Kirchhoff integral over the heights of all edges (Vogler 1982), for small turns. The
/// edges are in ascending order. N edges at equal distances that a straight path touches leave
/// 1 / (N + 1). [several threads]
ComplexBands knife_edges(std::span<const KnifeEdge> edges, double length_m,
                         const WedgeIntegral& integral);

}  // namespace aula
