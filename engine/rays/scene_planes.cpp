#include "engine/rays/scene_planes.h"

#include <tsl/robin_map.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "engine/base/mix64.h"
#include "engine/base/tolerances.h"

namespace aula {
namespace {

using Point = ScenePlanes::Point;

/// Cell of the normals' grid. A search with the tolerance visits at most two cells along an axis.
constexpr double kCell = 0.004;
static_assert(kCell > 2 * tolerances::kCoplanar_rad);

Point normal_of(const RayScene::Triangle& t) {
    const Point a(t.vertices[0]);
    return glm::normalize(glm::cross(Point(t.vertices[1]) - a, Point(t.vertices[2]) - a));
}

/// True if part of the sound is reflected specularly in some band.
bool reflects(const Material& material) {
    return (complement(material.absorption) * complement(material.scattering)).max() > 0;
}

double twice_area_m2(const RayScene::Triangle& t) {
    const Point a(t.vertices[0]);
    return glm::length(glm::cross(Point(t.vertices[1]) - a, Point(t.vertices[2]) - a));
}

/// An index of planes by the cell of their normal and of their offset from the scene's centre.
class PlaneIndex {
 public:
    /// For triangles within `radius_m` of the centre.
    PlaneIndex(const Point& middle, double radius_m)
        : middle_(middle), slab_m_(2 * reach_m(radius_m)) {}

    /// `index` is that of the plane; call in ascending order from 0.
    void add(const ScenePlanes::Plane& plane, std::uint32_t index) {
        assert(index == next_.size());
        const Point n = (plane.normal + 1.0) / kCell;
        const std::uint64_t cell =
            key(static_cast<int>(n.x), static_cast<int>(n.y), static_cast<int>(n.z),
                slab(plane.offset_m - glm::dot(plane.normal, middle_)));
        occupied_[sign_of(cell)] = true;
        const auto [last, added] = last_in_cell_.try_emplace(cell, index);
        next_.push_back(added ? kNone : last->second);
        last.value() = index;
    }

    /// A plane that contains a triangle with this normal.
    std::optional<std::uint32_t> find(const std::vector<ScenePlanes::Plane>& planes,
                                      const RayScene::Triangle& triangle,
                                      const Point& normal) const {
        const Point from_middle = Point(triangle.vertices[0]) - middle_;
        const double reach = reach_m(glm::length(from_middle));
        for (const double sign : {1.0, -1.0}) {
            const Point n = sign * normal;
            const double offset_m = glm::dot(n, from_middle);
            const glm::ivec3 low((n + 1.0 - tolerances::kCoplanar_rad) / kCell);
            const glm::ivec3 high((n + 1.0 + tolerances::kCoplanar_rad) / kCell);
            for (int x = low.x; x <= high.x; ++x) {
                for (int y = low.y; y <= high.y; ++y) {
                    for (int z = low.z; z <= high.z; ++z) {
                        for (int at = slab(offset_m - reach); at <= slab(offset_m + reach); ++at) {
                            const std::uint64_t cell = key(x, y, z, at);
                            if (!occupied_[sign_of(cell)]) continue;
                            const auto last = last_in_cell_.find(cell);
                            if (last == last_in_cell_.end()) continue;
                            for (auto i = last->second; i != kNone; i = next_[i]) {
                                if (holds(planes[i], triangle, n)) return i;
                            }
                        }
                    }
                }
            }
        }
        return std::nullopt;
    }

 private:
    static constexpr int kSignBits = 23;  // of `occupied_`: 1 MB
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    static double reach_m(double from_middle_m) {
        return tolerances::kSame_m + tolerances::kCoplanar_rad * from_middle_m;
    }

    /// The bit of `occupied_` for a cell.
    static std::size_t sign_of(std::uint64_t cell) { return mix64(cell) >> (64 - kSignBits); }

    /// The cell of an offset. Its width is the reach of any triangle, so that a search visits at
    /// most two.
    int slab(double offset_m) const { return static_cast<int>(std::floor(offset_m / slab_m_)); }

    static std::uint64_t key(int x, int y, int z, int slab) {
        return static_cast<std::uint64_t>(static_cast<std::uint32_t>(slab)) << 32 |
               static_cast<std::uint32_t>((x << 20) + (y << 10) + z);
    }

    static bool holds(const ScenePlanes::Plane& plane, const RayScene::Triangle& triangle,
                      const Point& normal) {
        if (glm::length(glm::cross(plane.normal, normal)) > std::sin(tolerances::kCoplanar_rad))
            return false;
        return std::all_of(triangle.vertices.begin(), triangle.vertices.end(), [&](const Vec3& v) {
            return std::abs(plane.distance_m(Point(v))) <= tolerances::kSame_m;
        });
    }

    Point middle_;
    double slab_m_;
    // Most searches find nothing. A bitmap of a megabyte, which stays in the cache, answers these
    // first.
    std::vector<bool> occupied_ = std::vector<bool>(std::size_t{1} << kSignBits);
    tsl::robin_map<std::uint64_t, std::uint32_t, MixHash> last_in_cell_;
    std::vector<std::uint32_t> next_;  ///< the previous plane in the same cell
};

}  // namespace

double ScenePlanes::Plane::distance_m(const Point& p) const {
    return glm::dot(normal, p) - offset_m;
}

ScenePlanes::ScenePlanes(const RayScene& scene) : scene_(scene) {
    for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
        const std::uint32_t object = scene.triangle(t).object;
        if (object >= objects_.size()) {
            objects_.resize(object + 1);
            objects_[object] = {t, t, scene.triangle(t).vertices};
        }
        objects_[object].end_triangle = t + 1;
    }
    merge();
}

/// The largest triangles come first, because their normals are the most exact.
void ScenePlanes::merge() {
    const auto& triangles = scene_.triangles();
    std::vector<double> size_m2(triangles.size());
    std::transform(triangles.begin(), triangles.end(), size_m2.begin(), twice_area_m2);
    std::vector<std::uint32_t> by_size(triangles.size());
    std::iota(by_size.begin(), by_size.end(), 0U);
    std::stable_sort(by_size.begin(), by_size.end(),
                     [&](auto a, auto b) { return size_m2[a] > size_m2[b]; });
    plane_of_triangle_.assign(triangles.size(), kNoPlane);
    Bounds bounds;
    for (const RayScene::Triangle& t : triangles) bounds.add(t.vertices[0]);
    const Point low(bounds.min);
    const Point high(bounds.max);
    PlaneIndex index(0.5 * (low + high), triangles.empty() ? 0 : 0.5 * glm::length(high - low));
    for (const std::uint32_t t : by_size) {
        if (triangles[t].normal == Vec3(0) || !(size_m2[t] > 0)) continue;
        const Point normal = normal_of(triangles[t]);
        std::uint32_t plane = index.find(planes_, triangles[t], normal).value_or(kNoPlane);
        if (plane == kNoPlane) {
            plane = static_cast<std::uint32_t>(planes_.size());
            planes_.push_back({.normal = normal,
                               .offset_m = glm::dot(normal, Point(triangles[t].vertices[0])),
                               .reference = t,
                               .object = triangles[t].object});
            index.add(planes_.back(), plane);
        }
        plane_of_triangle_[t] = plane;
        include(planes_[plane], t);
    }
}

void ScenePlanes::include(Plane& plane, std::uint32_t triangle) const {
    const RayScene::Triangle& t = scene_.triangle(triangle);
    plane.bounds.add(t.vertices);
    plane.area_m2 += double{t.area_m2()};
    plane.reflects |= reflects(scene_.material(t));
    if (plane.object != t.object) plane.object = kManyObjects;
}

void ScenePlanes::scene_moved() {
    for (std::uint32_t o = 0; o < objects_.size(); ++o) {
        PlacedObject& object = objects_[o];
        if (object.first_triangle == object.end_triangle) continue;
        const auto& now = scene_.triangle(object.first_triangle).vertices;
        if (object.vertices == now) continue;
        object.vertices = now;
        follow(o);
    }
}

void ScenePlanes::materials_changed() {
    for (Plane& plane : planes_) plane.reflects = false;
    for (std::uint32_t t = 0; t < plane_of_triangle_.size(); ++t) {
        if (plane_of_triangle_[t] == kNoPlane) continue;
        planes_[plane_of_triangle_[t]].reflects |= reflects(scene_.material(scene_.triangle(t)));
    }
}

/// Moves an object's planes to its triangles, after separating them from shared planes.
void ScenePlanes::follow(std::uint32_t object) {
    std::map<std::uint32_t, std::uint32_t> own;  // plane before -> plane now
    for (std::uint32_t t = objects_[object].first_triangle; t < objects_[object].end_triangle;
         ++t) {
        std::uint32_t& plane = plane_of_triangle_[t];
        if (plane == kNoPlane) continue;
        auto [entry, first] = own.emplace(plane, plane);
        if (first) {
            std::uint32_t reference = planes_[plane].reference;
            if (planes_[plane].object != object) {
                entry->second = static_cast<std::uint32_t>(planes_.size());
                planes_.emplace_back();
                reference = t;
            }
            const RayScene::Triangle& triangle = scene_.triangle(reference);
            const Point normal = normal_of(triangle);
            planes_[entry->second] = {.normal = normal,
                                      .offset_m = glm::dot(normal, Point(triangle.vertices[0])),
                                      .reference = reference,
                                      .object = object};
        }
        if (plane != entry->second) planes_[plane].area_m2 -= double{scene_.triangle(t).area_m2()};
        plane = entry->second;
        include(planes_[plane], t);
    }
}

}  // namespace aula
