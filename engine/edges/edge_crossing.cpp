#include "engine/edges/edge_crossing.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace aula {

std::optional<EdgeCrossing> EdgeCrossing::over(const DiffractionEdge& edge,
                                               const glm::dvec3& source, const glm::dvec3& listener,
                                               const WedgePoint& at_source,
                                               const WedgePoint& at_listener) {
    if (!(at_source.radius_m + at_listener.radius_m > 0)) return {};
    EdgeCrossing path{.source = at_source, .listener = at_listener};
    path.apex_m = aula::apex_m(at_source, at_listener);
    path.along_m = std::clamp(path.apex_m, 0.0, edge.length_m);
    const glm::dvec3 apex = edge.point(path.along_m);
    path.length_m = glm::distance(source, apex) + glm::distance(apex, listener);
    path.detour_m = std::max(0.0, path.length_m - glm::distance(source, listener));
    path.is_lit = WedgeIntegral::is_lit(at_source, at_listener);
    return path;
}

bool EdgeCrossing::is_beside(double beyond_rad) const {
    return apex_m == along_m && std::abs(beyond_rad) * source.radius_m * listener.radius_m <
                                    kBeside_m * (source.radius_m + listener.radius_m);
}

bool EdgeCrossing::is_at_boundary() const {
    return is_beside(std::numbers::pi - std::abs(listener.angle_rad - source.angle_rad));
}

}  // namespace aula
