#include "engine/patches/patch_grid.h"

#include <tsl/robin_map.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>

#include "engine/base/mix64.h"
#include "engine/base/sampling.h"
#include "engine/patches/cell_clipping.h"
#include "engine/patches/cell_grid.h"
#include "engine/patches/irradiance_map.h"
#include "engine/patches/patch_sides.h"
#include "engine/rays/room_survey.h"

namespace aula {

namespace {

constexpr int kSamplesPerPatch = 16;   // on a full cell
constexpr int kFineSamples = 64;       // where only some samples count
constexpr int kSideSamples = 256;      // where panels of moving objects divide a patch
constexpr float kAllReached = 0.999F;  // share of a patch's area, up to rounding
constexpr int kReachAttempts = 4;      // attempts to reach the sound from a sample
/// Number of cells that a moving object intersects, relative to its area in cell faces: it has two
/// sides, each of which intersects about twice as many.
constexpr double kCellsOfMoving = 4;

constexpr int kWalks = 4096;
constexpr int kWalkBounces = 32;
constexpr int kWalkRounds = 12;
constexpr std::size_t kHitsPerPatch = 512;  // mean upper limit, to estimate the irradiance
constexpr std::size_t kChunk = 1024;        // samples of a job

constexpr std::uint64_t kNoKey = ~0ULL;

}  // namespace

struct PatchGrid::State {
    const RayScene& scene;
    WorkerPool& workers;
    std::uint64_t seed;
    CellGrid grid;
    tsl::robin_map<std::uint64_t, std::uint32_t, MixHash> patch_of_cell;
    std::vector<float> static_area_m2;  // of static objects
    std::vector<float> area_m2;         // of all objects
    std::vector<char> reached;          // by random walks
    std::vector<PatchCell> cells;
    std::vector<std::uint64_t> keys;     // kNoKey: released
    std::vector<std::uint64_t> touched;  // the last move at which a triangle was in the patch
    std::vector<std::uint32_t> free_rows;
    std::vector<std::uint32_t> patch_of_row;
    std::vector<std::uint32_t> static_triangles;
    std::vector<std::uint32_t> moving;
    std::size_t lasting = 0;  // initial patches; later ones are released after use
    std::uint64_t moves = 0;
    std::size_t reached_count = 0;
    IrradianceMap irradiance_map;
    PatchSides sides;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> static_parts;  // patch, triangle: sorted

    State(const RayScene& rays, WorkerPool& pool, std::uint64_t sample_seed, float patch_size_m)
        : scene(rays),
          workers(pool),
          seed(sample_seed),
          grid(rays, patch_size_m),
          irradiance_map(rays, grid.size_m()),
          sides(rays, grid.size_m()) {}

    struct Sample {
        Vec3 point;  // on the surface
        std::uint32_t triangle = 0;
        std::uint32_t patch = 0;
        float area_m2 = 0;
        bool back = false;
    };

    std::uint32_t patch_at(const CellIndex& cell, const Vec3& normal) {
        const std::uint64_t key = CellGrid::key(cell, normal);
        const auto [entry, added] = patch_of_cell.try_emplace(key, kNone);
        if (added) entry.value() = new_patch(key, cell);
        touched[entry->second] = moves;
        return entry->second;
    }

    std::uint32_t new_patch(std::uint64_t key, const CellIndex& cell) {
        const std::uint32_t patch = new_number();
        keys[patch] = key;
        cells[patch] = grid.cell(key, cell);
        patch_of_row[patch] = patch;
        return patch;
    }

    /// The number of a new row for a side of a patch.
    std::uint32_t new_side(std::uint32_t patch) {
        const std::uint32_t row = new_number();
        cells[row] = cells[patch];
        patch_of_row[row] = patch;
        return row;
    }

    std::uint32_t new_number() {
        if (free_rows.empty()) {
            free_rows.push_back(static_cast<std::uint32_t>(area_m2.size()));
            static_area_m2.push_back(0);
            area_m2.push_back(0);
            reached.push_back(0);
            cells.emplace_back();
            keys.push_back(kNoKey);
            touched.push_back(moves);
            patch_of_row.push_back(kNone);
        }
        const std::uint32_t number = free_rows.back();
        free_rows.pop_back();
        return number;
    }

    /// Releases the patches that no moving object has intersected in the last `keep` moves, and the
    /// rows of sides that received nothing in them.
    void release_unused(std::uint64_t keep) {
        const auto release = [&](std::uint32_t row) { free_rows.push_back(row); };
        sides.begin_move(keep, release);
        for (std::size_t patch = lasting; patch < keys.size(); ++patch) {
            if (keys[patch] == kNoKey || moves - touched[patch] <= keep) continue;
            patch_of_cell.erase(keys[patch]);
            keys[patch] = kNoKey;
            sides.remove(static_cast<std::uint32_t>(patch), release);
            free_rows.push_back(static_cast<std::uint32_t>(patch));
        }
    }

    /// Parts of a patch that are too small for a separate sample. One of them, drawn by area, has
    /// one sample for all, so that samples follow area and not the number of triangles.
    struct Reservoir {
        float area_m2 = 0;
        Sample drawn;
    };

    /// Calls `visit(patch, part, area, normal, back)` for the part of both sides of a triangle in
    /// every cell.
    template <typename Visit>
    void for_each_part(std::uint32_t t, const Visit& visit) {
        const RayScene::Triangle& triangle = scene.triangle(t);
        if (triangle.normal == Vec3(0)) return;
        for (const bool back : {false, true}) {
            const Vec3 normal = back ? -triangle.normal : triangle.normal;
            ClippedPolygon whole;
            for (const Vec3& v : triangle.vertices)
                whole.add(v - grid.origin() + RayScene::kOffset_m * normal);
            for_each_cell(whole, grid.cuts(), 0, {},
                          [&](const CellIndex& cell, const ClippedPolygon& part) {
                              const float area = part.area_m2();
                              if (area > 0) visit(patch_at(cell, normal), part, area, normal, back);
                          });
        }
    }

    /// Samples both sides of triangles in proportion to area, with `per_cell` samples for a full
    /// cell, in patches for which `wanted(patch)` is true.
    template <typename Wanted>
    std::vector<Sample> sample(const std::vector<std::uint32_t>& triangles, int per_cell,
                               const Wanted& wanted) {
        std::vector<Sample> samples;
        std::vector<Reservoir> reservoirs;
        const float samples_per_m2 = static_cast<float>(per_cell) / (grid.size_m() * grid.size_m());
        for (const std::uint32_t t : triangles) {
            const ScrambledSobol sobol(derive_seed(seed, t));
            std::uint32_t next = 0;
            for_each_part(t, [&](std::uint32_t patch, const ClippedPolygon& part, float area,
                                 const Vec3& normal, bool back) {
                if (!wanted(patch)) return;
                const auto somewhere = [&] {
                    return grid.origin() + part.point(sobol.point(next++)) -
                           RayScene::kOffset_m * normal;
                };
                if (area * samples_per_m2 >= 1) {
                    const int count =
                        std::min(static_cast<int>(std::ceil(area * samples_per_m2)), per_cell);
                    for (int i = 0; i < count; ++i) {
                        samples.push_back(
                            {somewhere(), t, patch, area / static_cast<float>(count), back});
                    }
                    return;
                }
                if (reservoirs.size() <= patch) reservoirs.resize(area_m2.size());
                Reservoir& rest = reservoirs[patch];
                rest.area_m2 += area;
                const float u = RandomStream(derive_seed(seed, t, patch)).uniform();
                if (u * rest.area_m2 < area) rest.drawn = {somewhere(), t, patch, 0, back};
                if (rest.area_m2 * samples_per_m2 >= 1) {
                    rest.drawn.area_m2 = rest.area_m2;
                    samples.push_back(rest.drawn);
                    rest.area_m2 = 0;
                }
            });
        }
        for (Reservoir& rest : reservoirs) {
            if (!(rest.area_m2 > 0)) continue;
            rest.drawn.area_m2 = rest.area_m2;
            samples.push_back(rest.drawn);
        }
        return samples;
    }

    /// Finds the patches of all triangles, and marks those that sound from `inside` reaches. False
    /// if there are more than `max_patches`.
    bool find_patches(std::span<const Vec3> inside, double max_patches) {
        double moving_m2 = 0;
        for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
            const RayScene::Triangle& triangle = scene.triangle(t);
            const bool may_move = scene.moves(triangle);
            for_each_part(
                t, [&](std::uint32_t patch, const ClippedPolygon&, float, const Vec3&, bool) {
                    if (!may_move && sides.panel_count() > 0) static_parts.emplace_back(patch, t);
                });
            (may_move ? moving : static_triangles).push_back(t);
            if (may_move) moving_m2 += double{triangle.area_m2()};
        }
        std::sort(static_parts.begin(), static_parts.end());
        lasting = keys.size();
        return mark_reachable_from(
            inside, max_patches - kCellsOfMoving * moving_m2 / std::pow(double{grid.size_m()}, 2));
    }

    /// Marks the patches that sound from `inside` reaches, until a round adds hardly any. False if
    /// there are more than `max_patches`.
    bool mark_reachable_from(std::span<const Vec3> inside, double max_patches) {
        std::size_t hits = 0;
        for (int round = 0; round < kWalkRounds; ++round) {
            const std::size_t before = reached_count;
            const RandomWalks walks{.paths = kWalks,
                                    .bounces = kWalkBounces,
                                    .seed = derive_seed(seed, 1 << 30, round)};
            trace_random_walks(
                scene, inside, walks, [&](int reflections, const Ray& ray, const Hit& hit) {
                    if (!hit.any() || scene.moves(scene.triangle(hit.triangle))) return;
                    const Vec3 point = scene.point(hit, ray.direction);
                    const Vec3 normal = scene.facing_normal(hit, ray.direction);
                    const auto found = patch_of_cell.find(grid.key_at(point, normal));
                    if (found == patch_of_cell.end()) return;
                    // Direct sound is omitted: its distribution depends on the start point.
                    if (reflections > 0) {
                        irradiance_map.add_hit(found->second, hit.triangle, point, normal);
                        ++hits;
                    }
                    if (reached[found->second]) return;
                    reached[found->second] = 1;
                    ++reached_count;
                });
            if (static_cast<double>(reached_count) > max_patches) return false;
            if (reached_count - before <= reached_count / 100 &&
                hits >= kHitsPerPatch * reached_count) {
                break;
            }
        }
        return static_cast<double>(reached_count) <= max_patches;
    }

    /// Computes areas and irradiance.
    void find_areas() {
        add_reachable(static_triangles, static_area_m2);
        irradiance_map.finish(static_area_m2, [&](const Vec3& point, const Vec3& normal) {
            const auto found = patch_of_cell.find(grid.key_at(point, normal));
            return found == patch_of_cell.end() ? kNone : found->second;
        });
        scene_moved(0);
    }

    /// Updates the moving objects' parts.
    void scene_moved(std::uint64_t keep) {
        ++moves;
        release_unused(keep);
        divide();
        area_m2 = static_area_m2;
        add_reachable(moving, area_m2);
        sides.end_move([&](std::uint32_t patch) { return new_side(patch); });
        area_m2.resize(keys.size());
        static_area_m2.resize(keys.size());
    }

    /// Divides the patches of the cells that panels cross.
    void divide() {
        if (sides.panel_count() == 0) return;
        std::vector<std::pair<std::uint32_t, std::uint64_t>> crossed;  // (panel, key)
        for (const std::uint32_t t : moving) {
            const std::uint32_t panel = sides.panel_of(t);
            for_each_part(
                t, [&](std::uint32_t patch, const ClippedPolygon&, float, const Vec3&, bool) {
                    if (panel != PatchSides::kNone) crossed.emplace_back(panel, keys[patch]);
                });
        }
        std::sort(crossed.begin(), crossed.end());
        crossed.erase(std::unique(crossed.begin(), crossed.end()), crossed.end());
        std::vector<std::uint32_t> divided;
        for (const auto& [panel, key] : crossed) {
            for (const std::uint64_t alike : CellGrid::keys_of_cell(key)) {
                const auto found = patch_of_cell.find(alike);
                if (found == patch_of_cell.end()) continue;
                if (sides.cross(found->second, panel)) divided.push_back(found->second);
            }
        }
        std::sort(divided.begin(), divided.end());
        for (const Sample& s : static_samples(divided)) {
            const Vec3 normal = normal_of(s);
            const Vec3 point = s.point + RayScene::kOffset_m * normal;
            sides.add_static(
                s.patch, point,
                s.area_m2 * irradiance_map.relative(s.patch, s.triangle, point, normal));
        }
    }

    /// Many samples, in ascending order of patches, of the static surface that sound can reach.
    std::vector<Sample> static_samples(const std::vector<std::uint32_t>& patches) {
        std::vector<std::uint32_t> triangles;
        for (const std::uint32_t patch : patches) {
            auto part = std::lower_bound(static_parts.begin(), static_parts.end(),
                                         std::pair{patch, std::uint32_t{0}});
            for (; part != static_parts.end() && part->first == patch; ++part) {
                if (static_area_m2[patch] > 0) triangles.push_back(part->second);
            }
        }
        std::sort(triangles.begin(), triangles.end());
        triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
        std::vector<Sample> samples = sample(triangles, kSideSamples, [&](std::uint32_t patch) {
            return static_area_m2[patch] > 0 &&
                   std::binary_search(patches.begin(), patches.end(), patch);
        });
        // Patches that are completely reached need no rays.
        std::map<std::uint32_t, float> all_m2;
        for (const Sample& s : samples) all_m2[s.patch] += s.area_m2;
        const auto in_part = std::partition(samples.begin(), samples.end(), [&](const Sample& s) {
            return all_m2[s.patch] * kAllReached <= static_area_m2[s.patch];
        });
        const std::vector<Sample> asked(in_part, samples.end());
        const std::vector<char> counts = reachable(asked);
        samples.erase(in_part, samples.end());
        for (std::size_t i = 0; i < asked.size(); ++i) {
            if (counts[i]) samples.push_back(asked[i]);
        }
        return samples;
    }

    /// Adds the area of the given triangles that sound can reach. Where only part of a patch can be
    /// reached, many more samples estimate the share.
    void add_reachable(const std::vector<std::uint32_t>& triangles, std::vector<float>& areas) {
        std::vector<Sample> samples =
            sample(triangles, kSamplesPerPatch, [](std::uint32_t) { return true; });
        areas.resize(area_m2.size());
        std::vector<char> counts = reachable(samples);
        std::vector<char> some(areas.size(), 0);
        std::vector<char> others(areas.size(), 0);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            (counts[i] ? some : others)[samples[i].patch] = 1;
        }
        const auto add = [&](const Sample& s) {
            areas[s.patch] += s.area_m2;
            if (!scene.moves(scene.triangle(s.triangle))) return;
            sides.add_moving(s.patch, s.point + RayScene::kOffset_m * normal_of(s), s.area_m2);
        };
        const auto in_part = [&](std::uint32_t patch) { return some[patch] && others[patch]; };
        for (const Sample& s : samples) {
            if (some[s.patch] && !in_part(s.patch)) add(s);
        }
        samples = sample(triangles, kFineSamples, in_part);
        counts = reachable(samples);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            if (counts[i]) add(samples[i]);
        }
    }

    /// For every sample, whether sound can reach it.
    std::vector<char> reachable(const std::vector<Sample>& samples) const {
        std::vector<char> counts(samples.size(), 0);
        workers.run((samples.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
            const std::size_t first = chunk * kChunk;
            const std::size_t count = std::min(kChunk, samples.size() - first);
            test_samples(std::span(samples).subspan(first, count),
                         std::span(counts).subspan(first, count),
                         RandomStream(derive_seed(seed, 1 << 29, chunk)));
        });
        return counts;
    }

    Vec3 normal_of(const Sample& s) const {
        const Vec3& n = scene.triangle(s.triangle).normal;
        return s.back ? -n : n;
    }

    void test_samples(std::span<const Sample> samples, std::span<char> counts,
                      RandomStream random) const {
        // Coincident faces count once: only the face that a ray hits.
        constexpr float kAbove_m = 2 * RayScene::kOffset_m;
        std::vector<Ray> rays(samples.size());
        std::vector<Hit> hits(samples.size());
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const Vec3 n = normal_of(samples[i]);
            rays[i] = {samples[i].point + kAbove_m * n, -n, 2 * kAbove_m};
        }
        scene.intersect(rays, hits);
        std::vector<std::size_t> open;  // samples that have not reached the sound yet
        for (std::size_t i = 0; i < samples.size(); ++i) {
            if (hits[i].triangle == samples[i].triangle) open.push_back(i);
        }
        for (int attempt = 0; attempt < kReachAttempts && !open.empty(); ++attempt) {
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

    /// True if a ray reached sound: the open, a reached patch or a moving object.
    bool sound_at(const Ray& ray, const Hit& hit) const {
        if (!hit.any() || scene.moves(scene.triangle(hit.triangle))) return true;
        const auto found = patch_of_cell.find(
            grid.key_at(scene.point(hit, ray.direction), scene.facing_normal(hit, ray.direction)));
        return found != patch_of_cell.end() && reached[found->second];
    }
};

/// The patches without their areas, enlarged until sound reaches at most `max_patches`.
std::unique_ptr<PatchGrid::State> PatchGrid::with_at_most(double max_patches, const RayScene& scene,
                                                          float patch_size_m,
                                                          std::span<const Vec3> inside,
                                                          std::uint64_t seed, WorkerPool& workers) {
    double static_m2 = 0;
    double moving_m2 = 0;
    for (const RayScene::Triangle& t : scene.triangles()) {
        (scene.moves(t) ? moving_m2 : static_m2) += double{t.area_m2()};
    }
    // Both sides of every static triangle may be cells, of which only those in the room are
    // reached. Those of moving objects always count.
    const double min_m = std::max(std::sqrt(static_m2 / (4 * max_patches)),
                                  std::sqrt(kCellsOfMoving * moving_m2 / max_patches));
    float size_m = std::max(patch_size_m, static_cast<float>(min_m));
    for (;; size_m *= 1.25F) {
        auto state = std::make_unique<State>(scene, workers, seed, size_m);
        if (state->find_patches(inside, max_patches)) return state;
    }
}

PatchGrid::PatchGrid(const RayScene& scene, float patch_size_m, std::span<const Vec3> inside,
                     std::uint64_t seed, WorkerPool& workers, double max_patches)
    : state_(with_at_most(max_patches, scene, patch_size_m, inside, seed, workers)) {
    state_->find_areas();
}

PatchGrid::Extent PatchGrid::extent(const RayScene& scene, float patch_size_m,
                                    std::span<const Vec3> inside, std::uint64_t seed,
                                    double max_patches) {
    WorkerPool caller(1);
    const auto state = with_at_most(max_patches, scene, patch_size_m, inside, seed, caller);
    return {state->reached_count, state->grid.size_m()};
}

PatchGrid::~PatchGrid() = default;

void PatchGrid::scene_moved(int keep) { state_->scene_moved(static_cast<std::uint64_t>(keep)); }

std::uint32_t PatchGrid::find(const Vec3& point, const Vec3& facing_normal) const {
    const auto found = state_->patch_of_cell.find(state_->grid.key_at(point, facing_normal));
    return found == state_->patch_of_cell.end() ? kNone : found->second;
}

void PatchGrid::find_rows(const LanePoints& points, const LanePoints& facing_normals,
                          std::size_t count, std::array<std::uint32_t, kLanes>& rows,
                          std::array<float, kLanes>& factors) const {
    alignas(64) std::array<std::uint64_t, kLanes> keys;
    state_->grid.keys_at(points, facing_normals, keys);
    for (std::size_t i = 0; i < count; ++i) {
        const auto found = state_->patch_of_cell.find(keys[i]);
        rows[i] = found == state_->patch_of_cell.end() ? kNone : found->second;
        factors[i] = 1;
        if (rows[i] == kNone || !state_->sides.divided(rows[i])) continue;
        const PatchSides::Target target = state_->sides.target(rows[i], points.at(i));
        rows[i] = target.row;
        factors[i] = target.factor;
    }
}

void PatchGrid::find_radiators(std::uint32_t triangle, const Vec3& point, const Vec3& facing_normal,
                               std::vector<Radiator>& radiators) const {
    radiators.clear();
    const State& s = *state_;
    const std::uint32_t patch = find(point, facing_normal);
    if (patch == kNone || !(s.area_m2[patch] > 0)) return;
    radiators.push_back(
        {patch, relative_irradiance(patch, triangle, point, facing_normal) / s.area_m2[patch]});
    if (!s.sides.divided(patch)) return;
    const float relative = s.scene.moves(s.scene.triangle(triangle))
                               ? 1
                               : s.irradiance_map.relative(patch, triangle, point, facing_normal);
    s.sides.for_each_row(patch, point, [&](std::uint32_t row) {
        radiators.push_back({row, relative / s.sides.reference_m2()});
    });
}

float PatchGrid::area_m2(std::uint32_t patch) const { return state_->area_m2[patch]; }

float PatchGrid::per_m2(std::uint32_t row) const {
    const State& s = *state_;
    const std::uint32_t patch = s.patch_of_row[row];
    const float area_m2 = s.area_m2[patch];
    if (!(area_m2 > 0)) return 0;
    return row == patch ? 1 / area_m2
                        : s.sides.area_m2(patch, row) / (s.sides.reference_m2() * area_m2);
}

float PatchGrid::relative_irradiance(std::uint32_t patch, std::uint32_t triangle, const Vec3& point,
                                     const Vec3& facing_normal) const {
    // Unknown where objects move in and out.
    if (state_->area_m2[patch] != state_->static_area_m2[patch]) return 1;
    return state_->irradiance_map.relative(patch, triangle, point, facing_normal);
}

PatchCell PatchGrid::cell(std::uint32_t row) const { return state_->cells[row]; }

float PatchGrid::patch_size_m() const { return state_->grid.size_m(); }

std::size_t PatchGrid::size() const { return state_->area_m2.size(); }

std::size_t PatchGrid::reached() const { return state_->reached_count; }

}  // namespace aula
