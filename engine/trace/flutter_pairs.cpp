#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <map>
#include <span>
#include <utility>

#include "engine/base/sampling.h"
#include "engine/base/tolerances.h"
#include "engine/trace/specular_paths.h"

namespace aula {

namespace {

/// Smaller planes, and planes of which less faces each other, lose a flutter echo after few
/// reflections.
constexpr double kSmallest_m2 = 1;

/// Planes at a smaller distance are mostly the sides of a wall. The repetitions of a flutter echo
/// have 343 Hz there.
constexpr float kClosest_m = 0.5F;

/// Lines of each plane to either side. They leave an eighth of the area of a plane unseen with a
/// probability of 0.02 %.
constexpr std::uint32_t kLines = 64;

/// As many of the largest planes send lines: 33,000 rays at most.
constexpr std::size_t kMostPlanes = 256;

/// Planes at a larger angle turn the path out of a room of usual size within ten reflections.
constexpr double kParallel_rad = glm::radians(3.0);

/// The last image source over the first: 60 dB.
constexpr double kLowest = 1e-6;

/// A choice: between surfaces of absorption 0.02 these 60 dB take 170 reflections, of which the
/// last are only 11 dB below the hundredth.
constexpr std::size_t kMostOrders = 100;

/// Sequences of all pairs: those of fifty boxes of hard walls. They have 20 bytes each, and cost
/// nothing to sources and listeners that are not between their planes.
constexpr std::size_t kMostSequences = 32768;

/// Moving surfaces that a line passes: the two sides of eight objects.
constexpr int kMostPassed = 16;

/// What is large and mirrors sound, [plane].
struct Wall {
    double mirrored = 0;  ///< share of the energy, in the band in which the plane reflects most
    double area_m2 = 0;   ///< of its triangles that do not move
    std::vector<std::uint32_t> triangles;
};

std::vector<Wall> walls_of(const RayScene& scene, const ScenePlanes& planes) {
    std::vector<Wall> walls(planes.count());
    for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
        const std::uint32_t plane = planes.of_triangle(t);
        if (plane == ScenePlanes::kNoPlane || planes[plane].area_m2 < kSmallest_m2) continue;
        if (scene.moves(scene.triangle(t))) continue;
        const Material& material = scene.material(scene.triangle(t));
        const Bands share = complement(material.absorption) * complement(material.scattering);
        walls[plane].mirrored = std::max(walls[plane].mirrored, double{share.max()});
        walls[plane].area_m2 += double{scene.triangle(t).area_m2()};
        walls[plane].triangles.push_back(t);
    }
    return walls;
}

/// Lines along the normals of the triangles of a wall, from points that are evenly distributed over
/// their area, to one side and to the other.
std::vector<Ray> lines_from(const RayScene& scene, const Wall& wall, std::uint32_t plane) {
    const ScrambledSobol sobol(derive_seed(0x666c7574746572ULL, plane));
    std::vector<std::array<float, 2>> points;
    for (std::uint32_t i = 0; i < kLines; ++i) points.push_back(sobol.point(i));
    std::sort(points.begin(), points.end());
    std::vector<Ray> lines;
    std::size_t next = 0;
    double before_m2 = 0;
    for (const std::uint32_t t : wall.triangles) {
        const RayScene::Triangle& triangle = scene.triangle(t);
        const double here_m2{triangle.area_m2()};
        const bool is_last = t == wall.triangles.back();
        for (; next < kLines; ++next) {
            const double at = (double{points[next][0]} * wall.area_m2 - before_m2) / here_m2;
            if (at >= 1 && !is_last) break;
            // Uniform over the triangle (Turk 1990).
            const auto root = static_cast<float>(std::sqrt(std::clamp(at, 0.0, 1.0)));
            const Vec3 point = (1 - root) * triangle.vertices[0] +
                               root * ((1 - points[next][1]) * triangle.vertices[1] +
                                       points[next][1] * triangle.vertices[2]);
            for (const float side : {-1.0F, 1.0F}) {
                const Vec3 normal = side * triangle.normal;
                lines.push_back(
                    {.origin = point + tolerances::kOffset_m * normal, .direction = normal});
            }
        }
        before_m2 += here_m2;
    }
    return lines;
}

/// The hit of a line behind surfaces that move, with the distance from its origin: an object that
/// stands between two walls may leave.
Hit past_movers(const RayScene& scene, Ray line, Hit hit) {
    float passed_m = 0;
    for (int n = 0; hit.any() && scene.moves(scene.triangle(hit.triangle)); ++n) {
        if (n == kMostPassed) return {};
        const float to_next_m = hit.distance_m + tolerances::kOffset_m;
        passed_m += to_next_m;
        line.origin += to_next_m * line.direction;
        hit = {};
        scene.intersect({&line, 1}, {&hit, 1});
    }
    if (hit.any()) hit.distance_m += passed_m;
    return hit;
}

/// What two planes see of each other.
struct Facing {
    double area_m2 = 0;
    float distance_m = std::numeric_limits<float>::infinity();  ///< the shortest
};

/// [lower plane, higher plane]
std::map<std::pair<std::uint32_t, std::uint32_t>, Facing> facing_planes(
    const RayScene& scene, const ScenePlanes& planes, const std::vector<Wall>& walls,
    std::span<const std::uint32_t> large) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, Facing> found;
    std::vector<Hit> hits;
    for (const std::uint32_t from : large) {
        const std::vector<Ray> lines = lines_from(scene, walls[from], from);
        hits.resize(lines.size());
        scene.intersect(lines, hits);
        std::map<std::uint32_t, Facing> seen;
        for (std::size_t i = 0; i < lines.size(); ++i) {
            const Hit hit = past_movers(scene, lines[i], hits[i]);
            if (!hit.any() || hit.distance_m < kClosest_m) continue;
            const std::uint32_t to = planes.of_triangle(hit.triangle);
            if (to == ScenePlanes::kNoPlane || to == from || walls[to].mirrored == 0) continue;
            if (std::abs(glm::dot(planes[from].normal, planes[to].normal)) <
                std::cos(kParallel_rad))
                continue;
            seen[to].area_m2 += walls[from].area_m2 / kLines;
            seen[to].distance_m = std::min(seen[to].distance_m, hit.distance_m);
        }
        for (const auto& [to, facing] : seen) {
            Facing& both = found[std::minmax(from, to)];
            both.area_m2 = std::max(both.area_m2, facing.area_m2);
            both.distance_m = std::min(both.distance_m, facing.distance_m);
        }
    }
    return found;
}

/// The order of the last image source whose energy, with the loss by reflections and distance, is
/// above kLowest, and which is not farther than `longest_m`.
std::size_t last_order(double mirrored_by_both, double distance_m, double longest_m) {
    std::size_t order = 0;
    double reflected = 1;
    while (order < kMostOrders && static_cast<double>(order) * distance_m < longest_m) {
        reflected *= std::sqrt(mirrored_by_both);
        const auto distance = static_cast<double>(order + 1);
        if (reflected / (distance * distance) < kLowest) break;
        ++order;
    }
    return order;
}

}  // namespace

std::vector<FlutterPair> flutter_pairs(const RayScene& scene, const ScenePlanes& planes,
                                       double longest_m) {
    const std::vector<Wall> walls = walls_of(scene, planes);
    std::vector<std::uint32_t> large;
    for (std::uint32_t p = 0; p < planes.count(); ++p) {
        if (walls[p].mirrored > 0) large.push_back(p);
    }
    std::stable_sort(large.begin(), large.end(), [&](std::uint32_t a, std::uint32_t b) {
        return planes[a].area_m2 > planes[b].area_m2;
    });
    large.resize(std::min(large.size(), kMostPlanes));
    std::vector<std::pair<double, FlutterPair>> found;  // area, pair
    for (const auto& [pair, facing] : facing_planes(scene, planes, walls, large)) {
        if (facing.area_m2 < kSmallest_m2) continue;
        const double mirrored = walls[pair.first].mirrored * walls[pair.second].mirrored;
        found.push_back({facing.area_m2,
                         {{pair.first, pair.second},
                          last_order(mirrored, double{facing.distance_m}, longest_m)}});
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<FlutterPair> pairs;
    std::size_t sequences = 0;
    for (const auto& [area_m2, pair] : found) {
        if (sequences + 2 * pair.order > kMostSequences) continue;
        sequences += 2 * pair.order;
        pairs.push_back(pair);
    }
    return pairs;
}

}  // namespace aula
