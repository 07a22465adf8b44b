#include "engine/trace/path_tracer.h"

#include <algorithm>
#include <cstdint>

#include "engine/base/sampling.h"

namespace aula {

namespace {

/// Batches at least, unless they would have fewer rays than kFewestRays. Choices: as many threads
/// have about equal shares, and smaller batches leave most lanes empty after few reflections.
constexpr int kFewestBatches = 8;
constexpr int kFewestRays = 64;
static_assert(kFewestRays < PathTracer::kBatchRays);

enum class PathSeed : std::uint64_t { directions = 1, rays = 2, walls = 3 };

}  // namespace

std::vector<Ray> PathTracer::rays(const Emitter& emitter, std::uint64_t frame_seed,
                                  int batch) const {
    std::vector<Ray> all;
    const auto append = [&](const PathBatch& paths, int) {
        for (std::size_t i = 0; i < paths.count; ++i) {
            all.push_back(
                {paths.rays.origin.at(i), paths.rays.direction.at(i), paths.rays.max_m[i]});
        }
    };
    follow(emitter, frame_seed, batch, last_order(), Paths::all, append, [](const PathBatch&) {});
    return all;
}

int PathTracer::batch_count() const {
    const int full = (settings_.rays + kBatchRays - 1) / kBatchRays;
    return std::max(full, std::min(kFewestBatches, settings_.rays / kFewestRays));
}

int PathTracer::rays_of(int batches) const {
    // Rays of a full vector.
    constexpr auto kVector = static_cast<std::int64_t>(padded_lanes(1));
    const std::int64_t vectors = (settings_.rays + kVector - 1) / kVector;
    const std::int64_t count = batch_count();
    const std::int64_t rays = (vectors * batches + count - 1) / count * kVector;
    return static_cast<int>(std::min(rays, std::int64_t{settings_.rays}));
}

std::vector<PathLine> PathTracer::lines(const Emitter& emitter, std::uint64_t frame_seed, int count,
                                        int order) const {
    // A choice of the picture: the height of a room.
    constexpr float kEscapeLength_m = 3;
    PathTracer first_rays = *this;
    first_rays.set_rays(std::clamp(count, 0, settings_.rays));
    std::vector<PathLine> all(static_cast<std::size_t>(first_rays.settings_.rays),
                              PathLine{{emitter.position}, {1}});
    for (int batch = 0; batch < first_rays.batch_count(); ++batch) {
        const auto line = [&](const PathBatch& paths, std::size_t i) -> PathLine& {
            return all[static_cast<std::size_t>(first_rays.rays_of(batch)) + paths.ray[i]];
        };
        const auto add_escapes = [&](const PathBatch& paths, int segment) {
            for (std::size_t i = 0; i < paths.count; ++i) {
                if (segment == order || paths.hits.triangle[i] != kNoTriangle) continue;
                line(paths, i).points.push_back(paths.rays.origin.at(i) +
                                                kEscapeLength_m * paths.rays.direction.at(i));
                line(paths, i).energy.push_back(line(paths, i).energy.back());
            }
        };
        const auto add_reflections = [&](const PathBatch& paths) {
            for (std::size_t i = 0; i < paths.count; ++i) {
                line(paths, i).points.push_back(paths.point.at(i));
                // A completely absorbed path may have a NaN energy.
                line(paths, i).energy.push_back(
                    paths.ended[i] != 0 ? 0 : paths.energy[i].sum() / kBandCount);
            }
        };
        first_rays.follow(emitter, frame_seed, batch, order, Paths::one_of_a_ray, add_escapes,
                          add_reflections);
    }
    return all;
}

void PathTracer::start(const Emitter& emitter, std::uint64_t frame_seed, int batch,
                       PathBatch& paths) const {
    const std::uint64_t seed = derive_seed(frame_seed, PathSeed::directions, emitter.id);
    const ScrambledSobol sobol(seed);
    const int first = rays_of(batch);
    const int end = rays_of(batch + 1);
    for (int i = first; i < end; ++i) {
        const std::size_t lane = paths.count++;
        paths.rays.origin.set(lane, emitter.position);
        const auto [direction, energy] = emitter.directivity.sample(
            settings_.independent_rays ? RandomStream(derive_seed(seed, i)).uniform_2d()
                                       : sobol.point(static_cast<unsigned>(i)));
        paths.rays.direction.set(lane, direction);
        paths.rays.max_m[lane] = settings_.max_length_m;
        paths.ray[lane] = static_cast<std::uint32_t>(i - first);
        paths.energy[lane] = energy;
        paths.length_m[lane] = 0;
        paths.diffuse[lane] = 0;
        paths.undivided[lane] = 1;
        paths.random[lane] = derive_seed(frame_seed, PathSeed::rays, emitter.id, i);
        paths.identifier[lane] = PathIdentifier::start(emitter.id);
        paths.image[lane] = {};
        paths.roulette_energy[lane] = PathBatch::kRouletteEnergy;
    }
}

/// The paths behind walls of a batch; null if no wall transmits.
std::unique_ptr<TransmittedPaths> PathTracer::transmitted(const Emitter& emitter,
                                                          std::uint64_t frame_seed,
                                                          int batch) const {
    if (!scene_.transmits()) return nullptr;
    return std::make_unique<TransmittedPaths>(
        scene_, settings_.attenuation_per_m, settings_.max_length_m,
        derive_seed(frame_seed, PathSeed::walls, emitter.id, batch));
}

/// Composes the reflections of paths that image sources may count.
void PathTracer::extend_images(PathBatch& paths, int order, const Emitter& emitter) const {
    if (order >= images_.highest_order() || !images_.shares_with_rays()) return;
    if (paths.behind_walls) return;
    for (std::size_t i = 0; i < paths.count; ++i) {
        ImageTransform& image = paths.image[i];
        if (paths.diffuse[i] != 0 || !image.may_be_image) continue;
        const MirrorPlane& mirror = images_.mirror_of_triangle(paths.hits.triangle[i]);
        image =
            emitter.is_listener ? image.then_from_listener(mirror) : image.then_from_source(mirror);
        // A path that leaves a flutter echo does not return to it, but between recesses of equal
        // depths.
        image.may_be_image = image.may_be_image && images_.may_list(image);
    }
}

void PathTracer::count_segments(const PathBatch& paths, int order, TraceBatch& out) {
    out.segment_count += paths.count;
    if (order > 0) return;
    out.departures.clear();
    for (std::size_t i = 0; i < paths.count; ++i) {
        out.departures.push_back(paths.rays.direction.at(i));
    }
}

void PathTracer::add_segment(const PathBatch& paths, std::size_t i, int order,
                             const Emitter& emitter, TraceBatch& out) const {
    const bool may_be_image = paths.diffuse[i] == 0 && !paths.behind_walls &&
                              order <= images_.highest_order() && paths.image[i].may_be_image;
    out.segments.push_back({paths.rays.origin.at(i), paths.rays.direction.at(i),
                            std::min(paths.hits.distance_m[i], paths.rays.max_m[i]),
                            paths.length_m[i]});
    out.segment_energies.push_back({paths.energy[i], direction_at_listener(paths, i, emitter, out),
                                    may_be_image ? paths.image[i].key() : 0});
}

}  // namespace aula
