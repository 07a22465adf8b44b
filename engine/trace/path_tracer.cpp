#include "engine/trace/path_tracer.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>

#include "engine/base/air_attenuation.h"
#include "engine/base/band_vector.h"
#include "engine/base/multiversion.h"
#include "engine/base/sampling.h"

namespace aula {

namespace {

enum class SeedPurpose : std::uint64_t { directions = 1, rays = 2 };

AULA_MULTIVERSION
void add_deposits(const PathBatch& paths, const std::array<std::uint32_t, kLanes>& patch,
                  const std::array<float, kLanes>& factor, const TimeBins& bins, double s_per_m,
                  DepositParts& out) {
    for (std::size_t i = 0; i < paths.count; ++i) {
        const std::size_t bin = bins.index(double{paths.length_m[i]} * s_per_m);
        if (patch[i] == PatchGrid::kNone || bin >= bins.count()) continue;
        Deposit deposit;
        deposit.patch = patch[i];
        deposit.bin = static_cast<std::uint16_t>(bin);
        deposit.ray = static_cast<std::uint8_t>(paths.ray[i]);
        // The random number of the roulette is independent of the diffuse energy.
        deposit.set_energy(factor[i] * load_bands(paths.scattered[i]), paths.roulette[i]);
        if (!deposit.empty()) out.add(deposit);
    }
}

static_assert(kLanes <= 256, "a deposit has eight bits for its ray");

}  // namespace

PathTracer::PathTracer(const RayScene& scene, const PatchSubdivision& subdivision,
                       const SpecularPaths& images, const TraceSettings& settings)
    : scene_(scene), images_(images), subdivision_(&subdivision), settings_(settings) {}

PathTracer::PathTracer(const RayScene& scene, const PatchGrid& grid, const TimeBins& bins,
                       const SpecularPaths& images, const TraceSettings& settings)
    : scene_(scene), images_(images), grid_(&grid), bins_(&bins), settings_(settings) {}

void PathTracer::trace(const Emitter& emitter, std::span<const Receiver> receivers,
                       std::uint64_t frame_seed, int batch, TraceBatch& out) const {
    trace_paths(emitter, receivers, frame_seed, batch, out, [](const PathBatch&) {});
}

std::vector<Ray> PathTracer::rays(const Emitter& emitter, std::uint64_t frame_seed,
                                  int batch) const {
    std::vector<Ray> all;
    TraceBatch unused;
    trace_paths(emitter, {}, frame_seed, batch, unused, [&](const PathBatch& paths) {
        for (std::size_t i = 0; i < paths.count; ++i) {
            all.push_back(
                {paths.rays.origin.at(i), paths.rays.direction.at(i), paths.rays.max_m[i]});
        }
    });
    return all;
}

std::vector<PathLine> PathTracer::lines(const Emitter& emitter, std::uint64_t frame_seed, int count,
                                        int order) const {
    constexpr float kIntoTheOpen_m = 3;
    std::vector<PathLine> all;
    TraceBatch unused;
    const auto memory = std::make_unique<PathBatch>();
    PathBatch& paths = *memory;
    const auto most = static_cast<std::size_t>(std::max(0, count));
    for (int batch = 0; batch < batch_count() && all.size() < most; ++batch) {
        paths.count = 0;
        start(emitter, frame_seed, batch, paths, unused);
        paths.count = std::min(paths.count, most - all.size());
        const std::size_t first = all.size();
        all.resize(first + paths.count, PathLine{{emitter.position}, {1}});
        for (int k = 0; k < order && paths.count > 0; ++k) {
            scene_.intersect(paths.rays, paths.count, paths.hits);
            for (std::size_t i = paths.count; i-- > 0;) {
                if (paths.hits.triangle[i] != kNoTriangle) continue;
                PathLine& line = all[first + paths.ray[i]];
                line.points.push_back(paths.rays.origin.at(i) +
                                      kIntoTheOpen_m * paths.rays.direction.at(i));
                line.energy.push_back(line.energy.back());
                paths.remove(i);
            }
            reflect(paths, unused);
            for (std::size_t i = paths.count; i-- > 0;) {
                PathLine& line = all[first + paths.ray[i]];
                line.points.push_back(paths.point.at(i));
                // A completely absorbed path may have a NaN energy.
                line.energy.push_back(paths.ended[i] != 0 ? 0 : paths.energy[i].sum() / kBandCount);
                if (paths.ended[i] != 0) paths.remove(i);
            }
        }
    }
    return all;
}

/// Traces a batch by reflection order; a PathBatch holds the next segment of every path. `sent` is
/// called with each PathBatch.
template <typename Sent>
void PathTracer::trace_paths(const Emitter& emitter, std::span<const Receiver> receivers,
                             std::uint64_t frame_seed, int batch, TraceBatch& out,
                             const Sent& sent) const {
    const auto memory = std::make_unique<PathBatch>();
    PathBatch& paths = *memory;
    start(emitter, frame_seed, batch, paths, out);
    for (int order = 0; paths.count > 0; ++order) {
        scene_.intersect(paths.rays, paths.count, paths.hits);
        sent(paths);
        out.segment_count += paths.count;
        collect_segments(paths, order, emitter, out);
        if (subdivision_) collect_arrivals(paths, order, emitter, receivers, out);
        if (settings_.order > 0 && order == settings_.order) break;
        for (std::size_t i = paths.count; i-- > 0;) {
            if (paths.hits.triangle[i] == kNoTriangle) paths.remove(i);
        }

        // Reflects at the hits; keeps the paths that continue.
        extend_images(paths, order, emitter);
        reflect(paths, out);
        for (std::size_t i = paths.count; i-- > 0;) {
            if (paths.ended[i] != 0) paths.remove(i);
        }
    }
}

/// Advances paths to their hits and reflects them.
void PathTracer::reflect(PathBatch& paths, TraceBatch& out) const {
    paths.arrive(scene_);
    paths.scatter(scene_, settings_.attenuation_per_m);
    if (grid_) {
        deposit(paths, out);
    } else {
        for (std::size_t i = 0; i < paths.count; ++i) {
            const Hit hit{paths.hits.triangle[i], paths.hits.distance_m[i], paths.hits.u[i],
                          paths.hits.v[i]};
            paths.identifier[i] =
                paths.identifier[i].extended(subdivision_->patch(hit, paths.back[i] != 0));
        }
    }
    paths.leave(settings_.max_length_m);
}

void PathTracer::start(const Emitter& emitter, std::uint64_t frame_seed, int batch,
                       PathBatch& paths, TraceBatch& out) const {
    const std::uint64_t seed = derive_seed(frame_seed, SeedPurpose::directions, emitter.id);
    const ScrambledSobol sobol(seed);
    const int first = batch * kBatchRays;
    const int end = std::min(first + kBatchRays, settings_.rays);
    out.departures.clear();
    for (int i = first; i < end; ++i) {
        const std::size_t lane = paths.count++;
        paths.rays.origin.set(lane, emitter.position);
        paths.rays.direction.set(
            lane, uniform_direction(settings_.independent_rays
                                        ? RandomStream(derive_seed(seed, i)).uniform_2d()
                                        : sobol.point(static_cast<unsigned>(i))));
        out.departures.push_back(paths.rays.direction.at(lane));
        paths.rays.max_m[lane] = settings_.max_length_m;
        paths.ray[lane] = static_cast<std::uint32_t>(i - first);
        paths.energy[lane] = Bands::filled(1);
        paths.length_m[lane] = 0;
        paths.diffuse[lane] = 0;
        paths.random[lane] = derive_seed(frame_seed, SeedPurpose::rays, emitter.id, i);
        paths.identifier[lane] = PathIdentifier::start(emitter.id);
        paths.image[lane] = {};
    }
}

/// Composes the reflections of paths that image sources may count.
void PathTracer::extend_images(PathBatch& paths, int order, const Emitter& emitter) const {
    if (order >= images_.order() || images_.listed_order() == images_.order()) return;
    for (std::size_t i = 0; i < paths.count; ++i) {
        if (paths.diffuse[i] != 0) continue;
        const MirrorPlane& mirror = images_.mirror_of_triangle(paths.hits.triangle[i]);
        ImageTransform& image = paths.image[i];
        image =
            emitter.is_listener ? image.then_from_listener(mirror) : image.then_from_source(mirror);
    }
}

/// Collects the receivers' arrivals from the present segments of diffusely reflected paths.
void PathTracer::collect_arrivals(const PathBatch& paths, int order, const Emitter& emitter,
                                  std::span<const Receiver> receivers, TraceBatch& out) const {
    if (order == 0) return;
    for (std::uint32_t r = 0; r < receivers.size(); ++r) {
        for (std::size_t i = 0; i < paths.count; ++i) {
            if (paths.diffuse[i] == 0) continue;
            const Vec3 direction = paths.rays.direction.at(i);
            const auto chord =
                receivers[r].chord(scene_, paths.rays.origin.at(i), direction,
                                   std::min(paths.hits.distance_m[i], paths.rays.max_m[i]));
            if (!chord) continue;
            const Bands energy = paths.energy[i] *
                                 transmission(settings_.attenuation_per_m, chord->at_m) *
                                 chord->share_1_m2;
            out.arrivals.push_back(
                {paths.identifier[i].ended(r), r, paths.length_m[i] + chord->at_m,
                 emitter.is_listener ? out.departures[paths.ray[i]] : -direction, energy});
        }
    }
}

/// Collects the present segments of paths that neither gather nor image sources find.
void PathTracer::collect_segments(const PathBatch& paths, int order, const Emitter& emitter,
                                  TraceBatch& out) const {
    // The direct sound and the listed sequences are found exactly, by SpecularPaths.
    const bool mirrors = settings_.specular && order > images_.listed_order();
    const bool limited = grid_ && settings_.order > 0;
    const bool may_be_image = order <= images_.order();
    if (order == 0 || (!mirrors && !limited)) return;
    for (std::size_t i = 0; i < paths.count; ++i) {
        if (!(paths.diffuse[i] != 0 ? limited && paths.to_diffuse[i] == 0 : mirrors)) continue;
        const Vec3 direction = paths.rays.direction.at(i);
        out.segments.push_back({paths.rays.origin.at(i), direction,
                                std::min(paths.hits.distance_m[i], paths.rays.max_m[i]),
                                paths.length_m[i]});
        out.segment_energies.push_back(
            {paths.energy[i], emitter.is_listener ? out.departures[paths.ray[i]] : -direction,
             may_be_image && paths.diffuse[i] == 0 ? paths.image[i].key() : 0});
        if (subdivision_) out.segment_identifiers.push_back(paths.identifier[i]);
    }
}

void PathTracer::deposit(const PathBatch& paths, TraceBatch& out) const {
    std::array<std::uint32_t, kLanes> patch;
    std::array<float, kLanes> factor;
    grid_->find_rows(paths.point, paths.normal, paths.count, patch, factor);
    add_deposits(paths, patch, factor, *bins_, 1 / double{settings_.speed_of_sound_m_s},
                 out.deposits);
}

}  // namespace aula
