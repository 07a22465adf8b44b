#include "engine/patch_grid.h"

#include <tsl/robin_map.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/multiversion.h"
#include "engine/room_survey.h"
#include "engine/sampling.h"

namespace aula {

namespace {

constexpr int kSamplesPerPatch = 16;  // on a full cell
constexpr int kReachRays = 4;         // tries to get from a sample to where sound has been
constexpr int kFloodPaths = 4096;
constexpr int kFloodBounces = 32;
constexpr int kFloodRounds = 12;
constexpr std::size_t kChunk = 1024;  // samples of a job

struct MixHash {
    std::size_t operator()(std::uint64_t key) const { return mix64(key); }
};

/// The key of a cell of the grid: 20 bits for each coordinate and the dominant direction of a
/// normal; without branches.
inline std::uint64_t cell_key(const Vec3& point, const Vec3& normal, float cells_per_m) {
    const Vec3 size(std::abs(normal.x), std::abs(normal.y), std::abs(normal.z));
    const bool along_x = size.x >= size.y && size.x >= size.z;
    const bool along_y = size.y >= size.z;
    const std::int32_t axis = along_x ? 0 : along_y ? 2 : 4;
    const float component = along_x ? normal.x : along_y ? normal.y : normal.z;
    const std::int32_t direction = axis + (component > 0 ? 0 : 1);
    constexpr std::int32_t kBias = 1 << 19;
    const auto cell = [cells_per_m](float x_m) {
        const float x = x_m * cells_per_m;
        const auto toward_zero = static_cast<std::int32_t>(x);
        const std::int32_t below = static_cast<float>(toward_zero) > x ? 1 : 0;
        return static_cast<std::uint64_t>(static_cast<std::uint32_t>(toward_zero - below + kBias) &
                                          0xfffffU);
    };
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(direction)) << 60 |
           cell(point.x) << 40 | cell(point.y) << 20 | cell(point.z);
}

AULA_MULTIVERSION
void cell_keys(const LanePoints& points, const LanePoints& normals, const Vec3& origin,
               float cells_per_m, std::array<std::uint64_t, kLanes>& keys) {
    for (std::size_t i = 0; i < kLanes; ++i) {
        keys[i] =
            cell_key(Vec3(points.x[i] - origin.x, points.y[i] - origin.y, points.z[i] - origin.z),
                     Vec3(normals.x[i], normals.y[i], normals.z[i]), cells_per_m);
    }
}

/// A convex polygon that a triangle is clipped to: three corners and one more for each of six cuts.
struct Polygon {
    std::array<Vec3, 9> corner;
    int count = 0;

    void add(const Vec3& p) { corner[static_cast<std::size_t>(count++)] = p; }
    const Vec3& at(int i) const { return corner[static_cast<std::size_t>(i)]; }

    float area_m2() const {
        Vec3 sum(0);
        for (int i = 2; i < count; ++i) sum += glm::cross(at(i - 1) - at(0), at(i) - at(0));
        return glm::length(sum) / 2;
    }
};

/// The part of a polygon where sign * (x_axis - at) <= 0.
Polygon cut(const Polygon& polygon, int axis, float at, float sign) {
    Polygon kept;
    for (int i = 0; i < polygon.count; ++i) {
        const Vec3& a = polygon.at(i);
        const Vec3& b = polygon.at((i + 1) % polygon.count);
        const float da = sign * (a[axis] - at);
        const float db = sign * (b[axis] - at);
        if (da <= 0) kept.add(a);
        if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
            kept.add(a + (b - a) * (da / (da - db)));
        }
    }
    return kept;
}

/// Calls `visit(middle of the cell, polygon)` for the part of a polygon in every cell it meets.
template <typename Visit>
void for_each_cell(const Polygon& polygon, float cell_m, int axis, Vec3 middle,
                   const Visit& visit) {
    if (axis == 3) {
        visit(middle, polygon);
        return;
    }
    float low = polygon.at(0)[axis];
    float high = low;
    for (int i = 1; i < polygon.count; ++i) {
        low = std::min(low, polygon.at(i)[axis]);
        high = std::max(high, polygon.at(i)[axis]);
    }
    const auto first = static_cast<int>(std::floor(low / cell_m));
    const auto last = static_cast<int>(std::floor(high / cell_m));
    for (int k = first; k <= last; ++k) {
        const auto border_m = static_cast<float>(k) * cell_m;
        Polygon part = polygon;
        if (k > first) part = cut(part, axis, border_m, -1);
        if (k < last && part.count > 2) part = cut(part, axis, border_m + cell_m, 1);
        if (part.count < 3) continue;
        middle[axis] = border_m + 0.5F * cell_m;
        for_each_cell(part, cell_m, axis + 1, middle, visit);
    }
}

}  // namespace

struct PatchGrid::State {
    const RayScene& scene;
    WorkerPool& workers;
    std::uint64_t seed;
    float cell_m;
    Vec3 origin{0};  // cells count from the lowest corner of the scene
    tsl::robin_map<std::uint64_t, std::uint32_t, MixHash> patch_of_cell;
    std::vector<float> static_area_m2;  // of objects that stand
    std::vector<float> area_m2;         // of all
    std::vector<char> reached;          // by the flood
    std::vector<Cell> cells;
    std::size_t reached_count = 0;

    State(const RayScene& rays, WorkerPool& pool, std::uint64_t sample_seed, float patch_size_m)
        : scene(rays), workers(pool), seed(sample_seed) {
        Vec3 low(std::numeric_limits<float>::infinity());
        Vec3 high = -low;
        for (const RayScene::Triangle& triangle : rays.triangles()) {
            for (const Vec3& v : triangle.vertices) {
                low = glm::min(low, v);
                high = glm::max(high, v);
            }
        }
        if (rays.triangle_count() > 0) origin = low;
        const Vec3 extent = rays.triangle_count() > 0 ? high - low : Vec3(0);
        // A key has 20 bits for each coordinate, of which moving objects may need some.
        cell_m = std::max(patch_size_m,
                          std::max({extent.x, extent.y, extent.z}) / static_cast<float>(1 << 17));
    }

    struct Sample {
        Vec3 point;  // on the surface
        std::uint32_t triangle = 0;
        std::uint32_t patch = 0;
        float area_m2 = 0;
        bool back = false;
    };

    std::uint64_t key(const Vec3& point, const Vec3& normal) const {
        return cell_key(point - origin, normal, 1 / cell_m);
    }

    std::uint32_t patch_at(const Vec3& point, const Vec3& normal) {
        const auto [entry, added] = patch_of_cell.try_emplace(
            key(point, normal), static_cast<std::uint32_t>(area_m2.size()));
        if (added) {
            static_area_m2.push_back(0);
            area_m2.push_back(0);
            reached.push_back(0);
            cells.push_back(cell_at(point, entry->first >> 60));
        }
        return entry->second;
    }

    Cell cell_at(const Vec3& point, std::uint64_t direction) const {
        Cell cell;
        cell.middle = origin + (glm::floor((point - origin) / cell_m) + 0.5F) * cell_m;
        cell.direction[static_cast<int>(direction / 2)] = direction % 2 == 0 ? 1.0F : -1.0F;
        return cell;
    }

    /// Cells of both sides of a triangle, sampled in proportion to area.
    void sample(std::uint32_t t, std::vector<Sample>& samples) {
        const RayScene::Triangle& triangle = scene.triangle(t);
        if (triangle.normal == Vec3(0)) return;
        RandomStream random(derive_seed(seed, t));
        for (const bool back : {false, true}) {
            const Vec3 normal = back ? -triangle.normal : triangle.normal;
            Polygon whole;
            for (const Vec3& v : triangle.vertices)
                whole.add(v - origin + RayScene::kOffset_m * normal);
            for_each_cell(whole, cell_m, 0, Vec3(0), [&](const Vec3& middle, const Polygon& part) {
                const float area = part.area_m2();
                if (!(area > 0)) return;
                const std::uint32_t patch = patch_at(origin + middle, normal);
                const int count = std::clamp(
                    static_cast<int>(std::ceil(kSamplesPerPatch * area / (cell_m * cell_m))), 1,
                    kSamplesPerPatch);
                for (int i = 0; i < count; ++i) {
                    samples.push_back(
                        {origin + point_in(part, random) - RayScene::kOffset_m * normal, t, patch,
                         area / static_cast<float>(count), back});
                }
            });
        }
    }

    static Vec3 point_in(const Polygon& polygon, RandomStream& random) {
        // A triangle of the fan by area, then a point in it.
        float rest = random.uniform() * polygon.area_m2();
        int corner = 2;
        for (; corner < polygon.count - 1; ++corner) {
            const float area = glm::length(glm::cross(polygon.at(corner - 1) - polygon.at(0),
                                                      polygon.at(corner) - polygon.at(0))) /
                               2;
            if (rest < area) break;
            rest -= area;
        }
        auto [u, v] = random.uniform_2d();
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        return polygon.at(0) + u * (polygon.at(corner - 1) - polygon.at(0)) +
               v * (polygon.at(corner) - polygon.at(0));
    }

    /// Marks the patches that sound from `inside` gets to, until a round finds hardly more.
    void flood_from(std::span<const Vec3> inside) {
        for (int round = 0; round < kFloodRounds; ++round) {
            const std::size_t before = reached_count;
            flood(scene, inside, kFloodPaths, kFloodBounces, derive_seed(seed, 1 << 30, round),
                  [&](const Ray& ray, const Hit& hit) {
                      if (!hit.any()) return;
                      const auto found =
                          patch_of_cell.find(key(scene.point(hit, ray.direction),
                                                 scene.facing_normal(hit, ray.direction)));
                      if (found == patch_of_cell.end() || reached[found->second]) return;
                      reached[found->second] = 1;
                      ++reached_count;
                  });
            if (reached_count - before <= reached_count / 100) break;
        }
    }

    /// Adds the area of every sample that sound can reach.
    void add_reachable(const std::vector<Sample>& samples, std::vector<float>& areas) {
        std::vector<char> counts(samples.size(), 0);
        workers.run((samples.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
            const std::size_t first = chunk * kChunk;
            const std::size_t count = std::min(kChunk, samples.size() - first);
            test_samples(std::span(samples).subspan(first, count),
                         std::span(counts).subspan(first, count),
                         RandomStream(derive_seed(seed, 1 << 29, chunk)));
        });
        for (std::size_t i = 0; i < samples.size(); ++i) {
            if (counts[i]) areas[samples[i].patch] += samples[i].area_m2;
        }
    }

    void test_samples(std::span<const Sample> samples, std::span<char> counts,
                      RandomStream random) const {
        const auto normal_of = [&](const Sample& s) {
            const Vec3& n = scene.triangle(s.triangle).normal;
            return s.back ? -n : n;
        };
        // Of faces that coincide only the one that a ray meets counts.
        constexpr float kAbove_m = 1e-3F;
        std::vector<Ray> rays(samples.size());
        std::vector<Hit> hits(samples.size());
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const Vec3 n = normal_of(samples[i]);
            rays[i] = {samples[i].point + kAbove_m * n, -n, 2 * kAbove_m};
        }
        scene.intersect(rays, hits);
        std::vector<std::size_t> open;  // samples that have not got to the sound yet
        for (std::size_t i = 0; i < samples.size(); ++i) {
            if (hits[i].triangle == samples[i].triangle) open.push_back(i);
        }
        for (int attempt = 0; attempt < kReachRays && !open.empty(); ++attempt) {
            rays.resize(open.size());
            hits.resize(open.size());
            for (std::size_t i = 0; i < open.size(); ++i) {
                const Vec3 n = normal_of(samples[open[i]]);
                rays[i] = {samples[open[i]].point + RayScene::kOffset_m * n,
                           lambert_direction(n, random.uniform_2d())};
            }
            scene.intersect(rays, hits);
            std::size_t left = 0;
            for (std::size_t i = 0; i < open.size(); ++i) {
                if (sound_at(rays[i], hits[i])) {
                    counts[open[i]] = 1;
                } else {
                    open[left++] = open[i];
                }
            }
            open.resize(left);
        }
    }

    /// True if a ray got to where sound is: out into the open, to a reached patch, or to an object
    /// that moves.
    bool sound_at(const Ray& ray, const Hit& hit) const {
        if (!hit.any() || scene.moves(scene.triangle(hit.triangle))) return true;
        const auto found = patch_of_cell.find(
            key(scene.point(hit, ray.direction), scene.facing_normal(hit, ray.direction)));
        return found != patch_of_cell.end() && reached[found->second];
    }
};

PatchGrid::PatchGrid(const RayScene& scene, float patch_size_m, std::span<const Vec3> inside,
                     std::uint64_t seed, WorkerPool& workers)
    : state_(std::make_unique<State>(scene, workers, seed, patch_size_m)) {
    std::vector<State::Sample> standing;
    std::vector<State::Sample> moving;
    for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
        state_->sample(t, scene.moves(scene.triangle(t)) ? moving : standing);
    }
    state_->flood_from(inside);
    state_->add_reachable(standing, state_->static_area_m2);
    state_->area_m2 = state_->static_area_m2;
    state_->add_reachable(moving, state_->area_m2);
}

PatchGrid::~PatchGrid() = default;

void PatchGrid::scene_moved() {
    std::vector<State::Sample> moving;
    for (std::uint32_t t = 0; t < state_->scene.triangle_count(); ++t) {
        if (state_->scene.moves(state_->scene.triangle(t))) state_->sample(t, moving);
    }
    state_->area_m2 = state_->static_area_m2;
    state_->add_reachable(moving, state_->area_m2);
}

std::uint32_t PatchGrid::find(const Vec3& point, const Vec3& facing_normal) const {
    const auto found = state_->patch_of_cell.find(state_->key(point, facing_normal));
    return found == state_->patch_of_cell.end() ? kNone : found->second;
}

void PatchGrid::find(const LanePoints& points, const LanePoints& facing_normals, std::size_t count,
                     std::array<std::uint32_t, kLanes>& patches) const {
    alignas(64) std::array<std::uint64_t, kLanes> keys;
    cell_keys(points, facing_normals, state_->origin, 1 / state_->cell_m, keys);
    for (std::size_t i = 0; i < count; ++i) {
        const auto found = state_->patch_of_cell.find(keys[i]);
        patches[i] = found == state_->patch_of_cell.end() ? kNone : found->second;
    }
}

float PatchGrid::area_m2(std::uint32_t patch) const { return state_->area_m2[patch]; }

PatchGrid::Cell PatchGrid::cell(std::uint32_t patch) const { return state_->cells[patch]; }

float PatchGrid::patch_size_m() const { return state_->cell_m; }

std::size_t PatchGrid::size() const { return state_->area_m2.size(); }

std::size_t PatchGrid::reached() const { return state_->reached_count; }

}  // namespace aula
