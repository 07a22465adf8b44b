#include "engine/rays/coplanar_faces.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "engine/base/tolerances.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/scene_planes.h"

namespace aula {

namespace {

using PlanePoint = glm::dvec2;
using Polygon = std::vector<PlanePoint>;  // convex, counter-clockwise
using Overlap = CoplanarFaces::Overlap;

// Bounds of the time and memory for scenes that are heaps of coplanar triangles: below 0.5 s.
constexpr std::size_t kMostOverlaps = 250'000;
constexpr std::size_t kMostComparisons = 100'000'000;
constexpr std::size_t kSubtraction = 50;  ///< its time, in comparisons
constexpr std::size_t kMostCells = 64;    ///< of a grid, for each overlap on the mean

/// What is left of the comparisons.
class Budget {
 public:
    /// False if nothing is left.
    bool take(std::size_t comparisons) {
        left_ -= std::min(left_, comparisons);
        return left_ > 0;
    }

 private:
    std::size_t left_ = kMostComparisons;
};

double area_m2(const Polygon& polygon) {
    double twice = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const PlanePoint a = polygon[i] - polygon[0];
        const PlanePoint b = polygon[(i + 1) % polygon.size()] - polygon[0];
        twice += a.x * b.y - a.y * b.x;
    }
    return twice / 2;
}

/// The part of a polygon to the left of the line from a to b, or to the right of it.
Polygon cut(const Polygon& polygon, const PlanePoint& a, const PlanePoint& b, bool left) {
    const auto side = [&](const PlanePoint& p) {
        const double turn = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
        return left ? turn : -turn;
    };
    Polygon part;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const PlanePoint& p = polygon[i];
        const PlanePoint& q = polygon[(i + 1) % polygon.size()];
        const double at_p = side(p);
        const double at_q = side(q);
        if (at_p >= 0) part.push_back(p);
        if ((at_p > 0 && at_q < 0) || (at_p < 0 && at_q > 0))
            part.push_back(p + at_p / (at_p - at_q) * (q - p));
    }
    return part;
}

Polygon intersection(Polygon polygon, const Polygon& other) {
    for (std::size_t i = 0; i < other.size() && polygon.size() > 2; ++i)
        polygon = cut(polygon, other[i], other[(i + 1) % other.size()], true);
    return polygon.size() > 2 ? polygon : Polygon{};
}

/// Replaces polygons by their parts outside of another one.
void subtract(std::vector<Polygon>& polygons, const Polygon& other) {
    std::vector<Polygon> outside;
    for (Polygon& rest : polygons) {
        for (std::size_t i = 0; i < other.size() && rest.size() > 2; ++i) {
            const PlanePoint& a = other[i];
            const PlanePoint& b = other[(i + 1) % other.size()];
            Polygon part = cut(rest, a, b, false);
            if (part.size() > 2 && area_m2(part) > 0) outside.push_back(std::move(part));
            rest = cut(rest, a, b, true);
        }
    }
    polygons = std::move(outside);
}

/// A triangle in the coordinates of its plane.
struct Face {
    std::uint32_t triangle = 0;
    Polygon corners;
    std::array<double, 3> heights_m{};  ///< of the corners above the plane
    PlanePoint low{0};
    PlanePoint high{0};
    std::size_t region = 0;
};

bool is_wider_than_sliver(const PlanePoint& low, const PlanePoint& high) {
    return high.x - low.x > tolerances::kApart_m && high.y - low.y > tolerances::kApart_m;
}

bool overlap(const Face& a, const Face& b) {
    return is_wider_than_sliver(glm::max(a.low, b.low), glm::min(a.high, b.high));
}

double height_m(const Face& face, const PlanePoint& at) {
    const PlanePoint a = face.corners[1] - face.corners[0];
    const PlanePoint b = face.corners[2] - face.corners[0];
    const PlanePoint d = at - face.corners[0];
    const double twice = a.x * b.y - a.y * b.x;
    const double u = (d.x * b.y - d.y * b.x) / twice;
    const double v = (a.x * d.y - a.y * d.x) / twice;
    return (1 - u - v) * face.heights_m[0] + u * face.heights_m[1] + v * face.heights_m[2];
}

/// The root of an element in a forest of disjoint sets.
std::size_t root_of(std::vector<std::size_t>& parent, std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

/// The faces of one plane.
class Plane {
 public:
    Plane(const RayScene& scene, const ScenePlanes::Plane& plane,
          std::span<const std::pair<std::uint32_t, std::uint32_t>> members)
        : scene_(scene) {
        const glm::dvec3& n = plane.normal;
        const glm::dvec3 across = glm::normalize(
            glm::cross(n, std::abs(n.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
        axes_ = {across, glm::cross(n, across)};
        origin_ = glm::dvec3(scene.triangle(plane.reference).vertices[0]);
        for (const auto& [_, triangle] : members) {
            Face face{.triangle = triangle, .corners = {}};
            for (const Vec3& v : scene.triangle(triangle).vertices) {
                const glm::dvec3 d = glm::dvec3(v) - origin_;
                face.corners.emplace_back(glm::dot(d, axes_[0]), glm::dot(d, axes_[1]));
            }
            for (std::size_t k = 0; k < 3; ++k)
                face.heights_m[k] =
                    plane.distance_m(glm::dvec3(scene.triangle(triangle).vertices[k]));
            if (area_m2(face.corners) < 0) {
                std::swap(face.corners[1], face.corners[2]);
                std::swap(face.heights_m[1], face.heights_m[2]);
            }
            face.low = glm::min(glm::min(face.corners[0], face.corners[1]), face.corners[2]);
            face.high = glm::max(glm::max(face.corners[0], face.corners[1]), face.corners[2]);
            faces_.push_back(std::move(face));
        }
    }

    /// Nothing if there are too many.
    std::optional<std::vector<Overlap>> overlaps(Budget& budget) {
        const auto pairs = overlapping(budget);
        if (!pairs) return std::nullopt;
        if (pairs->empty()) return std::vector<Overlap>();
        const std::vector<Rank> ranks = find_regions();
        const std::vector<bool> layers = find_layers(*pairs, ranks);
        std::map<std::size_t, std::vector<std::size_t>> on;  // covered face -> faces heard on it
        for (auto [a, b, apart] : *pairs) {
            const Rank& of_a = ranks[faces_[a].region];
            const Rank& of_b = ranks[faces_[b].region];
            const bool in_layers = layers[faces_[a].region] || layers[faces_[b].region];
            if (are_equal(of_a, of_b) && !apart && is_other_material(a, b))
                contacts_.push_back(faces_[a].triangle < faces_[b].triangle
                                        ? part(faces_[b], {}, a)
                                        : part(faces_[a], {}, b));
            if (are_equal(of_a, of_b) || (apart && in_layers)) continue;
            if (of_a < of_b) std::swap(a, b);
            on[a].push_back(b);
        }
        std::vector<Overlap> found;
        for (auto& [covered, heard] : on) {
            if (!find_parts(covered, heard, ranks, budget, found)) return std::nullopt;
            for (std::size_t i = 0; i < heard.size(); ++i)
                found[found.size() - heard.size() + i].is_layer =
                    layers[faces_[covered].region] || layers[faces_[heard[i]].region];
        }
        return found;
    }

    /// Of overlaps().
    const std::vector<Overlap>& contacts() const { return contacts_; }

 private:
    /// The area and the first triangle of a face: the least is heard.
    using Rank = std::pair<double, std::uint32_t>;
    struct Pair {
        std::size_t a = 0;
        std::size_t b = 0;
        bool apart = false;  ///< a ray meets one of them in front of the other
    };
    using Pairs = std::vector<Pair>;

    /// True for areas that differ by the rounding of coordinates.
    static bool are_equal(const Rank& a, const Rank& b) {
        return std::abs(a.first - b.first) < 1e-4 * std::max(a.first, b.first);
    }

    std::pair<std::uint32_t, std::uint32_t> kind(const Face& face) const {
        const RayScene::Triangle& t = scene_.triangle(face.triangle);
        return {t.object, t.material};
    }

    bool is_other_material(std::size_t a, std::size_t b) const {
        return kind(faces_[a]).second != kind(faces_[b]).second;
    }

    std::optional<Pairs> overlapping(Budget& budget) {
        std::sort(faces_.begin(), faces_.end(), [](const Face& a, const Face& b) {
            return std::tie(a.low.x, a.triangle) < std::tie(b.low.x, b.triangle);
        });
        Pairs pairs;
        for (std::size_t a = 0; a < faces_.size(); ++a) {
            for (std::size_t b = a + 1;
                 b < faces_.size() && faces_[b].low.x < faces_[a].high.x - tolerances::kApart_m;
                 ++b) {
                if (!budget.take(1)) return std::nullopt;
                if (!overlap(faces_[a], faces_[b]) || kind(faces_[a]) == kind(faces_[b])) continue;
                const Polygon common = intersection(faces_[a].corners, faces_[b].corners);
                if (common.empty()) continue;
                double longest_m = 0;
                for (const PlanePoint& p : common)
                    longest_m = std::max(longest_m, glm::distance(p, common[0]));
                if (area_m2(common) > tolerances::kApart_m * longest_m)
                    pairs.push_back({a, b, are_apart(faces_[a], faces_[b], common)});
                if (pairs.size() > kMostOverlaps) return std::nullopt;
            }
        }
        return pairs;
    }

    static bool are_apart(const Face& a, const Face& b, const Polygon& common) {
        return std::any_of(common.begin(), common.end(), [&](const PlanePoint& p) {
            return std::abs(height_m(a, p) - height_m(b, p)) > 2 * double{tolerances::kFlat_m};
        });
    }

    /// [region] True for layers of equal area at different distances, and for what overlaps them
    /// outside of the plane: moved into it, they would change places.
    std::vector<bool> find_layers(const Pairs& pairs, const std::vector<Rank>& ranks) const {
        std::vector<bool> is_off(faces_.size(), false);
        for (const Face& face : faces_) {
            for (const double height_m : face.heights_m)
                if (std::abs(height_m) > double{tolerances::kFlat_m}) is_off[face.region] = true;
        }
        std::vector<std::size_t> parent(faces_.size());
        std::iota(parent.begin(), parent.end(), std::size_t{0});
        for (const auto& [a, b, _] : pairs) {
            if (is_off[faces_[a].region] && is_off[faces_[b].region])
                parent[root_of(parent, faces_[a].region)] = root_of(parent, faces_[b].region);
        }
        std::vector<bool> is_stack(faces_.size(), false);  // [root]
        for (const auto& [a, b, apart] : pairs) {
            if (!apart || !are_equal(ranks[faces_[a].region], ranks[faces_[b].region])) continue;
            for (const std::size_t face : {a, b})
                is_stack[root_of(parent, faces_[face].region)] = true;
        }
        std::vector<bool> layers(faces_.size());
        for (std::size_t r = 0; r < layers.size(); ++r)
            layers[r] = is_off[r] && is_stack[root_of(parent, r)];
        return layers;
    }

    /// Joins the faces of one kind that share a corner.
    std::vector<Rank> find_regions() {
        std::vector<std::size_t> parent(faces_.size());
        std::iota(parent.begin(), parent.end(), std::size_t{0});
        const auto root = [&](std::size_t face) { return root_of(parent, face); };
        using Corner = std::tuple<std::uint32_t, std::uint32_t, float, float, float>;
        std::vector<std::pair<Corner, std::size_t>> corners;
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            const auto [object, material] = kind(faces_[f]);
            for (const Vec3& v : scene_.triangle(faces_[f].triangle).vertices)
                corners.push_back({{object, material, v.x, v.y, v.z}, f});
        }
        std::sort(corners.begin(), corners.end());
        for (std::size_t i = 1; i < corners.size(); ++i) {
            if (corners[i].first == corners[i - 1].first)
                parent[root(corners[i].second)] = root(corners[i - 1].second);
        }
        std::vector<Rank> ranks(faces_.size(), {0, scene_.triangle_count()});
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            faces_[f].region = root(f);
            auto& [area, first] = ranks[faces_[f].region];
            area += area_m2(faces_[f].corners);
            first = std::min(first, faces_[f].triangle);
        }
        return ranks;
    }

    /// Adds the parts of a face on which others are heard, which are sorted by their precedence.
    /// False if they take too long.
    bool find_parts(std::size_t covered, std::vector<std::size_t>& heard,
                    const std::vector<Rank>& ranks, Budget& budget,
                    std::vector<Overlap>& found) const {
        std::sort(heard.begin(), heard.end());  // as all faces, by their lower x
        const auto precedes = [&](std::size_t a, std::size_t b) {
            return std::tie(ranks[faces_[a].region], faces_[a].triangle) <
                   std::tie(ranks[faces_[b].region], faces_[b].triangle);
        };
        std::map<std::size_t, std::vector<std::size_t>> before;
        for (std::size_t i = 0; i < heard.size(); ++i) {
            const Face& face = faces_[heard[i]];
            for (std::size_t j = i + 1;
                 j < heard.size() && faces_[heard[j]].low.x < face.high.x - tolerances::kApart_m;
                 ++j) {
                if (!budget.take(1)) return false;
                if (!overlap(face, faces_[heard[j]])) continue;
                if (!budget.take(kSubtraction)) return false;
                if (precedes(heard[i], heard[j])) {
                    before[heard[j]].push_back(heard[i]);
                } else {
                    before[heard[i]].push_back(heard[j]);
                }
            }
        }
        std::sort(heard.begin(), heard.end(), precedes);
        for (const std::size_t face : heard)
            found.push_back(part(faces_[covered], before[face], face));
        return true;
    }

    /// The part of a face on which `heard` is heard and none of `before`.
    Overlap part(const Face& covered, std::span<const std::size_t> before,
                 std::size_t heard) const {
        const Face& face = faces_[heard];
        std::vector<Polygon> rest{intersection(covered.corners, face.corners)};
        const Polygon whole = rest[0];
        for (const std::size_t other : before) subtract(rest, faces_[other].corners);
        Overlap result{.covered = covered.triangle, .heard = face.triangle};
        for (const Polygon& polygon : rest) result.area_m2 += area_m2(polygon);
        const Polygon& shown = rest.empty() ? whole : rest[0];
        const PlanePoint middle = std::accumulate(shown.begin(), shown.end(), PlanePoint(0)) /
                                  static_cast<double>(shown.size());
        result.middle = Vec3(origin_ + middle.x * axes_[0] + middle.y * axes_[1]);
        return result;
    }

    const RayScene& scene_;
    std::array<glm::dvec3, 2> axes_{};
    glm::dvec3 origin_{0};
    std::vector<Face> faces_;
    std::vector<Overlap> contacts_;
};

}  // namespace

CoplanarFaces::CoplanarFaces(const RayScene& scene, const ScenePlanes& planes,
                             const std::vector<bool>& is_omitted) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> members;  // plane, triangle
    for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
        const std::uint32_t plane = planes.of_triangle(t);
        if (plane != ScenePlanes::kNoPlane && !is_omitted[t] && !scene.moves(scene.triangle(t)))
            members.emplace_back(plane, t);
    }
    std::sort(members.begin(), members.end());
    Budget budget;
    for (auto from = members.begin(); from != members.end();) {
        const auto& first = scene.triangle(from->second);
        bool one_kind = true;
        auto to = from;
        for (; to != members.end() && to->first == from->first; ++to) {
            const auto& t = scene.triangle(to->second);
            one_kind = one_kind && t.material == first.material && t.object == first.object;
        }
        if (!one_kind) {
            const ScenePlanes::Plane& plane = planes[from->first];
            Plane faces(scene, plane, std::span(from, to));
            const auto found = faces.overlaps(budget);
            contacts_.insert(contacts_.end(), faces.contacts().begin(), faces.contacts().end());
            if (found && overlaps_.size() + found->size() <= kMostOverlaps) {
                overlaps_.insert(overlaps_.end(), found->begin(), found->end());
            } else if (!not_searched_) {
                not_searched_ = plane.reference;
            }
        }
        from = to;
    }
    if (overlaps_.empty()) return;
    std::stable_sort(overlaps_.begin(), overlaps_.end(),
                     [](const Overlap& a, const Overlap& b) { return a.covered < b.covered; });
    index_of_.assign(scene.triangle_count(), kNone);
    for (auto from = overlaps_.begin(); from != overlaps_.end();) {
        const auto to = std::find_if(from, overlaps_.end(),
                                     [&](const Overlap& o) { return o.covered != from->covered; });
        add(scene, {from, to});
        from = to;
    }
}

int CoplanarFaces::Grid::cell(int axis, float at_m) const {
    return std::clamp(static_cast<int>((at_m - low[axis]) * cells_per_m[axis]), 0, side - 1);
}

/// First and last cells along each axis.
auto CoplanarFaces::Grid::range(const Bounds& part) const -> std::array<std::array<int, 2>, 2> {
    return {{{cell(0, part.min[axes[0]]), cell(0, part.max[axes[0]])},
             {cell(1, part.min[axes[1]]), cell(1, part.max[axes[1]])}}};
}

void CoplanarFaces::add(const RayScene& scene, std::span<const Overlap> on_one_triangle) {
    const RayScene::Triangle& covered = scene.triangle(on_one_triangle[0].covered);
    const Vec3 n = glm::abs(covered.normal);
    Grid grid;
    grid.axes = n.x >= n.y && n.x >= n.z ? std::array{1, 2}
                : n.y >= n.z             ? std::array{0, 2}
                                         : std::array{0, 1};
    std::vector<Bounds> parts;
    for (const Overlap& overlap : on_one_triangle)
        parts.emplace_back().add(scene.triangle(overlap.heard).vertices);
    Bounds bounds;
    bounds.add(covered.vertices);
    // About one triangle in a cell, unless they are in many.
    grid.side = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(parts.size()))));
    for (std::size_t filled = 0;; filled = 0) {
        for (int k = 0; k < 2; ++k) {
            const int axis = grid.axes[static_cast<std::size_t>(k)];
            grid.low[k] = bounds.min[axis];
            grid.cells_per_m[k] = static_cast<float>(grid.side) /
                                  std::max(bounds.max[axis] - bounds.min[axis], 1e-6F);
        }
        for (const Bounds& part : parts) {
            const auto [x, y] = grid.range(part);
            filled += static_cast<std::size_t>((x[1] - x[0] + 1) * (y[1] - y[0] + 1));
        }
        if (filled <= kMostCells * parts.size()) break;
        grid.side = (grid.side + 1) / 2;
    }
    std::vector<std::vector<std::uint32_t>> cells(static_cast<std::size_t>(grid.side * grid.side));
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const auto [x, y] = grid.range(parts[i]);
        for (int row = y[0]; row <= y[1]; ++row) {
            for (int column = x[0]; column <= x[1]; ++column)
                cells[static_cast<std::size_t>(row * grid.side + column)].push_back(
                    on_one_triangle[i].heard);
        }
    }
    for (const auto& cell : cells) {
        grid.begin.push_back(static_cast<std::uint32_t>(grid.triangles.size()));
        grid.triangles.insert(grid.triangles.end(), cell.begin(), cell.end());
    }
    grid.begin.push_back(static_cast<std::uint32_t>(grid.triangles.size()));
    index_of_[on_one_triangle[0].covered] = static_cast<std::uint32_t>(grids_.size());
    grids_.push_back(std::move(grid));
}

double CoplanarFaces::covered_m2(std::uint32_t triangle) const {
    if (!is_covered(triangle)) return 0;
    const auto first = std::lower_bound(
        overlaps_.begin(), overlaps_.end(), triangle,
        [](const Overlap& overlap, std::uint32_t t) { return overlap.covered < t; });
    double sum_m2 = 0;
    for (auto o = first; o != overlaps_.end() && o->covered == triangle; ++o) sum_m2 += o->area_m2;
    return sum_m2;
}

std::span<const std::uint32_t> CoplanarFaces::candidates(std::uint32_t triangle,
                                                         const Vec3& point) const {
    if (!is_covered(triangle)) return {};
    const Grid& grid = grids_[index_of_[triangle]];
    const int x = grid.cell(0, point[grid.axes[0]]);
    const int y = grid.cell(1, point[grid.axes[1]]);
    const auto cell = static_cast<std::size_t>(y * grid.side + x);
    return std::span(grid.triangles)
        .subspan(grid.begin[cell], grid.begin[cell + 1] - grid.begin[cell]);
}

}  // namespace aula
