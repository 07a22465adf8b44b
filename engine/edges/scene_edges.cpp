#include "engine/edges/scene_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <map>
#include <numbers>

#include "engine/base/tolerances.h"
#include "engine/edges/edge_finder.h"

namespace aula {

SceneEdges::SceneEdges(const RayScene& scene) : scene_(scene) {
    find_small();
    std::vector<std::uint32_t> fixed;
    std::map<std::uint32_t, std::vector<std::uint32_t>> movable;  // object -> triangles
    for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
        if (is_small(t)) continue;
        const RayScene::Triangle& triangle = scene.triangle(t);
        (scene.moves(triangle) ? movable[triangle.object] : fixed).push_back(t);
    }
    edges_ = find_edges(scene, fixed);
    std::erase_if(edges_, [&](const DiffractionEdge& edge) { return is_buried(edge); });
    for (const auto& [_, triangles] : movable) {
        MovingEdges object;
        object.reference = *std::max_element(
            triangles.begin(), triangles.end(), [&](std::uint32_t a, std::uint32_t b) {
                return scene.triangle(a).area_m2() < scene.triangle(b).area_m2();
            });
        const Frame frame = frame_of(object.reference);
        const glm::dmat3 to_local = glm::transpose(frame.axes);
        object.local = find_edges(scene, triangles);
        object.first_edge = static_cast<std::uint32_t>(edges_.size());
        edges_.insert(edges_.end(), object.local.begin(), object.local.end());
        object.end_edge = static_cast<std::uint32_t>(edges_.size());
        for (DiffractionEdge& edge : object.local) {
            edge.start = to_local * (edge.start - frame.origin);
            edge.axis = to_local * edge.axis;
            edge.first_face = to_local * edge.first_face;
        }
        if (!object.local.empty()) moving_.push_back(std::move(object));
    }
    scene_moved();
}

bool overlap(const Bounds& a, const Bounds& b, float margin_m) {
    return glm::all(glm::lessThanEqual(a.min, b.max + margin_m)) &&
           glm::all(glm::lessThanEqual(b.min, a.max + margin_m));
}

/// Fixed objects that touch each other count as one: the bricks of a wall are not small.
void SceneEdges::find_small() {
    constexpr float kTouch_m = 0.01F;  // a joint of mortar
    std::vector<Bounds> bounds;
    std::vector<char> moves;
    for (std::uint32_t t = 0; t < scene_.triangle_count(); ++t) {
        const RayScene::Triangle& triangle = scene_.triangle(t);
        if (triangle.object >= bounds.size()) {
            bounds.resize(triangle.object + 1);
            moves.resize(bounds.size());
        }
        bounds[triangle.object].add(triangle.vertices);
        moves[triangle.object] = scene_.moves(triangle) ? 1 : 0;
    }
    is_small_.resize(bounds.size());
    std::vector<std::uint32_t> small;
    for (std::uint32_t o = 0; o < bounds.size(); ++o) {
        is_small_[o] = bounds[o].diagonal_m() < kSmall_m ? 1 : 0;
        if (is_small_[o] != 0 && moves[o] == 0) small.push_back(o);
    }
    // Clusters of objects that touch each other, directly or by way of others.
    while (!small.empty()) {
        std::vector<std::uint32_t> cluster{small.back()};
        small.pop_back();
        Bounds all = bounds[cluster[0]];
        for (std::size_t i = 0; i < cluster.size(); ++i) {
            const auto others = std::partition(small.begin(), small.end(), [&](std::uint32_t o) {
                return !overlap(bounds[cluster[i]], bounds[o], kTouch_m);
            });
            for (auto o = others; o != small.end(); ++o) {
                all.add(bounds[*o].min);
                all.add(bounds[*o].max);
                cluster.push_back(*o);
            }
            small.erase(others, small.end());
        }
        if (all.diagonal_m() < kSmall_m) continue;
        for (const std::uint32_t o : cluster) is_small_[o] = 0;
    }
    has_small_ = std::find(is_small_.begin(), is_small_.end(), 1) != is_small_.end();
}

/// Whether no triangle lies between two points but those that `passes` names.
template <typename Passes>
bool SceneEdges::visible_past(const Vec3& from, const Vec3& to, const Passes& passes) const {
    const float distance_m = glm::distance(from, to);
    const Vec3 direction = (to - from) / distance_m;
    float passed_m = tolerances::kOffset_m;
    constexpr int kMaxFaces = 32;  // a ray through more is blocked
    for (int face = 0; face < kMaxFaces; ++face) {
        const float rest_m = distance_m - passed_m - tolerances::kOffset_m;
        if (rest_m <= 0) return true;
        const Ray ray{from + passed_m * direction, direction, rest_m};
        Hit hit;
        scene_.intersect_each({&ray, 1}, {&hit, 1});
        if (!hit.any()) return true;
        if (!passes(hit.triangle)) return false;
        passed_m += hit.distance_m + RayScene::offset_after(passed_m + hit.distance_m);
    }
    return false;
}

bool SceneEdges::visible(const Vec3& from, const Vec3& to) const {
    if (scene_.visible(from, to)) return true;
    return has_small_ && visible_past(from, to, [&](std::uint32_t t) { return is_small(t); });
}

bool SceneEdges::visible_along_face(const Vec3& from, const Vec3& to, const Vec3& normal) const {
    if (visible(from, to)) return true;
    // A face that bends outwards between two of its points is below its tangents at both.
    const float highest_m =
        glm::distance(from, to) / 2 * static_cast<float>(std::tan(tolerances::kOnFace_rad));
    const Vec3 above_from = from + highest_m * normal;
    const Vec3 above_to = to + highest_m * normal;
    return visible(from, above_from) && visible(above_from, above_to) && visible(above_to, to);
}

bool SceneEdges::is_covered(std::uint32_t edge, const glm::dvec3& point) const {
    if (moving_.empty() || edge >= moving_.front().first_edge) return false;
    const auto coincides = [&](const DiffractionEdge& other) {
        const WedgePoint at = other.beside(point);
        return at.radius_m < tolerances::kSame_m && at.along_m > 0 && at.along_m < other.length_m &&
               other.is_along(edges_[edge]);
    };
    constexpr auto kMargin_m = static_cast<float>(tolerances::kSame_m);
    return std::any_of(moving_.begin(), moving_.end(), [&](const MovingEdges& object) {
        return overlap(object.bounds, {Vec3(point), Vec3(point)}, kMargin_m) &&
               std::any_of(edges_.begin() + object.first_edge, edges_.begin() + object.end_edge,
                           coincides);
    });
}

void SceneEdges::scene_moved() {
    for (MovingEdges& object : moving_) follow(object);
}

void SceneEdges::follow(MovingEdges& object) {
    const Frame frame = frame_of(object.reference);
    object.bounds = {};
    for (std::uint32_t e = object.first_edge; e < object.end_edge; ++e) {
        const DiffractionEdge& local = object.local[e - object.first_edge];
        edges_[e].start = frame.origin + frame.axes * local.start;
        edges_[e].axis = frame.axes * local.axis;
        edges_[e].first_face = frame.axes * local.first_face;
        object.bounds.add(Vec3(edges_[e].start));
        object.bounds.add(Vec3(edges_[e].point(local.length_m)));
    }
}

SceneEdges::Frame SceneEdges::frame_of(std::uint32_t triangle) const {
    const auto& v = scene_.triangle(triangle).vertices;
    const glm::dvec3 origin(v[0]);
    const glm::dvec3 x = glm::normalize(glm::dvec3(v[1]) - origin);
    const glm::dvec3 z = glm::normalize(glm::cross(x, glm::dvec3(v[2]) - origin));
    return {origin, glm::dmat3(x, glm::cross(z, x), z)};
}

/// True if faces of other triangles pass through the open angle along the whole edge, as at the
/// foot of a wall on an undivided floor. Such faces leave no sector above pi. Short rays around the
/// edge meet them. Objects that move do not bury the edges of others: a door that is shut may open.
bool SceneEdges::is_buried(const DiffractionEdge& edge) const {
    constexpr std::array kPlaces{0.5, 0.1, 0.9};  // of the length, off the ends
    // Chords begin off the faces by more than they are shortened, and pass the edge farther than it
    // is off: 0.14 < sin(kMargin_rad), 0.69 < cos(kStep_rad / 2).
    constexpr double kRadius_m = 5 * tolerances::kSame_m;
    constexpr double kMargin_rad = 0.15;
    static_assert(0.14 * kRadius_m > double{tolerances::kOffset_m});
    static_assert(0.69 * kRadius_m > tolerances::kSame_m);
    constexpr double kStep_rad = 1.6;  // chords pass the edge at 0.7 of the radius
    const double span_rad = edge.open_angle_rad - 2 * kMargin_rad;
    const int steps = static_cast<int>(std::ceil(span_rad / kStep_rad));
    // A free edge may be drawn on a larger face, in whose plane the chords do not cross it. Beyond
    // the edge, by less than the tolerance of find_edges(), is then that face.
    const auto is_drawn_at = [&](const glm::dvec3& point) {
        constexpr double kBeyond_m = tolerances::kSame_m / 2;
        constexpr auto kAbove_m = static_cast<float>(tolerances::kSame_m);
        const Vec3 normal(edge.direction(std::numbers::pi / 2));
        const Vec3 beyond(point - kBeyond_m * edge.first_face);
        const Ray ray{beyond + kAbove_m * normal, -normal, 2 * kAbove_m};
        Hit hit;
        scene_.intersect_each({&ray, 1}, {&hit, 1});
        return hit.any() && scene_.coplanar_faces().is_covered(hit.triangle);
    };
    const auto moves = [&](std::uint32_t t) { return scene_.moves(scene_.triangle(t)); };
    return std::all_of(kPlaces.begin(), kPlaces.end(), [&](double place) {
        const glm::dvec3 centre = edge.point(place * edge.length_m);
        const auto around = [&](int step) {
            return Vec3(centre + kRadius_m * edge.direction(kMargin_rad + span_rad * step / steps));
        };
        for (int step = 0; step < steps; ++step) {
            if (!visible_past(around(step), around(step + 1), moves)) return true;
        }
        return edge.is_free() && is_drawn_at(centre);
    });
}

}  // namespace aula
