#include "engine/edges/edge_finder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <tuple>

#include "engine/base/mix64.h"
#include "engine/base/tolerances.h"
#include "engine/edges/scene_edges.h"
#include "engine/edges/welded_points.h"

namespace aula {

namespace {

using Point = glm::dvec3;
using Cell = glm::ivec3;

using tolerances::kOnFace_rad;
using tolerances::kSame_m;

/// Shorter sides have no direction: their ends may be off by kSame_m.
constexpr double kLeastSide_m = 5 * kSame_m;

// Edges below kShort_m diffract little: a third of a wavelength at 1 kHz. Those below kLong_m count
// in scenes of up to kFew edges. Choices: each frame of a new pair tests all edges for their
// detour.
constexpr double kShort_m = 0.1;
constexpr double kLong_m = 0.25;
constexpr std::size_t kFew = 2000;

/// Bends of curved surfaces: an octagonal column, whose bends are 45 degrees, is one.
constexpr double kCurvedBend_rad = 46 * std::numbers::pi / 180;

/// Width of their faces. A choice: larger ones are walls, whose edges are single bends.
constexpr double kCurvedFace_m = 1;

struct Face {
    std::array<std::uint32_t, 3> corners;
    std::uint32_t triangle;
    Point normal;
};

/// A side of one or more faces.
struct Side {
    Point start;
    Point end;
    std::uint32_t first_use = 0;  ///< of its uses
    std::uint32_t end_use = 0;

    double length_m() const { return glm::distance(start, end); }
};

/// A face at a side.
struct Use {
    std::uint32_t low;  ///< corners of the side
    std::uint32_t high;
    std::uint32_t face;
    std::uint32_t opposite;  ///< corner
};

/// The vector in a face perpendicular to an axis in it, away from a point on the axis.
Point away_from(const Point& axis, const Point& on_axis, const Face& face, const Point& opposite) {
    const Point across = glm::cross(face.normal, axis);
    return glm::dot(across, opposite - on_axis) < 0 ? -across : across;
}

/// Lines that the sides of triangles lie on, found by direction and position. A side joins a line
/// if both its ends are near it. Sides that overlap within the tolerance have the same line.
class SideLines {
 public:
    explicit SideLines(std::size_t sides) : table_(4 * sides) {}

    /// The line of a side. Without one, adds a line if `found` is true, else returns nothing.
    std::optional<std::uint32_t> join(const Side& side, bool found) {
        const double length_m = side.length_m();
        const Point axis = (side.end - side.start) / length_m;
        // The direction of a short side is uncertain, unless its ends are near the line.
        const double tolerance_m = std::min(kSame_m, kSlope * length_m);
        std::optional<std::uint32_t> line;
        const double turn = 2 * tolerance_m / length_m;
        for (const double sign : {1.0, -1.0}) {
            const Point low = sign * axis / kTurn + 0.5 - turn / kTurn;
            const Point high = sign * axis / kTurn + 0.5 + turn / kTurn;
            for_cells(low, high, 1, [&](const Cell& turned) {
                visit_cells(side, turned, tolerance_m, [&](std::uint64_t cell) {
                    table_.any(cell, [&](std::uint32_t candidate) {
                        candidate = root(candidate);
                        if (line == candidate) return false;
                        if (!is_near(side.start, candidate, tolerance_m) ||
                            !is_near(side.end, candidate, tolerance_m)) {
                            return false;
                        }
                        if (line) parent_[std::max(*line, candidate)] = std::min(*line, candidate);
                        line = line ? std::min(*line, candidate) : candidate;
                        return false;
                    });
                });
            });
        }
        if (!found) return line;
        if (!line) {
            line = static_cast<std::uint32_t>(lines_.size());
            lines_.push_back({0.5 * (side.start + side.end), axis});
            parent_.push_back(*line);
        }
        const Cell turned(glm::floor(axis / kTurn + 0.5));
        visit_cells(side, turned, 0, [&](std::uint64_t cell) {
            const auto is_line = [&](std::uint32_t other) { return root(other) == *line; };
            if (!table_.any(cell, is_line)) table_.add(cell, *line);
        });
        return line;
    }

    std::uint32_t root(std::uint32_t line) const {
        while (parent_[line] != line) line = parent_[line];
        return line;
    }

    struct Line {
        Point origin;
        Point axis;
    };
    const Line& operator[](std::uint32_t line) const { return lines_[line]; }

 private:
    /// Of a side to its line, a choice: a little above the angle between faces that are one.
    static constexpr double kSlope = 0.02;
    static_assert(kSlope > kOnFace_rad);

    // Cells of directions, and of the positions across them. A choice: a side covers few, and few
    // lines share one.
    static constexpr double kTurn = 0.1;
    static constexpr double kCell_m = 0.1;

    bool is_near(const Point& p, std::uint32_t line, double tolerance_m) const {
        return glm::length(glm::cross(p - lines_[line].origin, lines_[line].axis)) <= tolerance_m;
    }

    /// Visits the cells of a side, seen along the central direction of a cell of directions. A side
    /// deviates from it by at most 5 degrees and covers few cells.
    template <class Visit>
    void visit_cells(const Side& side, const Cell& turned, double margin_m,
                     const Visit& visit) const {
        if (turned == Cell(0)) return;
        const Point along = glm::normalize(Point(turned));
        const auto across = [&](const Point& p) { return p - glm::dot(p, along) * along; };
        const Point from = across(side.start);
        const Point to = across(side.end);
        const int steps = 1 + static_cast<int>(glm::distance(from, to) / kCell_m);
        const std::uint64_t seed = CellTable::hash(turned);
        for (int i = 0; i < steps; ++i) {
            const Point a = from + (to - from) * (static_cast<double>(i) / steps);
            const Point b = from + (to - from) * (static_cast<double>(i + 1) / steps);
            for_cells(glm::min(a, b) - margin_m, glm::max(a, b) + margin_m, kCell_m,
                      [&](const Cell& cell) { visit(CellTable::hash(cell, seed)); });
        }
    }

    CellTable table_;
    std::vector<Line> lines_;
    std::vector<std::uint32_t> parent_;  ///< [line] of a line that was merged with another
};

/// The sides of a soup of triangles, and the faces at each.
class Soup {
 public:
    Soup(const RayScene& scene, std::span<const std::uint32_t> triangles)
        : points_(3 * triangles.size()) {
        Point low(std::numeric_limits<double>::infinity());
        Point high = -low;
        for (const std::uint32_t t : triangles) {
            for (const Vec3& v : scene.triangle(t).vertices) {
                low = glm::min(low, Point(v));
                high = glm::max(high, Point(v));
            }
        }
        if (!(glm::length(high - low) >= double{SceneEdges::kSmall_m})) return;
        middle_ = 0.5 * (low + high);
        add_faces(scene, triangles);
        add_sides();
    }

    std::vector<DiffractionEdge> edges() {
        std::vector<std::uint32_t> bent;
        std::vector<std::uint32_t> flat;
        for (std::uint32_t s = 0; s < sides_.size(); ++s) {
            if (sides_[s].length_m() < kLeastSide_m) continue;
            (is_flat(sides_[s]) ? flat : bent).push_back(s);
        }
        // The longest sides have the most exact directions.
        std::vector<double> length_m(sides_.size());
        std::transform(sides_.begin(), sides_.end(), length_m.begin(),
                       [](const Side& side) { return side.length_m(); });
        std::stable_sort(bent.begin(), bent.end(), [&](std::uint32_t a, std::uint32_t b) {
            return length_m[a] > length_m[b];
        });
        SideLines lines(bent.size());
        std::vector<std::pair<std::uint32_t, std::uint32_t>> members;  // line, side
        for (const std::uint32_t s : bent) members.emplace_back(*lines.join(sides_[s], true), s);
        // A flat side may still close the sectors of others on its line.
        for (const std::uint32_t s : flat) {
            if (const auto line = lines.join(sides_[s], false)) members.emplace_back(*line, s);
        }
        for (auto& [line, side] : members) line = lines.root(line);
        std::sort(members.begin(), members.end());

        std::vector<DiffractionEdge> edges;
        for (auto from = members.begin(); from != members.end();) {
            const auto to = std::find_if(from, members.end(),
                                         [&](const auto& m) { return m.first != from->first; });
            sweep(lines[from->first], {from, to}, edges);
            from = to;
        }
        for (DiffractionEdge& edge : edges) edge.start += middle_;
        return edges;
    }

 private:
    using Members = std::span<const std::pair<std::uint32_t, std::uint32_t>>;

    void add_faces(const RayScene& scene, std::span<const std::uint32_t> triangles) {
        for (const std::uint32_t t : triangles) {
            Face face{.corners = {}, .triangle = t, .normal = Point(0)};
            std::array<Point, 3> p;
            for (std::size_t k = 0; k < 3; ++k) {
                p[k] = Point(scene.triangle(t).vertices[k]) - middle_;
            }
            const double longest_m = std::max(
                {glm::distance(p[0], p[1]), glm::distance(p[1], p[2]), glm::distance(p[2], p[0])});
            const Point normal = glm::cross(p[1] - p[0], p[2] - p[0]);
            const double twice_area_m2 = glm::length(normal);
            // The sides of a thinner triangle lie on one line.
            if (!(twice_area_m2 > longest_m * kSame_m)) continue;
            face.normal = normal / twice_area_m2;
            for (std::size_t k = 0; k < 3; ++k) face.corners[k] = points_.add(p[k]);
            if (face.corners[0] == face.corners[1] || face.corners[1] == face.corners[2] ||
                face.corners[2] == face.corners[0]) {
                continue;
            }
            faces_.push_back(face);
        }
        // Coincident faces: a wall that is modelled from both sides.
        const auto key = [](const Face& face) {
            auto corners = face.corners;
            std::sort(corners.begin(), corners.end());
            return corners;
        };
        std::stable_sort(faces_.begin(), faces_.end(),
                         [&](const Face& a, const Face& b) { return key(a) < key(b); });
        faces_.erase(std::unique(faces_.begin(), faces_.end(),
                                 [&](const Face& a, const Face& b) { return key(a) == key(b); }),
                     faces_.end());
    }

    void add_sides() {
        uses_.reserve(3 * faces_.size());
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            const auto& c = faces_[f].corners;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = c[k];
                const std::uint32_t b = c[(k + 1) % 3];
                uses_.push_back({std::min(a, b), std::max(a, b), f, c[(k + 2) % 3]});
            }
        }
        std::sort(uses_.begin(), uses_.end(), [](const Use& a, const Use& b) {
            return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face);
        });
        for (std::uint32_t u = 0; u < uses_.size(); ++u) {
            const bool same =
                u > 0 && uses_[u - 1].low == uses_[u].low && uses_[u - 1].high == uses_[u].high;
            if (!same) {
                sides_.push_back({.start = points_[uses_[u].low],
                                  .end = points_[uses_[u].high],
                                  .first_use = u});
            }
            sides_.back().end_use = u + 1;
        }
    }

    bool is_flat(const Side& side) const {
        if (side.end_use - side.first_use != 2) return false;
        const Point axis = glm::normalize(side.end - side.start);
        const auto away = [&](const Use& use) {
            return away_from(axis, side.start, faces_[use.face], points_[use.opposite]);
        };
        return glm::dot(away(uses_[side.first_use]), away(uses_[side.first_use + 1])) <
               -std::cos(kOnFace_rad);
    }

    /// A face about a line.
    struct FaceAngle {
        double angle_rad;
        std::uint32_t triangle;
    };

    /// An open sector between two faces about a line, from the first to the second.
    struct Sector {
        double first_rad = 0;
        double second_rad = 0;
        std::array<std::uint32_t, 2> triangles{};

        double open_rad() const { return second_rad - first_rad; }
    };

    /// The widest sector between faces about a line. Its open angle is 0 if none is above pi.
    static Sector widest(std::vector<FaceAngle>& faces) {
        if (faces.empty()) return {};
        std::sort(faces.begin(), faces.end(), [](const FaceAngle& a, const FaceAngle& b) {
            return std::tie(a.angle_rad, a.triangle) < std::tie(b.angle_rad, b.triangle);
        });
        Sector open{faces.back().angle_rad,
                    faces.front().angle_rad + 2 * std::numbers::pi,
                    {faces.back().triangle, faces.front().triangle}};
        for (std::size_t i = 1; i < faces.size(); ++i) {
            const Sector between{faces[i - 1].angle_rad,
                                 faces[i].angle_rad,
                                 {faces[i - 1].triangle, faces[i].triangle}};
            if (between.open_rad() > open.open_rad()) open = between;
        }
        if (open.open_rad() < std::numbers::pi + kOnFace_rad) return {};
        // Faces within the tolerance belong to one wall.
        if (open.open_rad() > 2 * std::numbers::pi - kOnFace_rad)
            open.second_rad = open.first_rad + 2 * std::numbers::pi;
        return open;
    }

    /// Adds the edges on a line.
    void sweep(const SideLines::Line& line, Members members,
               std::vector<DiffractionEdge>& edges) const {
        struct Interval {
            double from_m;
            double to_m;
            std::uint32_t side;
        };
        std::vector<Interval> intervals;
        std::vector<double> cuts_m;
        for (const auto& [_, s] : members) {
            const double a_m = glm::dot(sides_[s].start - line.origin, line.axis);
            const double b_m = glm::dot(sides_[s].end - line.origin, line.axis);
            intervals.push_back({std::min(a_m, b_m), std::max(a_m, b_m), s});
            cuts_m.insert(cuts_m.end(), {a_m, b_m});
        }
        std::sort(cuts_m.begin(), cuts_m.end());
        std::sort(intervals.begin(), intervals.end(), [](const Interval& a, const Interval& b) {
            return std::tie(a.from_m, a.side) < std::tie(b.from_m, b.side);
        });
        const Point x = glm::normalize(
            glm::cross(line.axis, std::abs(line.axis.x) < 0.5 ? Point(1, 0, 0) : Point(0, 1, 0)));
        const Point y = glm::cross(line.axis, x);

        std::vector<Interval> active;
        std::vector<FaceAngle> faces;
        auto next = intervals.begin();
        Sector last;
        double last_end_m = 0;
        for (std::size_t i = 1; i < cuts_m.size(); ++i) {
            const double from_m = cuts_m[i - 1];
            const double to_m = cuts_m[i];
            if (to_m - from_m < 2 * kSame_m) continue;  // a gap within the tolerance
            const double middle_m = 0.5 * (from_m + to_m);
            while (next != intervals.end() && next->from_m < middle_m) active.push_back(*next++);
            std::erase_if(active, [&](const Interval& a) { return a.to_m < middle_m; });
            faces.clear();
            for (const Interval& a : active) {
                for (std::uint32_t u = sides_[a.side].first_use; u < sides_[a.side].end_use; ++u) {
                    const Face& face = faces_[uses_[u].face];
                    const Point away =
                        away_from(line.axis, line.origin, face, points_[uses_[u].opposite]);
                    faces.push_back(
                        {std::atan2(glm::dot(away, y), glm::dot(away, x)), face.triangle});
                }
            }
            const Sector open = widest(faces);
            const auto same = [](double a_rad, double b_rad) {
                return std::abs(std::remainder(a_rad - b_rad, 2 * std::numbers::pi)) < kOnFace_rad;
            };
            if (open.open_rad() > 0) {
                const bool continues = last.open_rad() > 0 && from_m - last_end_m < 2 * kSame_m &&
                                       same(open.first_rad, last.first_rad) &&
                                       same(open.second_rad, last.second_rad);
                if (continues) {
                    edges.back().length_m += to_m - last_end_m;
                } else {
                    edges.push_back(
                        {.start = line.origin + from_m * line.axis,
                         .axis = line.axis,
                         .first_face = std::cos(open.first_rad) * x + std::sin(open.first_rad) * y,
                         .length_m = to_m - from_m,
                         .open_angle_rad = open.open_rad(),
                         .triangles = open.triangles});
                }
            }
            last = open;
            last_end_m = to_m;
        }
    }

    Point middle_{0};
    WeldedPoints points_;  ///< relative to middle_
    std::vector<Face> faces_;
    std::vector<Use> uses_;  ///< by side
    std::vector<Side> sides_;
};

/// A corner of a triangle at a face of an edge.
struct EdgeCorner {
    std::uint64_t position;  ///< hash
    std::uint32_t triangle;
    std::uint32_t edge;
};

/// Marks the edges of curved surfaces: nearly parallel ones of small bends at both sides of a
/// narrow flat face, which may consist of two triangles.
void mark_curved(const RayScene& scene, std::vector<DiffractionEdge>& edges) {
    const auto position_of = [](const Vec3& v) {
        std::uint64_t hash = 0;
        for (const float x : {v.x, v.y, v.z}) hash = mix64(hash ^ std::bit_cast<std::uint32_t>(x));
        return hash;
    };
    const auto before = [](const EdgeCorner& a, const EdgeCorner& b) {
        return std::tie(a.position, a.triangle, a.edge) < std::tie(b.position, b.triangle, b.edge);
    };
    std::vector<EdgeCorner> corners;
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
        if (edges[e].open_angle_rad > std::numbers::pi + kCurvedBend_rad) continue;
        for (const std::uint32_t t : edges[e].triangles) {
            for (const Vec3& v : scene.triangle(t).vertices)
                corners.push_back({position_of(v), t, e});
        }
    }
    std::sort(corners.begin(), corners.end(), before);
    const auto is_beside = [&](const EdgeCorner& a, const EdgeCorner& b) {
        const DiffractionEdge& edge = edges[a.edge];
        const DiffractionEdge& other = edges[b.edge];
        const RayScene::Triangle& face = scene.triangle(a.triangle);
        const RayScene::Triangle& other_face = scene.triangle(b.triangle);
        const Point across = other.point(other.length_m / 2) - edge.start;
        return a.edge != b.edge &&
               std::abs(double{glm::dot(face.normal, other_face.normal)}) > std::cos(kOnFace_rad) &&
               edge.is_along(other) && glm::length(glm::cross(across, edge.axis)) < kCurvedFace_m;
    };
    for (auto from = corners.begin(); from != corners.end();) {
        const auto to = std::find_if(
            from, corners.end(), [&](const EdgeCorner& c) { return c.position != from->position; });
        for (auto a = from; a != to; ++a) {
            edges[a->edge].is_curved =
                edges[a->edge].is_curved ||
                std::any_of(from, to, [&](const EdgeCorner& b) { return is_beside(*a, b); });
        }
        from = to;
    }
}

}  // namespace

std::vector<DiffractionEdge> find_edges(const RayScene& scene,
                                        std::span<const std::uint32_t> triangles) {
    std::vector<DiffractionEdge> edges = Soup(scene, triangles).edges();
    const auto longer = [](const DiffractionEdge& a, const DiffractionEdge& b) {
        return std::tie(b.length_m, a.start.x, a.start.y, a.start.z) <
               std::tie(a.length_m, b.start.x, b.start.y, b.start.z);
    };
    std::sort(edges.begin(), edges.end(), longer);
    // Edges that are shorter than kLong_m fill up to kFew.
    const auto shorter_than = [&](double length_m) {
        const auto first =
            std::find_if(edges.begin(), edges.end(),
                         [&](const DiffractionEdge& edge) { return edge.length_m < length_m; });
        return static_cast<std::size_t>(first - edges.begin());
    };
    edges.resize(std::min(shorter_than(kShort_m), std::max(shorter_than(kLong_m), kFew)));
    std::sort(edges.begin(), edges.end(), [](const DiffractionEdge& a, const DiffractionEdge& b) {
        return std::tie(a.start.x, a.start.y, a.start.z, a.length_m) <
               std::tie(b.start.x, b.start.y, b.start.z, b.length_m);
    });
    mark_curved(scene, edges);
    return edges;
}

}  // namespace aula
