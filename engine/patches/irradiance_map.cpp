#include "engine/patches/irradiance_map.h"

#include <tsl/robin_map.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <tuple>

#include "engine/base/mix64.h"
#include "engine/base/sampling.h"
#include "engine/base/tolerances.h"
#include "engine/patches/cell_clipping.h"
#include "engine/patches/patch_index.h"

namespace aula {

namespace {

/// Triangles with an edge longer than this share of a patch are counted in pieces of this size. A
/// choice: the sixteen pieces of a full patch have 32 hits each (SoundReach).
constexpr float kPiece = 0.25F;

/// A group of small triangles grows over their edges until this number of hits is expected in it,
/// at the mean density of all patches. A choice: their standard error is a quarter.
constexpr double kGroupHits = 16;

/// Of more triangles at an edge the others are not joined with its neighbours. A choice, which
/// bounds the time: meshes have two.
constexpr std::ptrdiff_t kMostAtEdge = 16;

/// Prior: the number of hits at the patch's mean that every part is assumed to have, so that a part
/// with few hits does not deviate far from the mean. A choice: a group of kGroupHits is changed by
/// 1.6 % at most.
constexpr float kPriorHits = 0.25F;

/// Significance threshold of the squared hit densities, in standard deviations of a uniform patch.
/// A choice: of 10^5 uniform patches none exceeds it by chance. Half and twice of each of these
/// values change noise and energy by less than 1 %
/// (`aula-bench noise --estimator patch --rays 1000 scenes/museum.json`).
constexpr double kSignificance = 6;

/// No part, no patch.
constexpr std::uint32_t kNone = PatchIndex::kNone;

/// Of keys that are hashes.
struct KeyHash {
    std::size_t operator()(std::uint64_t key) const { return key; }
};

struct Part {
    float hits = 0;  // after the first reflection
    float area_m2 = 0;
    std::uint32_t patch = kNone;  // a patch that it lies in
};

/// A piece: the part of one side of a triangle within a cube.
struct Piece {
    std::uint32_t triangle = 0;
    bool back = false;
    std::array<std::int32_t, 3> cube{};

    std::size_t face() const { return 2 * std::size_t{triangle} + (back ? 1 : 0); }
};

}  // namespace

struct IrradianceMap::State {
    const RayScene& scene;
    float patch_m;
    std::vector<std::uint32_t> first_coincident;  // [triangle] the first with the same corners
    std::vector<std::uint32_t> part_of_face;      // [2 triangle + side] kNone: in pieces
    std::vector<Part> parts;
    tsl::robin_map<std::uint64_t, std::uint32_t, KeyHash> part_of_piece;
    std::vector<std::pair<std::uint32_t, Piece>> pieces;  // to compute the areas
    std::vector<float> hits;                              // [patch]
    std::vector<float> hits_per_m2;
    std::vector<char> nonuniform;

    State(const RayScene& rays, float patch_size_m) : scene(rays), patch_m(patch_size_m) {
        find_coincident();
        part_of_face.assign(2 * scene.triangle_count(), kNone);
        for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
            const RayScene::Triangle& triangle = scene.triangle(t);
            if (first_coincident[t] != t || scene.moves(triangle) || !is_small(triangle)) continue;
            for (std::uint32_t side = 0; side < 2; ++side) {
                part_of_face[2 * t + side] = static_cast<std::uint32_t>(parts.size());
                parts.push_back({.area_m2 = triangle.area_m2()});
            }
        }
    }

    /// Size of the pieces of large triangles.
    float piece_m() const { return kPiece * patch_m; }

    bool is_small(const RayScene::Triangle& t) const {
        return std::max({glm::distance(t.vertices[0], t.vertices[1]),
                         glm::distance(t.vertices[1], t.vertices[2]),
                         glm::distance(t.vertices[2], t.vertices[0])}) < piece_m();
    }

    /// Rays hit either of several coincident triangles: these count as one.
    void find_coincident() {
        tsl::robin_map<std::uint64_t, std::uint32_t, MixHash> first;
        first.reserve(scene.triangle_count());
        for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
            std::uint64_t corners = 0;
            // A moving triangle does not stay coincident with another.
            if (scene.moves(scene.triangle(t))) {
                first_coincident.push_back(t);
                continue;
            }
            for (const Vec3& v : scene.triangle(t).vertices) {
                corners += corner_key(v);
            }
            first_coincident.push_back(first.try_emplace(corners, t).first->second);
        }
    }

    std::array<std::int32_t, 3> cube_of(const Vec3& point) const {
        const Vec3 at = glm::floor(point / piece_m());
        return {static_cast<std::int32_t>(at.x), static_cast<std::int32_t>(at.y),
                static_cast<std::int32_t>(at.z)};
    }

    /// A hash, of which the table needs no other: it is computed for each hit.
    static std::uint64_t key_of(const Piece& p) {
        const auto unsigned_of = [](std::int32_t x) {
            return std::uint64_t{static_cast<std::uint32_t>(x)};
        };
        return mix64(mix64(p.face() << 32 ^ unsigned_of(p.cube[0])) +
                     (unsigned_of(p.cube[1]) << 32 ^ unsigned_of(p.cube[2])));
    }

    float area_of(const Piece& piece) const {
        const RayScene::Triangle& triangle = scene.triangle(piece.triangle);
        const Vec3 off = tolerances::kOffset_m * (piece.back ? -triangle.normal : triangle.normal);
        ClippedPolygon polygon;
        for (const Vec3& v : triangle.vertices) polygon.add(v + off);
        for (int axis = 0; axis < 3 && polygon.count() > 2; ++axis) {
            const auto low = static_cast<float>(piece.cube[static_cast<std::size_t>(axis)]);
            polygon = polygon.cut(axis, low * piece_m(), -1);
            if (polygon.count() > 2) polygon = polygon.cut(axis, (low + 1) * piece_m(), 1);
        }
        return polygon.count() > 2 ? polygon.area_m2() : 0;
    }

    /// The piece that contains a point.
    Piece piece_at(std::uint32_t triangle, const Vec3& point, const Vec3& normal) const {
        const std::uint32_t t = first_coincident[triangle];
        return {t, glm::dot(normal, scene.triangle(t).normal) < 0, cube_of(point)};
    }

    static std::uint64_t corner_key(const Vec3& v) {
        // -0 becomes 0.
        const Vec3 p = v + 0.0F;
        return derive_seed(1, std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                           std::bit_cast<std::uint32_t>(p.z));
    }

    Vec3 normal_of(std::size_t face) const {
        const Vec3& normal = scene.triangle(static_cast<std::uint32_t>(face / 2)).normal;
        return face % 2 == 0 ? normal : -normal;
    }

    /// An edge of a triangle; both directions have the same key.
    struct Edge {
        std::uint64_t key = 0;
        std::uint32_t triangle = 0;
        bool is_reversed = false;  // the key of its end is below that of its start
        std::uint8_t number = 0;   // of the triangle's edges

        bool operator<(const Edge& other) const {
            return std::tie(key, triangle, is_reversed) <
                   std::tie(other.key, other.triangle, other.is_reversed);
        }
    };

    std::array<Edge, 3> edges_of(std::uint32_t t) const {
        std::array<Edge, 3> edges;
        const auto& v = scene.triangle(t).vertices;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint64_t from = corner_key(v[k]);
            const std::uint64_t to = corner_key(v[(k + 1) % 3]);
            edges[k] = {from + to, t, to < from, static_cast<std::uint8_t>(k)};
        }
        return edges;
    }

    /// The edges of the small triangles: those of equal keys are neighbours.
    struct SmallEdges {
        std::vector<Edge> sorted;
        std::vector<std::uint32_t> first;  // [3 triangle + number] of the same key
        std::vector<char> is_reversed;     // [3 triangle + number]
    };

    SmallEdges edges_of_small() const {
        SmallEdges edges;
        for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
            if (part_of_face[2 * std::size_t{t}] == kNone) continue;
            for (const Edge& edge : edges_of(t)) edges.sorted.push_back(edge);
        }
        std::sort(edges.sorted.begin(), edges.sorted.end());
        edges.first.resize(3 * scene.triangle_count());
        edges.is_reversed.resize(edges.first.size());
        std::uint32_t first = 0;
        for (std::uint32_t i = 0; i < edges.sorted.size(); ++i) {
            const Edge& edge = edges.sorted[i];
            if (edge.key != edges.sorted[first].key) first = i;
            edges.first[3 * std::size_t{edge.triangle} + edge.number] = first;
            edges.is_reversed[3 * std::size_t{edge.triangle} + edge.number] = edge.is_reversed;
        }
        return edges;
    }

    /// The patch of the middle of each side of the small triangles.
    std::vector<std::uint32_t> patches_of_small(const IrradianceMap::PatchOf& patch_of) const {
        std::vector<std::uint32_t> patches(part_of_face.size(), kNone);
        for (std::size_t face = 0; face < part_of_face.size(); ++face) {
            if (part_of_face[face] == kNone) continue;
            const auto& v = scene.triangle(static_cast<std::uint32_t>(face / 2)).vertices;
            const Vec3 normal = normal_of(face);
            patches[face] =
                patch_of((v[0] + v[1] + v[2]) / 3.0F + tolerances::kOffset_m * normal, normal);
        }
        return patches;
    }

    /// The area on which kGroupHits are expected on the mean over all patches that are hit.
    double group_m2() const {
        const double all = std::accumulate(hits.begin(), hits.end(), 0.0);
        const auto hit = std::count_if(hits.begin(), hits.end(), [](float n) { return n > 0; });
        if (hit == 0) return 0;
        return kGroupHits * static_cast<double>(hit) / all * double{patch_m} * double{patch_m};
    }

    /// Joins small triangles of a patch that are connected. Of layers that lie on each other only
    /// one is hit: they thus stay apart.
    void join_small(const IrradianceMap::PatchOf& patch_of) {
        const SmallEdges edges = edges_of_small();
        const std::vector<std::uint32_t> patches = patches_of_small(patch_of);
        const double full_m2 = group_m2();
        std::vector<char> joined(part_of_face.size(), 0);
        std::vector<std::size_t> open;  // faces at the group's border
        const auto open_neighbours = [&](std::size_t face) {
            for (std::size_t k = 3 * (face / 2); k < 3 * (face / 2) + 3; ++k) {
                const auto first = edges.sorted.begin() + edges.first[k];
                for (auto at = first;
                     at != edges.sorted.end() && at->key == first->key && at - first < kMostAtEdge;
                     ++at) {
                    // Neighbours of the same orientation pass their edge in opposite directions.
                    const bool is_opposite = at->is_reversed != (edges.is_reversed[k] != 0);
                    const std::size_t side = is_opposite ? face % 2 : 1 - face % 2;
                    const std::size_t next = 2 * std::size_t{at->triangle} + side;
                    if (joined[next] || patches[next] != patches[face] ||
                        glm::dot(normal_of(face), normal_of(next)) <= 0) {
                        continue;
                    }
                    joined[next] = 1;
                    open.push_back(next);
                }
            }
        };
        for (std::size_t first = 0; first < part_of_face.size(); ++first) {
            if (patches[first] == kNone || joined[first]) continue;
            const std::uint32_t number = part_of_face[first];
            Part group{.patch = patches[first]};
            open.assign(1, first);
            joined[first] = 1;
            for (std::size_t i = 0; i < open.size(); ++i) {
                const std::size_t face = open[i];
                if (i > 0 && double{group.area_m2} >= full_m2) {
                    joined[face] = 0;
                    continue;
                }
                const Part& part = parts[part_of_face[face]];
                group.hits += part.hits;
                group.area_m2 += part.area_m2;
                part_of_face[face] = number;
                open_neighbours(face);
            }
            parts[number] = group;
        }
    }

    /// The part at a point, or a piece without hits.
    Part part_at(std::uint32_t triangle, const Vec3& point, const Vec3& facing_normal) const {
        const Piece piece = piece_at(triangle, point, facing_normal);
        const std::uint32_t part = part_of_face[piece.face()];
        if (part != kNone) return parts[part];
        const auto found = part_of_piece.find(key_of(piece));
        return found != part_of_piece.end() ? parts[found->second]
                                            : Part{.area_m2 = area_of(piece)};
    }

    /// The mean over the area A of the squared density of N hits, n of them in a part of area a,
    /// relative to the squared mean density, is estimated by A / N^2 sum n (n - 1) / a, a sum over
    /// pairs of hits. For uniform irradiance its expectation is 1 and its variance is 2 S / N^2 for
    /// S parts. A part that lies in two patches is counted in one, so one of the two factors N is
    /// the sum of the n.
    void find_nonuniform(std::span<const float> patch_area_m2) {
        std::vector<double> pairs(hits.size(), 0);
        std::vector<double> count(hits.size(), 0);
        std::vector<double> hits_of_parts(hits.size(), 0);
        hits_per_m2.assign(hits.size(), 0);
        for (std::size_t p = 0; p < hits.size(); ++p) {
            if (patch_area_m2[p] > 0) hits_per_m2[p] = hits[p] / patch_area_m2[p];
        }
        for (const Part& part : parts) {
            if (part.patch == kNone || !(part.area_m2 > 0) || !(part.hits > 0)) continue;
            const double expected = double{part.area_m2} * double{hits_per_m2[part.patch]};
            pairs[part.patch] += double{part.hits} * (double{part.hits} - 1) / double{part.area_m2};
            count[part.patch] += 1 / -std::expm1(-expected);
            hits_of_parts[part.patch] += double{part.hits};
        }
        nonuniform.assign(hits.size(), 0);
        for (std::size_t p = 0; p < hits.size(); ++p) {
            const double n = double{hits[p]};
            if (n < 2 || hits_of_parts[p] < 2) continue;
            const double squares = double{patch_area_m2[p]} * pairs[p] / (n * hits_of_parts[p]);
            nonuniform[p] = squares - 1 > kSignificance * std::sqrt(2 * count[p]) / n;
        }
    }
};

IrradianceMap::IrradianceMap(const RayScene& scene, float patch_size_m)
    : state_(std::make_unique<State>(scene, patch_size_m)) {}
IrradianceMap::~IrradianceMap() = default;
IrradianceMap::IrradianceMap(IrradianceMap&&) noexcept = default;

void IrradianceMap::add_hit(std::uint32_t patch, std::uint32_t triangle, const Vec3& point,
                            const Vec3& facing_normal) {
    State& s = *state_;
    const Piece piece = s.piece_at(triangle, point, facing_normal);
    std::uint32_t part = s.part_of_face[piece.face()];
    if (part == kNone) {
        const auto [entry, added] = s.part_of_piece.try_emplace(
            State::key_of(piece), static_cast<std::uint32_t>(s.parts.size()));
        part = entry->second;
        if (added) {
            s.parts.push_back({.patch = patch});
            s.pieces.emplace_back(part, piece);
        }
    }
    if (patch >= s.hits.size()) s.hits.resize(patch + 1, 0);
    s.hits[patch] += 1;
    s.parts[part].hits += 1;
}

void IrradianceMap::finish(std::span<const float> area_m2, const PatchOf& patch_of) {
    State& s = *state_;
    s.join_small(patch_of);
    s.hits.resize(area_m2.size(), 0);
    for (const auto& [part, piece] : s.pieces) s.parts[part].area_m2 = s.area_of(piece);
    s.pieces = {};
    s.find_nonuniform(area_m2);
}

float IrradianceMap::relative(std::uint32_t patch, std::uint32_t triangle, const Vec3& point,
                              const Vec3& facing_normal) const {
    const State& s = *state_;
    if (patch >= s.nonuniform.size() || !s.nonuniform[patch]) return 1;
    const Part part = s.part_at(triangle, point, facing_normal);
    return (part.hits + kPriorHits) / (part.area_m2 * s.hits_per_m2[patch] + kPriorHits);
}

}  // namespace aula
