#include "engine/rays/room_survey.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <unordered_map>
#include <vector>

#include "aula/engine/room_acoustics.h"
#include "engine/base/sampling.h"
#include "engine/base/tolerances.h"
#include "engine/rays/follow_rays.h"
#include "engine/rays/wall_crossing.h"

namespace aula {

namespace {

// 65536 free paths. Their lengths have a standard deviation of 0.6 of the mean, which they give
// within 0.3 %.
constexpr int kSurveyPaths = 2048;
constexpr int kSurveyBounces = 32;

/// Limit of the mean number of pieces per segment of a path, as divided by moving objects. A path
/// that exceeds it ends.
constexpr int kMaxPieces = 4;

/// An offset from a surface that exceeds the rounding error at this position.
float offset_at(const Vec3& position) { return RayScene::offset_after(2 * glm::length(position)); }

/// The start of the segment after a hit: a point of the previous segment just above the surface. No
/// surface lies between that point and the previous segment's start, so that no walk leaves a room
/// at an edge or where surfaces intersect at an acute angle. An offset along the normal could do
/// so.
Vec3 start_after(const Vec3& begin, const Vec3& end, const Vec3& facing_normal) {
    const Vec3 back = begin - end;
    const float height_m = glm::dot(back, facing_normal);
    const float share = height_m > 0 ? std::min(0.5F, offset_at(end) / height_m) : 0.5F;
    return end + share * back;
}

struct Walk {
    Ray ray{};       ///< of the next piece of a segment
    Vec3 begin{0};   ///< of the segment, before it passed any object
    Hit passed{};    ///< the first hit that it passed
    Vec3 start{0};   ///< of the walk
    int pieces = 0;  ///< of all segments
    int reflections = 0;
    float farthest_m = -1;  ///< of them from the start
    RandomStream random{};
};

/// Index of the triangle side that a ray hits.
std::size_t side_of(const RayScene& scene, const Ray& ray, const Hit& hit) {
    const bool front = glm::dot(scene.surface(hit.triangle).normal, ray.direction) <= 0;
    return 2 * std::size_t{hit.triangle} + (front ? 1 : 0);
}

}  // namespace

void trace_random_walks(const RayScene& scene, std::span<const Vec3> inside,
                        const RandomWalks& walks,
                        const std::function<void(float, const Ray&, const Hit&)>& visit) {
    if (inside.empty()) return;
    std::vector<Walk> alive(static_cast<std::size_t>(walks.paths));
    const ScrambledSobol sobol(walks.seed);
    for (std::size_t i = 0; i < alive.size(); ++i) {
        Walk& walk = alive[i];
        walk.random = RandomStream(derive_seed(walks.seed, i));
        walk.ray = {inside[i % inside.size()],
                    uniform_direction(sobol.point(static_cast<std::uint32_t>(i)))};
        walk.begin = walk.start = walk.ray.origin;
    }
    std::vector<WallExit> exits;
    const auto meet = [&](Walk& walk, const Ray& ray, const Hit& met) {
        const Vec3& direction = ray.direction;
        if (walks.through_moving && met.any() && scene.moves(scene.triangle(met.triangle))) {
            const Vec3 through = scene.facing_normal(met, direction);
            walk.ray.origin = scene.point(met, direction) - 2 * tolerances::kOffset_m * through;
            if (!walk.passed.any()) walk.passed = met;
        } else {
            Hit hit = met.any() ? met : walk.passed;
            if (hit.any()) hit.distance_m = glm::distance(walk.begin, scene.point(hit, direction));
            visit(walk.farthest_m, {walk.begin, direction}, hit);
            if (!hit.any() || ++walk.reflections == walks.bounces) return false;
            Vec3 normal = scene.facing_normal(hit, direction);
            const Vec3 point = scene.point(hit, direction);
            walk.farthest_m = std::max(walk.farthest_m, glm::distance(point, walk.start));
            exits.clear();
            if (walks.through_walls && scene.transmits(scene.surface(hit.triangle).material) &&
                walk.random.uniform() < 0.5F) {
                const WallEntry entry{hit, point - 2 * tolerances::kOffset_m * normal, normal};
                find_wall_exits(scene, {&entry, 1}, exits);
            }
            if (!exits.empty() && exits[0].wall.transmission.max() > 0) {
                walk.begin = exits[0].point;
                normal = exits[0].normal;
            } else {
                walk.begin = start_after(walk.begin, point, normal);
            }
            walk.ray = {walk.begin, lambert_direction(normal, walk.random.uniform_2d())};
            walk.passed = {};
        }
        return ++walk.pieces < kMaxPieces * walks.bounces;
    };
    follow_rays(
        scene, alive, [](const Walk& walk) { return walk.ray; }, meet);
}

RoomSurvey survey_room(const RayScene& scene, std::span<const Vec3> inside, std::uint64_t seed) {
    double length_m = 0;
    std::size_t hits = 0;
    std::size_t escaped = 0;
    std::array<double, kBandCount> absorption{};
    const RandomWalks walks{.paths = kSurveyPaths, .bounces = kSurveyBounces, .seed = seed};
    trace_random_walks(scene, inside, walks, [&](float, const Ray&, const Hit& hit) {
        if (!hit.any()) {
            ++escaped;
            return;
        }
        ++hits;
        length_m += double{hit.distance_m};
        const Material& material = scene.material(scene.triangle(hit.triangle));
        for (std::size_t b = 0; b < kBandCount; ++b) {
            absorption[b] += double{material.absorption[b]};
        }
    });
    RoomSurvey survey;
    if (hits == 0) return survey;
    survey.mean_free_path_m = length_m / static_cast<double>(hits);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        survey.mean_absorption[b] = static_cast<float>(
            (absorption[b] + static_cast<double>(escaped)) / static_cast<double>(hits + escaped));
    }
    return survey;
}

std::vector<char> connected(const RayScene& scene, std::span<const Vec3> listeners,
                            std::span<const Vec3> sources, std::uint64_t seed,
                            MovableObjects movable) {
    RandomWalks walks{.paths = kSurveyPaths, .bounces = 2 * kSurveyBounces, .seed = seed};
    walks.through_moving = movable == MovableObjects::are_passed;
    walks.through_walls = true;
    // Points of the listeners' walks on a side of a triangle, empty until they are needed. A wall
    // may stand on a triangle, so that a side alone does not join two walks.
    constexpr std::size_t kPointsPerSide = 4;
    std::unordered_map<std::size_t, std::vector<Vec3>> reached;
    const auto point_above = [&](const Ray& ray, const Hit& hit) {
        return start_after(ray.origin, scene.point(hit, ray.direction),
                           scene.facing_normal(hit, ray.direction));
    };
    const auto mark_reached = [&] {
        trace_random_walks(scene, listeners, walks, [&](float, const Ray& ray, const Hit& hit) {
            if (!hit.any()) return;
            std::vector<Vec3>& points = reached[side_of(scene, ray, hit)];
            if (points.size() < kPointsPerSide) points.push_back(point_above(ray, hit));
        });
    };
    const auto sees_any = [&](const Vec3& point, std::span<const Vec3> others) {
        return std::any_of(others.begin(), others.end(),
                           [&](const Vec3& other) { return scene.visible(point, other); });
    };
    // With a listener, without `reached`; else with a point of its walks.
    const auto meets = [&](const Vec3& source, int paths) {
        RandomWalks back = walks;
        back.paths = paths;
        back.seed = derive_seed(walks.seed, 1);
        bool met = false;
        trace_random_walks(scene, {&source, 1}, back, [&](float, const Ray& ray, const Hit& hit) {
            if (met || !hit.any()) return;
            if (reached.empty()) {
                met = sees_any(point_above(ray, hit), listeners);
                return;
            }
            const auto side = reached.find(side_of(scene, ray, hit));
            if (side != reached.end()) met = sees_any(point_above(ray, hit), side->second);
        });
        return met;
    };
    constexpr int kFirstPaths = 16;  // sufficient for most sources
    std::vector<char> result(sources.size(), 1);
    for (std::size_t s = 0; s < sources.size(); ++s) {
        if (sees_any(sources[s], listeners)) continue;
        if (reached.empty()) {
            if (meets(sources[s], kFirstPaths)) continue;
            mark_reached();
        }
        result[s] = meets(sources[s], kFirstPaths) || meets(sources[s], walks.paths) ? 1 : 0;
    }
    return result;
}

namespace {

/// Points of the surface: shares of it within 0.4 %.
constexpr int kAreaSamples = 16384;

/// Of each point, of which one may leave through an opening.
constexpr int kRaysPerSample = 4;

/// Share of the surface; above it the mean free path is not that of a room.
constexpr double kMaxOpen = 0.1;
/// Relative; several standard errors of the mean free path: the standard deviation of lengths is
/// 0.6 of their mean, and there are more than 16384 of them.
constexpr double kVolumeTolerance = 0.01;

/// The volume enclosed by the triangles if their surface is closed and consistently oriented: the
/// integral of x . n is three times the volume. The origin is in the middle to minimise rounding.
double enclosed_m3(const RayScene& scene) {
    const glm::dvec3 origin(scene.triangle(0).vertices[0]);
    double volume_m3 = 0;
    for (std::uint32_t i = 0; i < scene.triangle_count(); ++i) {
        const RayScene::Triangle& t = scene.triangle(i);
        const glm::dvec3 a = glm::dvec3(t.vertices[0]) - origin;
        const glm::dvec3 b = glm::dvec3(t.vertices[1]) - origin;
        const glm::dvec3 c = glm::dvec3(t.vertices[2]) - origin;
        const double covered_m2 = scene.coplanar_faces().covered_m2(i);
        const double heard = covered_m2 > 0 ? 1 - covered_m2 / double{t.area_m2()} : 1;
        volume_m3 += heard * glm::dot(a, glm::cross(b, c)) / 6;
    }
    return std::abs(volume_m3);
}

/// Points of uniform density on the triangles, one in each of equal parts of the area.
struct AreaSample {
    std::uint32_t triangle = 0;
    Vec3 point{0};
};

std::vector<AreaSample> sample_area(const RayScene& scene, double area_m2, RandomStream& random) {
    std::vector<AreaSample> samples;
    const double step_m2 = area_m2 / kAreaSamples;
    double next_m2 = 0.5 * step_m2;
    double passed_m2 = 0;
    for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
        const RayScene::Triangle& triangle = scene.triangle(t);
        passed_m2 += double{triangle.area_m2()};
        for (; next_m2 < passed_m2; next_m2 += step_m2) {
            const auto at = random.uniform_2d();
            const float root = std::sqrt(at[0]);
            const auto& [a, b, c] = triangle.vertices;
            samples.push_back({t, a + root * ((1 - at[1]) * (b - a) + at[1] * (c - a))});
        }
    }
    return samples;
}

/// The starts of random walks and points just above surfaces that they have reached: what sees one
/// of them is in the room.
class ReachedPoints {
 public:
    ReachedPoints(const RayScene& scene, std::span<const Vec3> inside, std::uint64_t seed)
        : scene_(scene), points_(inside.begin(), inside.end()) {
        const RandomWalks walks{.paths = kSurveyPaths,
                                .bounces = 2 * kSurveyBounces,
                                .seed = seed,
                                .through_moving = false};
        int hits = 0;
        trace_random_walks(scene, inside, walks, [&](float, const Ray& ray, const Hit& hit) {
            is_tight_ = is_tight_ && hit.any();
            if (!hit.any() || hits++ % kHitsPerPoint != 0) return;
            points_.push_back(start_after(ray.origin, scene.point(hit, ray.direction),
                                          scene.facing_normal(hit, ray.direction)));
        });
    }

    /// Whether no walk has escaped.
    bool is_tight() const { return is_tight_; }

    /// Whether one of the nearest points in front of a surface is visible.
    bool is_seen_from(const Vec3& origin, const Vec3& normal) const {
        constexpr float kGrazing = 0.02F;  // cosine; points on the same face are not in front of it
        struct Near {
            float square_m2 = std::numeric_limits<float>::infinity();
            Vec3 point{0};
        };
        std::array<Near, kNearest> nearest;
        for (const Vec3& point : points_) {
            const Vec3 offset = point - origin;
            const float square_m2 = glm::dot(offset, offset);
            if (square_m2 >= nearest.back().square_m2) continue;
            if (!(glm::dot(offset, normal) > kGrazing * std::sqrt(square_m2))) continue;
            std::size_t place = kNearest - 1;
            for (; place > 0 && square_m2 < nearest[place - 1].square_m2; --place) {
                nearest[place] = nearest[place - 1];
            }
            nearest[place] = {square_m2, point};
        }
        return std::any_of(nearest.begin(), nearest.end(), [&](const Near& near) {
            return std::isfinite(near.square_m2) && scene_.visible(origin, near.point);
        });
    }

 private:
    static constexpr int kHitsPerPoint = 32;     // 4096 points in a room without openings
    static constexpr std::size_t kNearest = 16;  // some may be in another room

    const RayScene& scene_;
    std::vector<Vec3> points_;
    bool is_tight_ = true;
};

/// Areas of triangles that sound reaches: the share of each triangle's own samples, or of its
/// material's if it has none, scaled to the area of the material.
std::vector<double> triangle_areas(const RayScene& scene, std::span<const double> material_m2,
                                   std::span<const int> sampled, std::span<const int> counted) {
    std::vector<double> area_m2(scene.triangle_count());
    std::vector<double> sum_m2(material_m2.size());
    std::vector<double> own_m2(material_m2.size());
    const auto own = [&](std::uint32_t t) {
        return double{scene.triangle(t).area_m2()} - scene.coplanar_faces().covered_m2(t);
    };
    for (std::uint32_t t = 0; t < area_m2.size(); ++t) own_m2[scene.triangle(t).material] += own(t);
    for (std::uint32_t t = 0; t < area_m2.size(); ++t) {
        const std::uint32_t m = scene.triangle(t).material;
        if (!(own_m2[m] > 0)) continue;
        area_m2[t] =
            sampled[t] > 0 ? own(t) * counted[t] / sampled[t] : own(t) * material_m2[m] / own_m2[m];
        sum_m2[m] += area_m2[t];
    }
    for (std::uint32_t t = 0; t < area_m2.size(); ++t) {
        const std::uint32_t m = scene.triangle(t).material;
        if (sum_m2[m] > 0) area_m2[t] *= material_m2[m] / sum_m2[m];
    }
    return area_m2;
}

}  // namespace

RoomGeometry measure_room(const RayScene& scene, std::span<const Vec3> inside, std::uint64_t seed) {
    RoomGeometry room;
    std::vector<double> all_m2;  // [material]
    double total_m2 = 0;
    for (std::uint32_t i = 0; i < scene.triangle_count(); ++i) {
        const RayScene::Triangle& t = scene.triangle(i);
        if (t.material >= all_m2.size()) all_m2.resize(t.material + 1);
        all_m2[t.material] += double{t.area_m2()} - scene.coplanar_faces().covered_m2(i);
        total_m2 += double{t.area_m2()};
    }
    room.area_m2.resize(all_m2.size());
    if (!(total_m2 > 0)) return room;

    const ReachedPoints reached(scene, inside, seed);
    RandomStream random(derive_seed(seed, 1));
    std::vector<int> sampled(all_m2.size());
    std::vector<int> counted(all_m2.size());
    std::vector<int> sampled_of_triangles(scene.triangle_count());
    std::vector<int> counted_of_triangles(scene.triangle_count());
    int open = 0;
    int closed = 0;
    double length_m = 0;
    for (const AreaSample& sample : sample_area(scene, total_m2, random)) {
        const RayScene::Triangle& triangle = scene.triangle(sample.triangle);
        if (scene.heard_at(sample.triangle, sample.point) != sample.triangle) continue;
        ++sampled[triangle.material];
        ++sampled_of_triangles[sample.triangle];
        for (const float side : {1.0F, -1.0F}) {
            const Vec3 normal = side * triangle.normal;
            // Coincident faces count once: only the face that rays hit.
            std::array<Ray, kRaysPerSample + 1> rays;
            const float offset_m = offset_at(sample.point);
            const Vec3 origin = sample.point + offset_m * normal;
            rays[0] = {origin, -normal, 2 * offset_m};
            for (std::size_t i = 1; i < rays.size(); ++i)
                rays[i] = {origin, lambert_direction(normal, random.uniform_2d())};
            std::array<Hit, kRaysPerSample + 1> hits;
            scene.intersect(rays, hits);
            if (hits[0].triangle != sample.triangle) continue;
            const auto escaped = static_cast<int>(std::count_if(
                hits.begin() + 1, hits.end(), [](const Hit& hit) { return !hit.any(); }));
            if (reached.is_tight() && escaped > 0) continue;
            // A face may extend outside the room. In a recess the points are seen by reflection.
            const auto sees_after_reflection = [&](std::size_t i) {
                if (!hits[i].any()) return false;
                const Vec3 facing = scene.facing_normal(hits[i], rays[i].direction);
                const Vec3 point = scene.point(hits[i], rays[i].direction);
                return reached.is_seen_from(start_after(origin, point, facing), facing);
            };
            bool is_in_room = reached.is_seen_from(origin, normal);
            for (std::size_t i = 1; i < rays.size() && !is_in_room; ++i) {
                is_in_room = sees_after_reflection(i);
            }
            if (!is_in_room) continue;
            ++counted[triangle.material];
            ++counted_of_triangles[sample.triangle];
            open += escaped;
            closed += kRaysPerSample - escaped;
            for (const Hit& hit : std::span(hits).subspan(1)) {
                if (hit.any()) length_m += double{hit.distance_m};
            }
        }
    }
    if (open + closed == 0) return room;
    for (std::size_t m = 0; m < all_m2.size(); ++m) {
        if (sampled[m] > 0) room.area_m2[m] = all_m2[m] * counted[m] / sampled[m];
        room.surface_m2 += room.area_m2[m];
    }
    room.triangle_area_m2 =
        triangle_areas(scene, room.area_m2, sampled_of_triangles, counted_of_triangles);
    room.open_share = static_cast<double>(open) / (open + closed);
    if (closed > 0) room.field.mean_free_path_m = length_m / closed;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        double absorbing_m2 = 0;
        for (std::size_t m = 0; m < room.area_m2.size(); ++m) {
            absorbing_m2 += room.area_m2[m] *
                            double{scene.material(static_cast<std::uint32_t>(m)).absorption[b]};
        }
        room.field.mean_absorption[b] = static_cast<float>(
            room.open_share + (1 - room.open_share) * absorbing_m2 / room.surface_m2);
    }
    if (room.open_share > kMaxOpen) return room;
    // l = 4 V / S, with openings included in S.
    const double volume_m3 =
        room.field.mean_free_path_m * room.surface_m2 / (1 - room.open_share) / 4;
    const double exact_m3 = enclosed_m3(scene);
    const bool agrees = std::abs(exact_m3 - volume_m3) < kVolumeTolerance * volume_m3;
    room.volume_m3 = agrees ? exact_m3 : volume_m3;
    return room;
}

double escape_per_reflection(const RayScene& scene, std::span<const Vec3> inside,
                             std::uint64_t seed) {
    constexpr RandomWalks kWalks{.paths = 4096, .bounces = 32};
    RandomWalks walks = kWalks;
    walks.seed = seed;
    double segments = 0;
    double escaped = 0;
    trace_random_walks(scene, inside, walks, [&](float, const Ray&, const Hit& hit) {
        ++segments;
        escaped += hit.any() ? 0 : 1;
    });
    return segments > 0 ? escaped / segments : 0;
}

std::vector<char> outside_room(const RayScene& scene, std::span<const Vec3> positions,
                               std::uint64_t seed) {
    constexpr int kPaths = 64;     // at most 2048 reflections: kFew is far beyond their scatter
    constexpr double kFew = 0.25;  // of the reflections of the most enclosed position
    std::vector<int> reflections;
    for (const Vec3& position : positions) {
        int count = 0;
        trace_random_walks(scene, {&position, 1},
                           {.paths = kPaths, .bounces = kSurveyBounces, .seed = seed},
                           [&](float, const Ray&, const Hit& hit) { count += hit.any() ? 1 : 0; });
        reflections.push_back(count);
    }
    std::vector<char> outside;
    const int max =
        reflections.empty() ? 0 : *std::max_element(reflections.begin(), reflections.end());
    for (const int count : reflections) outside.push_back(count < kFew * max ? 1 : 0);
    return outside;
}

std::vector<Vec3> inside_room(const RayScene& scene, std::span<const Vec3> positions,
                              std::uint64_t seed) {
    constexpr std::size_t kMost = 64;  // bounds the time for scenes with many sources
    std::vector<Vec3> tested;
    const std::size_t count = std::min(kMost, positions.size());
    for (std::size_t i = 0; i < count; ++i)
        tested.push_back(positions[i * positions.size() / count]);
    const std::vector<char> outside = outside_room(scene, tested, seed);
    std::vector<Vec3> inside;
    for (std::size_t i = 0; i < count; ++i) {
        if (!outside[i]) inside.push_back(tested[i]);
    }
    return inside;
}

double schroeder_frequency_hz(double reverberation_time_s, double volume_m3) {
    return 2000 * std::sqrt(reverberation_time_s / volume_m3);
}

Bands sabine_time_s(const RoomSurvey& survey, const Medium& medium) {
    return sabine_time_s(survey.mean_free_path_m, survey.mean_absorption,
                         medium.attenuation_per_m(), double{medium.speed_of_sound_m_s()});
}

Bands reverberation_time_s(const RoomSurvey& survey, const Medium& medium) {
    constexpr float kMaxAbsorption = 0.999F;  // Eyring's time of 1 is 0
    if (!(survey.mean_free_path_m > 0)) return {};
    Bands absorption = survey.mean_absorption;
    for (float& a : absorption.value) a = std::min(a, kMaxAbsorption);
    return eyring_time_s(survey.mean_free_path_m, absorption, medium.attenuation_per_m(),
                         double{medium.speed_of_sound_m_s()});
}

}  // namespace aula
