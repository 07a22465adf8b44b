#include "engine/direct/reflected_edge_paths.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "engine/base/near_field.h"
#include "engine/base/tolerances.h"
#include "engine/direct/limits.h"
#include "engine/edges/edge_crossing.h"
#include "engine/edges/edge_field.h"
#include "engine/edges/edge_passage.h"

namespace aula {

namespace {

using Point = glm::dvec3;

// Merged triangles are up to tolerances::kSame_m from their plane.
constexpr double kBesidePlane_m = tolerances::kApart_m;

/// Second extent of the bounds of a plane. A choice: the first Fresnel zone of a reflection 1 m
/// away on both sides is as wide at 1 kHz, and smaller planes are many.
constexpr double kLeastPlane_m = 0.5;

/// Of estimates relative to all other paths. A choice: 0.004 dB of the energy each. Paths are tried
/// by descending estimate, and a lower bound tries more.
constexpr double kWeakestReflected_db = -30;

// The reflections of a path as bits, see EdgePath.
constexpr unsigned kBefore = 1;
constexpr unsigned kAfter = 2;

/// Where the straight line from the image of a point to another one crosses the plane.
Point crossing(const ScenePlanes::Plane& plane, const Point& image, const Point& point) {
    const double there_m = plane.distance_m(image);
    const double here_m = plane.distance_m(point);
    return point + (image - point) * (here_m / (here_m - there_m));
}

double distance_m(const DiffractionEdge& edge, const Point& point) {
    const double along_m = std::clamp(glm::dot(point - edge.start, edge.axis), 0.0, edge.length_m);
    return glm::distance(point, edge.point(along_m));
}

/// The length over the point of a plane's bounds that is nearest to the reflection point; none if
/// the plane lies between source and listener, or is too small.
std::optional<double> length_over(const ScenePlanes::Plane& plane, const Point& source,
                                  const Point& listener) {
    const double source_m = plane.distance_m(source);
    const double listener_m = plane.distance_m(listener);
    if (!plane.reflects || plane.is_facet() || source_m * listener_m <= 0 ||
        std::min(std::abs(source_m), std::abs(listener_m)) < kBesidePlane_m) {
        return {};
    }
    const Point low(plane.bounds.min);
    const Point high(plane.bounds.max);
    const Point size = high - low;
    const double middle_m = size.x + size.y + size.z - std::min({size.x, size.y, size.z}) -
                            std::max({size.x, size.y, size.z});
    if (middle_m < kLeastPlane_m) return {};
    const Point nearest = glm::clamp(crossing(plane, plane.mirror(source), listener), low, high);
    return glm::distance(source, nearest) + glm::distance(nearest, listener);
}

}  // namespace

/// A path between the images of source and listener over an edge.
struct ReflectedEdgePaths::Candidate : EdgeCrossing {
    std::uint32_t plane = 0;
    std::uint32_t edge = 0;
    unsigned sides = 0;  ///< kBefore and kAfter
    Point source_image{0};
    Point listener_image{0};
    double level_db = 0;  ///< estimated
};

ReflectedEdgePaths::ReflectedEdgePaths(const RayScene& scene, const SceneEdges& edges,
                                       double speed_of_sound_m_s)
    : scene_(scene), edges_(edges), integral_(speed_of_sound_m_s) {}

void ReflectedEdgePaths::select_planes(const Point& source, const Point& listener,
                                       const ScenePlanes& planes, bool has_moved,
                                       PairReflections& memory) const {
    if (memory.has_planes && !has_moved &&
        glm::distance(source, memory.selected_source) < limits::kSelectAnew_m &&
        glm::distance(listener, memory.selected_listener) < limits::kSelectAnew_m) {
        return;
    }
    memory.has_planes = true;
    memory.selected_source = source;
    memory.selected_listener = listener;
    std::vector<std::pair<double, std::uint32_t>> by_length;
    for (std::uint32_t p = 0; p < planes.count(); ++p) {
        if (const auto length_m = length_over(planes[p], source, listener)) {
            by_length.emplace_back(*length_m, p);
        }
    }
    const std::size_t count = std::min(by_length.size(), kMaxPlanes);
    std::partial_sort(by_length.begin(), by_length.begin() + static_cast<std::ptrdiff_t>(count),
                      by_length.end());
    memory.planes.clear();
    for (std::size_t i = 0; i < count; ++i) memory.planes.push_back(by_length[i].second);
}

/// By descending level.
std::vector<ReflectedEdgePaths::Candidate> ReflectedEdgePaths::candidates(
    const Point& source, const Point& listener, const ScenePlanes& planes, bool is_twice,
    const PairReflections& memory) const {
    std::vector<Candidate> found;
    for (const std::uint32_t p : memory.planes) {
        const ScenePlanes::Plane& plane = planes[p];
        const Point source_image = plane.mirror(source);
        const Point listener_image = plane.mirror(listener);
        const double side = plane.distance_m(source) < 0 ? -1 : 1;
        for (const EdgePath& bent : memory.bent) {
            const DiffractionEdge& edge = edges_[bent.edges[0]];
            if (planes.of_triangle(edge.triangles[0]) == p ||
                planes.of_triangle(edge.triangles[1]) == p || edge.is_curved) {
                continue;
            }
            for (unsigned sides = kBefore; sides <= (is_twice ? kBefore | kAfter : kAfter);
                 ++sides) {
                const Point& from = (sides & kBefore) != 0 ? source_image : source;
                const Point& to = (sides & kAfter) != 0 ? listener_image : listener;
                const WedgePoint at_source = edge.coordinates(from);
                const WedgePoint at_listener = edge.coordinates(to);
                if (std::max(at_source.angle_rad, at_listener.angle_rad) > edge.open_angle_rad) {
                    continue;
                }
                const auto path = EdgeCrossing::over(edge, from, to, at_source, at_listener);
                if (!path || path->detour_m >= limits::longest_detour_m(path->is_lit) ||
                    side * plane.distance_m(edge.point(path->along_m)) < 0) {
                    continue;
                }
                const double loss = limits::half_plane_loss(path->detour_m, integral_);
                found.push_back({*path, p, bent.edges[0], sides, from, to,
                                 -20 * std::log10(loss * path->length_m)});
            }
        }
    }
    std::stable_sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
        return a.level_db > b.level_db;
    });
    return found;
}

/// The triangle of the plane at the reflection point between an end of the path and a point beside
/// the edge; none if there is no surface, or if another one blocks the path.
std::optional<std::uint32_t> ReflectedEdgePaths::reflect(const Point& end, const Vec3& beside_edge,
                                                         const ScenePlanes& planes,
                                                         std::uint32_t plane,
                                                         const Point& reflection_point) const {
    const Point offset = reflection_point - end;
    const double length_m = glm::length(offset);
    if (!(length_m > kBesidePlane_m)) return {};
    const double cosine = std::abs(glm::dot(planes[plane].normal, offset)) / length_m;
    const double beyond_m = kBesidePlane_m / std::max(cosine, 1e-3);
    const Ray ray{Vec3(end), Vec3(offset / length_m), static_cast<float>(length_m + beyond_m)};
    Hit hit;
    scene_.intersect(std::span(&ray, 1), std::span(&hit, 1));
    if (!hit.any() || planes.of_triangle(hit.triangle) != plane ||
        double{hit.distance_m} < length_m - beyond_m ||
        !scene_.visible(scene_.point(hit, ray.direction), beside_edge)) {
        return {};
    }
    return hit.triangle;
}

/// The edges near source and listener that bound the faces of the selected planes.
ReflectedEdgePaths::Outlines ReflectedEdgePaths::outlines_of(const ScenePlanes& planes,
                                                             const PairMemory& memory) const {
    const std::vector<std::uint32_t>& selected = memory.reflections.planes;
    Outlines outlines;
    for (const NearEdges::Edge& edge : memory.near.all()) {
        for (const std::uint32_t triangle : edges_[edge.index].triangles) {
            const std::uint32_t plane = planes.of_triangle(triangle);
            if (std::find(selected.begin(), selected.end(), plane) != selected.end()) {
                outlines.emplace_back(plane, edge.index);
            }
        }
    }
    return outlines;
}

/// The share of the pressure that a plane reflects at a point near its free edges: 1 where the
/// first Fresnel zone of radius sqrt(lambda d1 d2 / (d1 + d2)) is within the plane, 0 at an edge.
std::array<double, kBandCount> ReflectedEdgePaths::coverage(const Candidate& c, const Point& end,
                                                            const Point& reflection_point,
                                                            const Outlines& outlines) const {
    double free_m = 1e9;
    for (const auto& [plane, edge] : outlines) {
        if (plane == c.plane) free_m = std::min(free_m, distance_m(edges_[edge], reflection_point));
    }
    const double before_m = glm::distance(end, reflection_point);
    const double after_m = glm::distance(reflection_point, edges_[c.edge].point(c.along_m));
    std::array<double, kBandCount> share;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double zone_m = std::sqrt(2 * std::numbers::pi / integral_.wave_number_per_m(b) *
                                        before_m * after_m / (before_m + after_m));
        share[b] = zone_m > 0 ? smooth_step(free_m / zone_m) : 1;
    }
    return share;
}

std::vector<ReflectedEdgePath> ReflectedEdgePaths::find(const Point& source, const Point& listener,
                                                        const ScenePlanes& planes, bool is_twice,
                                                        const OrientedDirectivity& directivity,
                                                        const Bands& attenuation_per_m,
                                                        const Bands& total, bool has_moved,
                                                        PairMemory& memory) const {
    if (memory.reflections.bent.empty()) return {};
    select_planes(source, listener, planes, has_moved, memory.reflections);
    const double total_db =
        10 * std::log10(std::max(1e-30, 4 * std::numbers::pi * double{total[limits::kEstimated]}));
    double threshold_db = total_db + kWeakestReflected_db;
    struct Free {
        Candidate candidate;
        double opening = 0;
        std::array<Point, 2> reflection_points{};
        std::array<std::uint32_t, 2> triangles{};
    };
    std::vector<Free> free;
    std::size_t tries = 0;
    for (const Candidate& c : candidates(source, listener, planes, is_twice, memory.reflections)) {
        if (c.level_db <= threshold_db || ++tries > 4 * kMax) break;
        const DiffractionEdge& edge = edges_[c.edge];
        const EdgePassage passage(edge, c.along_m, c.source.angle_rad, c.listener.angle_rad);
        const Point apex = edge.point(c.along_m);
        Free path{.candidate = c};
        bool is_free = true;
        const std::array<std::pair<const Point&, const Point&>, 2> ends{
            {{source, c.source_image}, {listener, c.listener_image}}};
        for (std::size_t i = 0; i < 2 && is_free; ++i) {
            const auto& [end, image] = ends[i];
            const Vec3 beside_edge = passage.point(static_cast<double>(i));
            if ((c.sides & (i == 0 ? kBefore : kAfter)) == 0) {
                is_free = scene_.visible(Vec3(end), beside_edge);
                continue;
            }
            path.reflection_points[i] = crossing(planes[c.plane], image, apex);
            const auto triangle =
                reflect(end, beside_edge, planes, c.plane, path.reflection_points[i]);
            is_free = triangle.has_value();
            path.triangles[i] = triangle.value_or(0);
        }
        if (!is_free) continue;
        path.opening = passage.opening(scene_, std::min(c.source.radius_m, c.listener.radius_m));
        if (!(path.opening > 0)) continue;
        if (free.size() == kMax) {
            threshold_db = c.level_db;
            break;
        }
        free.push_back(path);
    }

    std::vector<ReflectedEdgePath> paths;
    const Outlines outlines = free.empty() ? Outlines{} : outlines_of(planes, memory);
    for (const auto& [c, opening, reflection_points, triangles] : free) {
        const DiffractionEdge& edge = edges_[c.edge];
        const Point apex = edge.point(c.along_m);
        ReflectedEdgePath found{.plane = c.plane};
        EdgePath& path = found.path;
        path.edges = {c.edge};
        path.reflections = c.sides;
        path.length_m = c.length_m;
        const bool is_before = (c.sides & kBefore) != 0;
        const bool is_after = (c.sides & kAfter) != 0;
        path.departure = near_direction((is_before ? reflection_points[0] : apex) - source);
        path.direction = near_direction((is_after ? reflection_points[1] : apex) - listener);
        if (is_before) path.apexes.emplace_back(reflection_points[0]);
        path.apexes.emplace_back(apex);
        if (is_after) path.apexes.emplace_back(reflection_points[1]);
        const double beside = c.share_beside(opening);
        path.field =
            edge_field(integral_, scene_, edge, c.source, c.listener, {.share = opening / beside});

        const double weight = beside *
                              limits::before_limit(c.detour_m, limits::longest_detour_m(c.is_lit)) *
                              limits::above_threshold(c.level_db - threshold_db);
        const Bands factor = directivity.factor(path.departure);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            path.field[b] *=
                weight * air_loss(c.length_m, attenuation_per_m, b) * std::sqrt(double{factor[b]});
        }
        for (std::size_t i = 0; i < 2; ++i) {
            if ((c.sides & (i == 0 ? kBefore : kAfter)) == 0) continue;
            found.triangle = triangles[i];
            const Material& material = scene_.material(scene_.triangle(triangles[i]));
            const auto share =
                coverage(c, i == 0 ? source : listener, reflection_points[i], outlines);
            for (std::size_t b = 0; b < kBandCount; ++b) {
                path.field[b] *= share[b] * mirrored_pressure(material, b);
            }
        }
        if (c.sides != (kBefore | kAfter) && c.is_at_boundary()) found.is_image_audible = c.is_lit;
        paths.push_back(std::move(found));
    }
    return paths;
}

}  // namespace aula
