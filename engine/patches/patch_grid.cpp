#include "engine/patches/patch_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>

#include "engine/base/tolerances.h"
#include "engine/patches/irradiance_map.h"
#include "engine/patches/patch_index.h"
#include "engine/patches/patch_sides.h"
#include "engine/patches/sound_reach.h"
#include "engine/patches/surface_sampler.h"
#include "engine/rays/convex_room.h"

namespace aula {

namespace {

/// Samples of a full cell. A choice: they miss a hidden sixth of it with a probability of 5 %, and
/// are tested by rays before the first frame.
constexpr int kSamplesPerPatch = 16;

/// The same where only some of them count: energies are inversely proportional to the area. Half of
/// the area has a standard error of an eighth, which biases their mean by 1.6 %.
constexpr int kFineSamples = 64;

/// Share of the samples of a patch that none of the walks has hit (SoundReach::mark). Hardly any
/// energy arrives there: an error of its area is not heard. Outdoors most patches are far away.
constexpr float kUnmarkedShare = 0.25F;

/// Patches for each marked one beyond which a grid is sparse: the others are then sampled only when
/// the rows of the marked ones fit, and panels do not divide them. A choice: closed rooms have
/// about two, as walls have an outer side, and cities many.
constexpr std::size_t kMostPerMarked = 4;

/// Share of a patch's area that is all of it, up to the rounding of the samples' sum.
constexpr float kAllReached = 0.999F;
static_assert(1 - kAllReached > PatchSides::kSideSamples * tolerances::kRounding);

/// Of rows that become too many, the next size has room for this factor. A choice: they scatter by
/// a few percent with the place of the cells.
constexpr double kSpareRows = 1.05;

/// Number of cells that a moving object intersects, relative to its area in cell faces: it has two
/// sides, each of which intersects about twice as many.
constexpr double kCellsOfMoving = 4;

/// Factor of the patch size if patches are too many. A choice: they become a third fewer in a step,
/// each of which searches for them anew.
constexpr float kCoarser = 1.25F;

}  // namespace

struct PatchGrid::State {
    const RayScene& scene;
    WorkerPool& workers;
    CellGrid grid;
    PatchIndex index;
    SurfaceSampler sampler;
    SoundReach reach;
    std::optional<IrradianceMap> irradiance_map;
    PatchSides sides;
    std::vector<Vec3> inside;
    std::uint64_t seed;
    std::vector<char> transmitting;     // [triangle] now or before, when patches were marked
    std::vector<float> static_area_m2;  // [patch] of static objects
    std::vector<float> area_m2;         // [patch] of all objects
    std::vector<std::uint32_t> static_triangles;
    std::vector<std::uint32_t> moving_triangles;
    bool is_convex = false;  // when patches were marked
    bool is_sparse = false;  // see kMostPerMarked
    double rows_of_moving = 0;
    std::uint32_t static_patches = 0;         // the patches with parts, and those of moving objects
    std::vector<std::size_t> first_part;      // [patch] of its static triangles, and the end of all
    std::vector<std::uint32_t> static_parts;  // these triangles, ascending within a patch
    std::vector<std::pair<std::uint32_t, std::uint64_t>> static_crossed;  // panel, cell: sorted

    State(const RayScene& rays, WorkerPool& pool, std::uint64_t seed_of_grid, float patch_size_m,
          std::span<const Vec3> inside_points)
        : scene(rays),
          workers(pool),
          grid(rays, patch_size_m),
          sampler(rays, grid, index, seed_of_grid),
          reach(rays, grid, index, seed_of_grid),
          sides(rays, index, grid.size_m()),
          inside(inside_points.begin(), inside_points.end()),
          seed(seed_of_grid),
          transmitting(rays.triangle_count(), 0) {}

    std::uint32_t find(const Vec3& point, const Vec3& facing_normal) const {
        return index.find(grid.key_at(point, facing_normal));
    }

    /// Finds the patches of all triangles, and marks those that walks reach. False if there are
    /// more than `max_patches`.
    bool find_patches(ReachWalks& walks, double max_patches) {
        double moving_m2 = 0;
        std::vector<std::pair<std::uint32_t, std::uint32_t>> parts;  // patch, ascending triangle
        for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
            const RayScene::Triangle& triangle = scene.triangle(t);
            const bool may_move = scene.moves(triangle);
            sampler.for_each_patch(t, [&](std::uint32_t patch, const Vec3&, float) {
                if (!may_move) parts.emplace_back(patch, t);
            });
            (may_move ? moving_triangles : static_triangles).push_back(t);
            if (may_move) moving_m2 += double{triangle.area_m2()};
        }
        index.keep_present();
        static_patches = static_cast<std::uint32_t>(index.size());
        first_part.assign(index.size() + 1, 0);
        for (const auto& [patch, _] : parts) ++first_part[patch + 1];
        std::partial_sum(first_part.begin(), first_part.end(), first_part.begin());
        static_parts.resize(parts.size());
        std::vector<std::size_t> next = first_part;
        for (const auto& [patch, t] : parts) static_parts[next[patch]++] = t;
        rows_of_moving = kCellsOfMoving * moving_m2 / std::pow(double{grid.size_m()}, 2);
        return mark(walks, max_patches - rows_of_moving);
    }

    std::size_t reached_rows() const {
        std::size_t rows = 0;
        for (std::uint32_t patch = 0; patch < index.size(); ++patch) {
            if (reach.marked(patch)) rows += sides.row_count(patch);
        }
        return rows;
    }

    /// Marks the patches that sound reaches.
    bool mark(ReachWalks& walks, double max_patches) {
        begins_to_transmit();
        irradiance_map.emplace(scene, grid.size_m());
        is_convex = is_convex_room(scene, inside);
        if (!is_convex) return reach.mark(walks, max_patches, *irradiance_map);
        for_each_inner_part([&](std::uint32_t patch, float) { reach.mark(patch); });
        return static_cast<double>(reach.count()) <= max_patches;
    }

    /// Calls visit(patch, area) for the parts of the walls of a convex room. Each surface of it
    /// sees all others: none is hidden from a part of its patch.
    template <typename Visit>
    void for_each_inner_part(const Visit& visit) {
        for (const std::uint32_t t : static_triangles) {
            const RayScene::Triangle& triangle = scene.triangle(t);
            const bool is_front = glm::dot(triangle.normal, inside[0] - triangle.vertices[0]) > 0;
            sampler.for_each_patch(t, [&](std::uint32_t patch, const Vec3& normal, float area) {
                if ((normal == triangle.normal) == is_front) visit(patch, area);
            });
        }
    }

    /// True if a triangle transmits sound that did not when patches were marked.
    bool begins_to_transmit() {
        bool any = false;
        for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
            if (transmitting[t] || !scene.transmits(scene.triangle(t).material)) continue;
            transmitting[t] = 1;
            any = true;
        }
        return any;
    }

    /// Computes areas and irradiance. False if there are more than `max_rows`: some areas of a
    /// sparse grid are unknown then.
    bool find_areas(double max_rows) {
        static_area_m2.assign(index.size(), 0);
        if (is_convex) {
            for_each_inner_part(
                [&](std::uint32_t patch, float area) { static_area_m2[patch] += area; });
        } else {
            // The sides of moving panels need the areas of all patches.
            is_sparse = moving_triangles.empty() && static_patches > kMostPerMarked * reach.count();
            const std::vector<SurfaceSample> heard = add_reachable(false, static_area_m2);
            if (sides.add_partitions(partitions(heard)))
                static_crossed = crossings(static_triangles);
        }
        irradiance_map->finish(static_area_m2, [&](const Vec3& point, const Vec3& normal) {
            return find(point, normal);
        });
        add_static_sides(sides.clear_static());
        scene_moved();
        if (rows() > max_rows) return false;
        if (is_sparse) add_unmarked();
        return true;
    }

    /// Rows of the patches that sound reaches, and of moving objects.
    double rows() const { return static_cast<double>(reached_rows()) + rows_of_moving; }

    /// Adds the areas of the patches of a sparse grid that are not marked.
    void add_unmarked() {
        const std::vector<SurfaceSample> samples = sampler.sample(
            static_triangles, kSamplesPerPatch,
            [&](std::uint32_t patch) { return reach.marked(patch) ? 0 : kUnmarkedShare; });
        const std::vector<char> reached = reach.reaches(samples, workers);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            if (!reached[i]) continue;
            static_area_m2[samples[i].patch] += samples[i].area_m2;
            area_m2[samples[i].patch] += samples[i].area_m2;
        }
    }

    void materials_changed() {
        if (!begins_to_transmit()) return;
        // The size of the patches stays, whatever their number.
        ReachWalks walks(scene, inside, seed);
        mark(walks, std::numeric_limits<double>::infinity());
        find_areas(std::numeric_limits<double>::infinity());
    }

    /// Updates the moving objects' parts.
    void scene_moved() {
        index.begin_move();
        sides.begin_move();
        divide();
        area_m2 = static_area_m2;
        add_reachable(true, area_m2);
        index.release_unused([&](std::uint32_t patch) { sides.remove(patch); });
        sides.end_move();
        area_m2.resize(index.size());
        static_area_m2.resize(index.size());
    }

    /// The static triangles that have sound on both sides within a cell, from the samples of static
    /// surfaces that sound reaches.
    std::vector<std::uint32_t> partitions(const std::vector<SurfaceSample>& heard) const {
        std::vector<std::tuple<std::uint32_t, std::uint64_t, char>> found;  // triangle, cell, side
        for (const SurfaceSample& s : heard) {
            if (!reach.marked(s.patch)) continue;
            const bool front = s.normal == scene.triangle(s.triangle).normal;
            found.emplace_back(s.triangle, CellGrid::cell_of(index.key(s.patch)), front ? 0 : 1);
        }
        std::sort(found.begin(), found.end());
        std::vector<std::uint32_t> triangles;
        for (std::size_t i = 1; i < found.size(); ++i) {
            const auto& [triangle, cell, side] = found[i];
            const auto& [other, other_cell, other_side] = found[i - 1];
            if (triangle == other && cell == other_cell && side != other_side)
                triangles.push_back(triangle);
        }
        return triangles;
    }

    /// The cells that the panels of triangles cross: panels and cells, sorted.
    std::vector<std::pair<std::uint32_t, std::uint64_t>> crossings(
        const std::vector<std::uint32_t>& triangles) {
        std::vector<std::pair<std::uint32_t, std::uint64_t>> crossed;
        for (const std::uint32_t t : triangles) {
            const std::uint32_t panel = sides.panel_of(t);
            if (panel == PatchSides::kNone && !scene.moves(scene.triangle(t))) continue;
            sampler.for_each_patch(t, [&](std::uint32_t patch, const Vec3&, float) {
                if (panel == PatchSides::kNone) return;
                crossed.emplace_back(panel, CellGrid::cell_of(index.key(patch)));
            });
        }
        std::sort(crossed.begin(), crossed.end());
        crossed.erase(std::unique(crossed.begin(), crossed.end()), crossed.end());
        return crossed;
    }

    /// Divides the patches of the cells that panels cross.
    void divide() {
        if (sides.panel_count() == 0) return;
        std::vector<std::uint32_t> divided;
        const auto add = [&](const auto& crossed, bool marked_only) {
            for (const auto& [panel, cell] : crossed) {
                for (const std::uint64_t key : CellGrid::keys_of_cell(cell)) {
                    const std::uint32_t patch = index.find(key);
                    if (patch == kNone || (marked_only && !reach.marked(patch))) continue;
                    if (sides.cross(patch, panel)) divided.push_back(patch);
                }
            }
        };
        add(crossings(moving_triangles), false);
        add(static_crossed, is_sparse);
        std::sort(divided.begin(), divided.end());
        static_area_m2.resize(index.size());
        add_static_sides(divided);
    }

    /// Adds the static surfaces of divided patches, in ascending order.
    void add_static_sides(const std::vector<std::uint32_t>& divided) {
        for (const SurfaceSample& s : static_samples(divided)) {
            const Vec3 point = s.nudged_off_surface();
            sides.add_static(
                s.patch, point,
                s.area_m2 * irradiance_map->relative(s.patch, s.triangle, point, s.normal));
        }
    }

    /// The static triangles with a part in one of the patches, ascending.
    std::vector<std::uint32_t> static_triangles_in(
        const std::vector<std::uint32_t>& patches) const {
        std::vector<std::uint32_t> triangles;
        for (const std::uint32_t patch : patches) {
            if (patch >= static_patches) continue;  // of moving objects only
            const std::span<const std::uint32_t> of_patch =
                std::span(static_parts)
                    .subspan(first_part[patch], first_part[patch + 1] - first_part[patch]);
            triangles.insert(triangles.end(), of_patch.begin(), of_patch.end());
        }
        std::sort(triangles.begin(), triangles.end());
        triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
        return triangles;
    }

    /// Many samples, in ascending order of patches, of the static surface that sound can reach.
    std::vector<SurfaceSample> static_samples(std::vector<std::uint32_t> patches) {
        std::erase_if(patches, [&](std::uint32_t patch) { return !(static_area_m2[patch] > 0); });
        const std::vector<std::uint32_t> triangles = static_triangles_in(patches);
        std::vector<SurfaceSample> samples =
            sampler.sample(triangles, PatchSides::kSideSamples, [&](std::uint32_t patch) {
                return std::binary_search(patches.begin(), patches.end(), patch) ? 1.0F : 0.0F;
            });
        // Patches that are completely reached need no rays.
        std::map<std::uint32_t, float> all_m2;
        for (const SurfaceSample& s : samples) all_m2[s.patch] += s.area_m2;
        const auto in_part =
            std::partition(samples.begin(), samples.end(), [&](const SurfaceSample& s) {
                return all_m2[s.patch] * kAllReached <= static_area_m2[s.patch];
            });
        const std::vector<SurfaceSample> asked(in_part, samples.end());
        const std::vector<char> reached = reach.reaches(asked, workers);
        samples.erase(in_part, samples.end());
        for (std::size_t i = 0; i < asked.size(); ++i) {
            if (reached[i]) samples.push_back(asked[i]);
        }
        return samples;
    }

    /// The static triangles whose patches have samples.
    std::vector<std::uint32_t> sampled_triangles() const {
        if (!is_sparse) return static_triangles;
        std::vector<std::uint32_t> patches;
        for (std::uint32_t patch = 0; patch < static_patches; ++patch) {
            if (reach.marked(patch)) patches.push_back(patch);
        }
        return static_triangles_in(patches);
    }

    /// Adds the area of the static triangles, or of the moving ones, that sound can reach. Where
    /// only part of a patch can be reached, many more samples estimate the share. Static patches
    /// that are not marked have few, or none. Returns samples that sound reaches.
    std::vector<SurfaceSample> add_reachable(bool moving, std::vector<float>& areas) {
        const std::vector<std::uint32_t> sampled =
            moving ? std::vector<std::uint32_t>() : sampled_triangles();
        const std::vector<std::uint32_t>& triangles = moving ? moving_triangles : sampled;
        const auto matters = [&](std::uint32_t patch) { return moving || reach.marked(patch); };
        const float unmarked_share = is_sparse ? 0 : kUnmarkedShare;
        const std::vector<SurfaceSample> samples = sampler.sample(
            triangles, kSamplesPerPatch,
            [&](std::uint32_t patch) { return matters(patch) ? 1 : unmarked_share; });
        areas.resize(index.size());
        const std::vector<char> reached = reach.reaches(samples, workers);
        std::vector<char> some(areas.size(), 0);
        std::vector<char> others(areas.size(), 0);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            (reached[i] ? some : others)[samples[i].patch] = 1;
        }
        const auto add = [&](const SurfaceSample& s) {
            areas[s.patch] += s.area_m2;
            if (moving) sides.add_moving(s.patch, s.nudged_off_surface(), s.area_m2);
        };
        const auto is_fine = [&](std::uint32_t patch) {
            return matters(patch) && some[patch] && others[patch];
        };
        std::vector<SurfaceSample> heard;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            if (!reached[i]) continue;
            heard.push_back(samples[i]);
            if (!is_fine(samples[i].patch)) add(samples[i]);
        }
        std::vector<std::uint32_t> fine;
        for (std::uint32_t patch = 0; patch < some.size(); ++patch) {
            if (is_fine(patch)) fine.push_back(patch);
        }
        const std::vector<SurfaceSample> fine_samples =
            sampler.sample(moving ? triangles : static_triangles_in(fine), kFineSamples,
                           [&](std::uint32_t patch) { return is_fine(patch) ? 1.0F : 0.0F; });
        const std::vector<char> fine_reached = reach.reaches(fine_samples, workers);
        for (std::size_t i = 0; i < fine_samples.size(); ++i) {
            if (fine_reached[i]) add(fine_samples[i]);
        }
        return heard;
    }
};

/// The patches without their areas, enlarged until sound reaches at most `max_patches`.
std::unique_ptr<PatchGrid::State> PatchGrid::with_at_most(double max_patches, const RayScene& scene,
                                                          float patch_size_m, ReachWalks& walks,
                                                          std::uint64_t seed, WorkerPool& workers) {
    double static_m2 = 0;
    double moving_m2 = 0;
    for (const RayScene::Triangle& t : scene.triangles()) {
        (scene.moves(t) ? moving_m2 : static_m2) += double{t.area_m2()};
    }
    // The first size is too small rather than too large. Of both sides of the static triangles
    // only those in the room are reached, and one cell may hold the faces of many: a quarter of
    // the area. The cells of moving objects always count.
    constexpr double kReachedShare = 0.25;
    const double min_m = std::max(std::sqrt(kReachedShare * static_m2 / max_patches),
                                  std::sqrt(kCellsOfMoving * moving_m2 / max_patches));
    float size_m = std::max(patch_size_m, static_cast<float>(min_m));
    for (;; size_m *= kCoarser) {
        auto state = std::make_unique<State>(scene, workers, seed, size_m, walks.inside());
        if (state->find_patches(walks, max_patches)) return state;
    }
}

PatchGrid::PatchGrid(const RayScene& scene, float patch_size_m, std::span<const Vec3> inside,
                     std::uint64_t seed, WorkerPool& workers, double max_rows) {
    ReachWalks walks(scene, inside, seed);
    for (;;) {
        state_ = with_at_most(max_rows, scene, patch_size_m, walks, seed, workers);
        if (state_->find_areas(max_rows)) break;
        // Areas divided by panels become fewer with the size rather than with its square.
        const auto factor = static_cast<float>(kSpareRows * state_->rows() / max_rows);
        patch_size_m = std::max(kCoarser, factor) * state_->grid.size_m();
    }
}

PatchGrid::Extent PatchGrid::extent(const RayScene& scene, float patch_size_m,
                                    std::span<const Vec3> inside, std::uint64_t seed,
                                    double max_patches) {
    WorkerPool caller(1);
    ReachWalks walks(scene, inside, seed);
    const auto state = with_at_most(max_patches, scene, patch_size_m, walks, seed, caller);
    return {state->reach.count(), state->grid.size_m()};
}

PatchGrid::~PatchGrid() = default;

void PatchGrid::materials_changed() { state_->materials_changed(); }

void PatchGrid::scene_moved() { state_->scene_moved(); }

std::uint32_t PatchGrid::find(const Vec3& point, const Vec3& facing_normal) const {
    return state_->find(point, facing_normal);
}

void PatchGrid::find_rows(const LanePoints& points, const LanePoints& facing_normals,
                          std::size_t count, std::array<std::uint32_t, kLanes>& rows,
                          std::array<float, kLanes>& factors) const {
    alignas(64) std::array<std::uint64_t, kLanes> keys;
    state_->grid.keys_at(points, facing_normals, count, keys);
    state_->index.find(keys, std::span(rows).first(count));
    for (std::size_t i = 0; i < count; ++i) {
        factors[i] = 1;
        if (rows[i] == kNone || !state_->sides.divided(rows[i])) continue;
        const PatchSides::Target target = state_->sides.target(rows[i], points.at(i));
        rows[i] = target.row;
        factors[i] = target.factor;
    }
}

PatchGrid::Radiator PatchGrid::find_radiator(std::uint32_t triangle, const Vec3& point,
                                             const Vec3& facing_normal) const {
    const State& s = *state_;
    const std::uint32_t patch = find(point, facing_normal);
    if (patch == kNone || !(s.area_m2[patch] > 0)) return {};
    if (!s.sides.divided(patch)) {
        return {patch,
                relative_irradiance(patch, triangle, point, facing_normal) / s.area_m2[patch]};
    }
    const float relative = s.scene.moves(s.scene.triangle(triangle))
                               ? 1
                               : s.irradiance_map->relative(patch, triangle, point, facing_normal);
    return {s.sides.target(patch, point).row, relative / s.sides.reference_m2()};
}

float PatchGrid::area_m2(std::uint32_t patch) const { return state_->area_m2[patch]; }

float PatchGrid::per_m2(std::uint32_t row) const {
    const State& s = *state_;
    const std::uint32_t patch = s.index.patch_of(row);
    const float area_m2 = s.area_m2[patch];
    if (!(area_m2 > 0)) return 0;
    return row == patch ? 1 / area_m2
                        : s.sides.area_m2(patch, row) / (s.sides.reference_m2() * area_m2);
}

float PatchGrid::relative_irradiance(std::uint32_t patch, std::uint32_t triangle, const Vec3& point,
                                     const Vec3& facing_normal) const {
    // Unknown where objects move in and out.
    if (state_->area_m2[patch] != state_->static_area_m2[patch]) return 1;
    return state_->irradiance_map->relative(patch, triangle, point, facing_normal);
}

PatchCell PatchGrid::cell(std::uint32_t row) const {
    const State& s = *state_;
    return s.grid.cell(s.index.key(s.index.patch_of(row)));
}

float PatchGrid::patch_size_m() const { return state_->grid.size_m(); }

std::size_t PatchGrid::size() const { return state_->index.size(); }

std::size_t PatchGrid::reached() const { return state_->reach.count(); }

std::size_t PatchGrid::reached_rows() const { return state_->reached_rows(); }

}  // namespace aula
