#include "apps/aula/room_positions.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>

#include "apps/output/formatted.h"
#include "engine/rays/nudge_off_surface.h"
#include "engine/rays/room_survey.h"

namespace aula {

namespace {

/// Adds positions along a path, 0.5 m apart, or farther apart on paths longer than 128 m.
void add_along(const std::string& name, const Trajectory& path,
               std::vector<NamedPosition>& positions) {
    constexpr double kMaxPositions = 256;
    double length_m = 0;
    const auto step_m = [&](std::size_t i) {
        return double{
            glm::distance(path.points[i - 1].pose.position, path.points[i].pose.position)};
    };
    for (std::size_t i = 1; i < path.points.size(); ++i) length_m += step_m(i);
    const double apart_m = std::max(0.5, length_m / kMaxPositions);
    double next_m = apart_m;
    double passed_m = 0;
    for (std::size_t i = 1; i < path.points.size(); ++i) {
        for (; next_m <= passed_m + step_m(i); next_m += apart_m) {
            const double share = (next_m - passed_m) / step_m(i);
            const double time_s =
                std::lerp(path.points[i - 1].time_s, path.points[i].time_s, share);
            positions.push_back({name, path.at(time_s).position, time_s});
        }
        passed_m += step_m(i);
    }
}

}  // namespace

std::vector<NamedPosition> initial_positions(const Scene& scene) {
    std::vector<NamedPosition> positions{{kListener, scene.listener.pose_at(0).position, {}}};
    for (const Source& source : scene.sources)
        positions.push_back({"the source \"" + source.name + "\"", source.position_at(0), {}});
    return positions;
}

std::vector<NamedPosition> positions_along_paths(const Scene& scene) {
    std::vector<NamedPosition> positions = initial_positions(scene);
    if (scene.listener.path) add_along(kListener, *scene.listener.path, positions);
    for (const Source& source : scene.sources)
        if (source.path) add_along("the source \"" + source.name + "\"", *source.path, positions);
    return positions;
}

std::vector<Vec3> points_of(const std::vector<NamedPosition>& positions) {
    std::vector<Vec3> points;
    for (const NamedPosition& item : positions) points.push_back(item.position);
    return points;
}

SortedPositions sort_positions(const RayScene& rays, std::vector<NamedPosition> positions) {
    // As the propagation does: half of the walks from a point on a surface would leave the room.
    for (NamedPosition& item : positions) item.position = nudge_off_surface(rays, item.position);
    const std::vector<char> outside = outside_room(rays, points_of(positions), kRoomSeed);
    SortedPositions sorted;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        (outside[i] ? sorted.outside : sorted.inside).push_back(positions[i]);
    }
    return sorted;
}

std::string place_text(const NamedPosition& item) {
    const Vec3& p = item.position;
    return (item.time_s ? formatted(" after %.1f s", *item.time_s) : "") +
           formatted(", at (%g, %g, %g)", double{p.x}, double{p.y}, double{p.z});
}

std::string outside_text(const NamedPosition& item) {
    return item.name + " is outside the room" + place_text(item);
}

std::vector<NamedPosition> cut_off(const RayScene& rays, const std::vector<NamedPosition>& places,
                                   const std::vector<NamedPosition>& others) {
    const std::vector<char> reached = connected(rays, points_of(others), points_of(places),
                                                kRoomSeed, MovableObjects::are_passed);
    std::vector<NamedPosition> missed;
    for (std::size_t i = 0; i < places.size(); ++i)
        if (!reached[i]) missed.push_back(places[i]);
    return missed;
}

}  // namespace aula
