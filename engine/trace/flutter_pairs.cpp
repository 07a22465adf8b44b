#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <utility>

#include "engine/trace/specular_paths.h"

namespace aula {

namespace {

using Point = ScenePlanes::Point;

/// Smaller planes lose a flutter echo after few reflections.
constexpr double kSmallest_m2 = 1;

/// Planes at a smaller distance are mostly the sides of a wall. The repetitions of a flutter echo
/// have 343 Hz there.
constexpr double kClosest_m = 0.5;

/// The pairs of so many planes are compared.
constexpr std::size_t kMostPlanes = 256;

/// Planes at a larger angle turn the path out of a room of usual size within five reflections.
constexpr double kParallel_rad = glm::radians(3.0);

/// 60 dB. Between surfaces of absorption 0.02 they take 200 reflections, of which the last are only
/// 10 dB below the hundredth.
constexpr double kLowest = 1e-6;
constexpr std::size_t kMostOrders = 100;

/// Sequences of all pairs. Those of a box of hard walls are 600.
constexpr std::size_t kMostSequences = 1024;

/// Of a plane, in the band in which it reflects most.
std::vector<double> mirrored_shares(const RayScene& scene, const ScenePlanes& planes) {
    std::vector<double> shares(planes.count());
    for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
        const std::uint32_t plane = planes.of_triangle(t);
        if (plane == ScenePlanes::kNoPlane) continue;
        const Material& material = scene.material(scene.triangle(t));
        const Bands share = complement(material.absorption) * complement(material.scattering);
        shares[plane] = std::max(shares[plane], double{share.max()});
    }
    return shares;
}

Point middle_of(const ScenePlanes::Plane& plane) {
    return 0.5 * (Point(plane.bounds.min) + Point(plane.bounds.max));
}

/// Whether some line along the normal of `a` may meet both planes.
bool face_each_other(const ScenePlanes::Plane& a, const ScenePlanes::Plane& b) {
    const Point normal = glm::abs(a.normal);
    for (int axis = 0; axis < 3; ++axis) {
        // Bounds of planes across an axis are as wide along it as the planes are apart.
        if (normal[axis] > 0.7) continue;
        const double apart_m = std::abs(a.distance_m(middle_of(b))) * normal[axis];
        if (double{a.bounds.max[axis]} + apart_m < double{b.bounds.min[axis]} ||
            double{b.bounds.max[axis]} + apart_m < double{a.bounds.min[axis]})
            return false;
    }
    return true;
}

/// The order of the last image source whose energy, with the loss by reflections and distance, is
/// above kLowest.
std::size_t last_order(double of_pair) {
    std::size_t order = 0;
    double reflected = 1;
    while (order < kMostOrders) {
        reflected *= std::sqrt(of_pair);
        const auto distance = static_cast<double>(order + 1);
        if (reflected / (distance * distance) < kLowest) break;
        ++order;
    }
    return order;
}

}  // namespace

std::vector<FlutterPair> flutter_pairs(const RayScene& scene, const ScenePlanes& planes) {
    const std::vector<double> shares = mirrored_shares(scene, planes);
    std::vector<std::uint32_t> large;
    for (std::uint32_t p = 0; p < planes.count(); ++p) {
        if (planes[p].area_m2 >= kSmallest_m2 && shares[p] > 0 &&
            !scene.moves(scene.triangle(planes[p].reference)))
            large.push_back(p);
    }
    std::stable_sort(large.begin(), large.end(), [&](std::uint32_t a, std::uint32_t b) {
        return planes[a].area_m2 > planes[b].area_m2;
    });
    large.resize(std::min(large.size(), kMostPlanes));
    std::vector<std::pair<double, FlutterPair>> found;  // area, pair
    for (std::size_t i = 0; i < large.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const ScenePlanes::Plane& a = planes[large[i]];
            const ScenePlanes::Plane& b = planes[large[j]];
            if (std::abs(glm::dot(a.normal, b.normal)) < std::cos(kParallel_rad)) continue;
            if (std::abs(a.distance_m(middle_of(b))) < kClosest_m || !face_each_other(a, b))
                continue;
            found.push_back(
                {std::min(a.area_m2, b.area_m2),
                 {{large[j], large[i]}, last_order(shares[large[i]] * shares[large[j]])}});
        }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<FlutterPair> pairs;
    std::size_t sequences = 0;
    for (const auto& [area_m2, pair] : found) {
        sequences += 2 * pair.order;
        if (sequences > kMostSequences) break;
        pairs.push_back(pair);
    }
    return pairs;
}

}  // namespace aula
