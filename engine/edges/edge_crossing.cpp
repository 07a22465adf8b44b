#include "engine/edges/edge_crossing.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "engine/edges/edge_field.h"

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

double EdgeCrossing::share_beside(double opening) const {
    if (opening == 1) return 1;
    // At the distance h the detour is h^2 (1 / a + 1 / b) / 2, with the lengths a and b.
    const double a_m = std::hypot(source.radius_m, source.along_m - along_m);
    const double off_m = std::sqrt(2 * detour_m * a_m * std::max(0.0, length_m - a_m) / length_m);
    // A line through the widest narrow opening is within kNarrow_m; from there it fades over as
    // much.
    return 1 - (1 - opening) * smooth_step(off_m / DiffractionEdge::kNarrow_m - 1);
}

bool EdgeCrossing::is_beside(double beyond_rad) const {
    return apex_m == along_m && std::abs(beyond_rad) * source.radius_m * listener.radius_m <
                                    kBeside_m * (source.radius_m + listener.radius_m);
}

bool EdgeCrossing::is_at_boundary() const {
    return is_beside(std::numbers::pi - std::abs(listener.angle_rad - source.angle_rad));
}

}  // namespace aula
