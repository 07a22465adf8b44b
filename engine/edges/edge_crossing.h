#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "engine/base/tolerances.h"
#include "engine/edges/diffraction_edge.h"
#include "engine/edges/wedge_integral.h"

namespace aula {

/// The shortest path between two points over one edge.
struct EdgeCrossing {
    WedgePoint source{};
    WedgePoint listener{};
    double apex_m = 0;    ///< on the line of the edge, also beyond its ends
    double along_m = 0;   ///< within the ends
    double length_m = 0;  ///< over that point
    double detour_m = 0;
    bool is_lit = false;  ///< the faces of the edge leave the straight line free

    /// None if both points are on the line of the edge. The coordinates are those of the points,
    /// whose angles may be on a side of a screen; see DiffractionEdge::coordinates.
    static std::optional<EdgeCrossing> over(const DiffractionEdge& edge, const glm::dvec3& source,
                                            const glm::dvec3& listener, const WedgePoint& at_source,
                                            const WedgePoint& at_listener);

    /// The share of the field beside an opening narrower than DiffractionEdge::kNarrow_m, of which
    /// `opening` is free. It is 1 where the straight line passes through the opening, whose other
    /// edge has the field that cancels this one, and `opening` where it passes beside it.
    double share_beside(double opening) const;

    /// Whether a straight line that passes the edge at an angle beyond a boundary of geometrical
    /// acoustics, between its ends, passes it so closely that a ray could contradict the angle.
    bool is_beside(double beyond_rad) const;

    /// Whether the straight line between the points does.
    bool is_at_boundary() const;

    /// The sides of the faces at an edge are within kSame_m of it.
    static constexpr double kBeside_m = tolerances::kSame_m;
};

}  // namespace aula
