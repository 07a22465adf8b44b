#include "engine/patches/irradiance_map.h"

#include <tsl/robin_map.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/base/mix64.h"
#include "engine/base/sampling.h"
#include "engine/patches/cell_clipping.h"

namespace aula {

namespace {

/// Triangles with an edge longer than this share of a patch are counted in pieces of this size.
constexpr float kPiece = 0.25F;

/// A group of small triangles grows until this number of hits is expected in it.
constexpr float kGroupHits = 16;

/// Prior: the number of hits at the patch's mean that every part is assumed to have, so that a part
/// with few hits does not deviate far from the mean.
constexpr float kPriorHits = 0.25F;

/// Significance threshold of the squared hit densities, in standard deviations of a uniform patch.
constexpr double kSignificance = 6;

constexpr std::uint32_t kNone = ~0U;

struct Part {
    float hits = 0;
    float area_m2 = 0;
    std::uint32_t patch = kNone;  // a patch that it lies in
};

/// A piece: the part of one side of a triangle within a cube.
struct Piece {
    std::uint32_t triangle = 0;
    bool back = false;
    std::array<std::int32_t, 3> cube{};
};

}  // namespace

struct IrradianceMap::State {
    const RayScene& scene;
    float piece_m;
    std::vector<std::uint32_t> first_coincident;  // [triangle] the first with the same corners
    std::vector<std::uint32_t> part_of_face;      // [2 triangle + side] kNone: in pieces
    std::vector<Part> parts;
    tsl::robin_map<std::uint64_t, std::uint32_t, MixHash> part_of_piece;
    std::vector<std::pair<std::uint32_t, Piece>> pieces;  // to compute the areas
    std::vector<float> hits;                              // [patch]
    std::vector<float> hits_per_m2;
    std::vector<char> nonuniform;

    State(const RayScene& rays, float patch_size_m) : scene(rays), piece_m(kPiece * patch_size_m) {
        find_coincident();
        part_of_face.assign(2 * scene.triangle_count(), kNone);
        for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
            const RayScene::Triangle& triangle = scene.triangle(t);
            if (first_coincident[t] != t || scene.moves(triangle) || !is_small(triangle)) continue;
            for (std::uint32_t side = 0; side < 2; ++side) {
                part_of_face[2 * t + side] = static_cast<std::uint32_t>(parts.size());
                parts.push_back({0, triangle.area_m2(), kNone});
            }
        }
    }

    bool is_small(const RayScene::Triangle& t) const {
        return std::max({glm::distance(t.vertices[0], t.vertices[1]),
                         glm::distance(t.vertices[1], t.vertices[2]),
                         glm::distance(t.vertices[2], t.vertices[0])}) < piece_m;
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
                corners += derive_seed(1, std::bit_cast<std::uint32_t>(v.x),
                                       std::bit_cast<std::uint32_t>(v.y),
                                       std::bit_cast<std::uint32_t>(v.z));
            }
            first_coincident.push_back(first.try_emplace(corners, t).first->second);
        }
    }

    std::array<std::int32_t, 3> cube_of(const Vec3& point) const {
        const Vec3 at = glm::floor(point / piece_m);
        return {static_cast<std::int32_t>(at.x), static_cast<std::int32_t>(at.y),
                static_cast<std::int32_t>(at.z)};
    }

    static std::uint64_t key_of(const Piece& p) {
        return derive_seed(p.triangle, p.back, p.cube[0], p.cube[1], p.cube[2]);
    }

    float area_of(const Piece& piece) const {
        const RayScene::Triangle& triangle = scene.triangle(piece.triangle);
        const Vec3 off = RayScene::kOffset_m * (piece.back ? -triangle.normal : triangle.normal);
        ClippedPolygon polygon;
        for (const Vec3& v : triangle.vertices) polygon.add(v + off);
        for (int axis = 0; axis < 3 && polygon.count() > 2; ++axis) {
            const auto low = static_cast<float>(piece.cube[static_cast<std::size_t>(axis)]);
            polygon = polygon.cut(axis, low * piece_m, -1);
            if (polygon.count() > 2) polygon = polygon.cut(axis, (low + 1) * piece_m, 1);
        }
        return polygon.count() > 2 ? polygon.area_m2() : 0;
    }

    /// The piece that contains a point.
    Piece piece_at(std::uint32_t triangle, const Vec3& point, const Vec3& normal) const {
        const std::uint32_t t = first_coincident[triangle];
        return {t, glm::dot(normal, scene.triangle(t).normal) < 0, cube_of(point)};
    }

    void join_small(std::span<const float> patch_area_m2,
                    const std::function<std::uint32_t(const Vec3&, const Vec3&)>& patch_of) {
        std::vector<std::array<std::uint32_t, 2>> open(patch_area_m2.size(), {kNone, kNone});
        std::vector<Part> joined;
        std::vector<std::uint32_t> new_number(parts.size(), kNone);
        const auto number = [&](std::uint32_t part) {
            if (new_number[part] == kNone) {
                new_number[part] = static_cast<std::uint32_t>(joined.size());
                joined.push_back(parts[part]);
            }
            return new_number[part];
        };
        for (std::size_t face = 0; face < part_of_face.size(); ++face) {
            std::uint32_t& part = part_of_face[face];
            if (part == kNone) continue;
            const RayScene::Triangle& t = scene.triangle(static_cast<std::uint32_t>(face / 2));
            const Vec3 normal = face % 2 == 0 ? t.normal : -t.normal;
            const std::uint32_t patch =
                patch_of((t.vertices[0] + t.vertices[1] + t.vertices[2]) / 3.0F +
                             RayScene::kOffset_m * normal,
                         normal);
            if (patch == kNone || patch >= hits.size() || !(hits[patch] > 0) ||
                !(patch_area_m2[patch] > 0)) {
                part = number(part);
                continue;
            }
            std::uint32_t& group = open[patch][face % 2];
            if (group == kNone) {
                part = group = number(part);
                joined[group].patch = patch;
            } else {
                joined[group].hits += parts[part].hits;
                joined[group].area_m2 += parts[part].area_m2;
                part = group;
            }
            if (joined[group].area_m2 * hits[patch] >= kGroupHits * patch_area_m2[patch]) {
                group = kNone;
            }
        }
        for (auto& [part, piece] : pieces) part = number(part);
        for (auto it = part_of_piece.begin(); it != part_of_piece.end(); ++it) {
            it.value() = number(it->second);
        }
        parts = std::move(joined);
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
    if (patch >= s.hits.size()) s.hits.resize(patch + 1, 0);
    s.hits[patch] += 1;
    const Piece piece = s.piece_at(triangle, point, facing_normal);
    std::uint32_t part = s.part_of_face[2 * piece.triangle + (piece.back ? 1 : 0)];
    if (part == kNone) {
        const auto [entry, added] = s.part_of_piece.try_emplace(
            State::key_of(piece), static_cast<std::uint32_t>(s.parts.size()));
        part = entry->second;
        if (added) {
            s.parts.push_back({0, 0, patch});
            s.pieces.emplace_back(part, piece);
        }
    }
    s.parts[part].hits += 1;
}

void IrradianceMap::finish(
    std::span<const float> area_m2,
    const std::function<std::uint32_t(const Vec3& point, const Vec3& facing_normal)>& patch_of) {
    State& s = *state_;
    s.hits.resize(area_m2.size(), 0);
    s.join_small(area_m2, patch_of);
    for (const auto& [part, piece] : s.pieces) s.parts[part].area_m2 = s.area_of(piece);
    s.pieces = {};
    s.find_nonuniform(area_m2);
}

float IrradianceMap::relative(std::uint32_t patch, std::uint32_t triangle, const Vec3& point,
                              const Vec3& facing_normal) const {
    const State& s = *state_;
    if (patch >= s.nonuniform.size() || !s.nonuniform[patch]) return 1;
    const Piece piece = s.piece_at(triangle, point, facing_normal);
    std::uint32_t part = s.part_of_face[2 * piece.triangle + (piece.back ? 1 : 0)];
    if (part == kNone) {
        const auto found = s.part_of_piece.find(State::key_of(piece));
        if (found == s.part_of_piece.end()) {
            // A piece without hits.
            return kPriorHits / (s.area_of(piece) * s.hits_per_m2[patch] + kPriorHits);
        }
        part = found->second;
    }
    const Part& p = s.parts[part];
    return (p.hits + kPriorHits) / (p.area_m2 * s.hits_per_m2[patch] + kPriorHits);
}

}  // namespace aula
