#include "engine/trace/path_tracer.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>

#include "engine/base/band_vector.h"
#include "engine/base/multiversion.h"
#include "engine/base/sampling.h"
#include "engine/base/air_attenuation.h"

namespace aula {

namespace {

enum class SeedPurpose : std::uint64_t { directions = 1, rays = 2 };

AULA_MULTIVERSION
void add_deposits(const PathWave& wave, const std::array<std::uint32_t, kLanes>& patch,
                  const TimeBins& bins, double s_per_m, DepositParts& out) {
    for (std::size_t i = 0; i < wave.count; ++i) {
        const std::size_t bin = bins.index(double{wave.length_m[i]} * s_per_m);
        if (patch[i] == PatchGrid::kNone || bin >= bins.count()) continue;
        Deposit deposit;
        deposit.patch = patch[i];
        deposit.bin = static_cast<std::uint16_t>(bin);
        deposit.ray = static_cast<std::uint8_t>(wave.ray[i]);
        // What decides on roulette has nothing to do with what is left here.
        deposit.set_energy(load_bands(wave.scattered[i]), wave.roulette[i]);
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
    trace_waves(emitter, receivers, frame_seed, batch, out, [](const PathWave&) {});
}

std::vector<Ray> PathTracer::rays(const Emitter& emitter, std::uint64_t frame_seed,
                                  int batch) const {
    std::vector<Ray> all;
    TraceBatch unused;
    trace_waves(emitter, {}, frame_seed, batch, unused, [&](const PathWave& wave) {
        for (std::size_t i = 0; i < wave.count; ++i) {
            all.push_back({wave.rays.origin.at(i), wave.rays.direction.at(i), wave.rays.max_m[i]});
        }
    });
    return all;
}

std::vector<PathLine> PathTracer::lines(const Emitter& emitter, std::uint64_t frame_seed, int count,
                                        int order) const {
    constexpr float kIntoTheOpen_m = 3;
    std::vector<PathLine> all;
    TraceBatch unused;
    const auto memory = std::make_unique<PathWave>();
    PathWave& wave = *memory;
    const auto most = static_cast<std::size_t>(std::max(0, count));
    for (int batch = 0; batch < batch_count() && all.size() < most; ++batch) {
        wave.count = 0;
        start(emitter, frame_seed, batch, wave, unused);
        wave.count = std::min(wave.count, most - all.size());
        const std::size_t first = all.size();
        all.resize(first + wave.count, PathLine{{emitter.position}, {1}});
        for (int k = 0; k < order && wave.count > 0; ++k) {
            scene_.intersect(wave.rays, wave.count, wave.hits);
            for (std::size_t i = wave.count; i-- > 0;) {
                if (wave.hits.triangle[i] != kNoTriangle) continue;
                PathLine& line = all[first + wave.ray[i]];
                line.points.push_back(wave.rays.origin.at(i) +
                                      kIntoTheOpen_m * wave.rays.direction.at(i));
                line.energy.push_back(line.energy.back());
                wave.remove(i);
            }
            reflect(wave, unused);
            for (std::size_t i = wave.count; i-- > 0;) {
                PathLine& line = all[first + wave.ray[i]];
                line.points.push_back(wave.point.at(i));
                // What is absorbed wholly has no energy to speak of, not even a number.
                line.energy.push_back(wave.ended[i] != 0 ? 0 : wave.energy[i].sum() / kBandCount);
                if (wave.ended[i] != 0) wave.remove(i);
            }
        }
    }
    return all;
}

/// Traces a batch wave by wave, a wave being the next segment of every path; `sent` sees each.
template <typename Sent>
void PathTracer::trace_waves(const Emitter& emitter, std::span<const Receiver> receivers,
                             std::uint64_t frame_seed, int batch, TraceBatch& out,
                             const Sent& sent) const {
    const auto memory = std::make_unique<PathWave>();
    PathWave& wave = *memory;
    start(emitter, frame_seed, batch, wave, out);
    for (int order = 0; wave.count > 0; ++order) {
        scene_.intersect(wave.rays, wave.count, wave.hits);
        sent(wave);
        out.segments += wave.count;
        collect_legs(wave, order, emitter, out);
        if (subdivision_) collect_arrivals(wave, order, emitter, receivers, out);
        if (settings_.order > 0 && order == settings_.order) break;
        for (std::size_t i = wave.count; i-- > 0;) {
            if (wave.hits.triangle[i] == kNoTriangle) wave.remove(i);
        }

        // Reflect at the hits; keep the paths that go on.
        extend_sequences(wave, order, emitter);
        reflect(wave, out);
        for (std::size_t i = wave.count; i-- > 0;) {
            if (wave.ended[i] != 0) wave.remove(i);
        }
    }
}

/// Brings paths to their hits and sends them on.
void PathTracer::reflect(PathWave& wave, TraceBatch& out) const {
    wave.arrive(scene_);
    wave.scatter(scene_, settings_.attenuation_per_m);
    if (grid_) {
        deposit(wave, out);
    } else {
        for (std::size_t i = 0; i < wave.count; ++i) {
            const Hit hit{wave.hits.triangle[i], wave.hits.distance_m[i], wave.hits.u[i],
                          wave.hits.v[i]};
            wave.identifier[i] =
                wave.identifier[i].extended(subdivision_->patch(hit, wave.back[i] != 0));
        }
    }
    wave.leave(settings_.max_length_m);
}

void PathTracer::start(const Emitter& emitter, std::uint64_t frame_seed, int batch, PathWave& wave,
                       TraceBatch& out) const {
    const std::uint64_t seed = derive_seed(frame_seed, SeedPurpose::directions, emitter.id);
    const ScrambledSobol sobol(seed);
    const int first = batch * kBatchRays;
    const int end = std::min(first + kBatchRays, settings_.rays);
    out.departures.clear();
    for (int i = first; i < end; ++i) {
        const std::size_t lane = wave.count++;
        wave.rays.origin.set(lane, emitter.position);
        wave.rays.direction.set(
            lane, uniform_direction(settings_.independent_rays
                                        ? RandomStream(derive_seed(seed, i)).uniform_2d()
                                        : sobol.point(static_cast<unsigned>(i))));
        out.departures.push_back(wave.rays.direction.at(lane));
        wave.rays.max_m[lane] = settings_.max_length_m;
        wave.ray[lane] = static_cast<std::uint32_t>(i - first);
        wave.energy[lane] = Bands::filled(1);
        wave.length_m[lane] = 0;
        wave.diffuse[lane] = 0;
        wave.random[lane] = derive_seed(frame_seed, SeedPurpose::rays, emitter.id, i);
        wave.identifier[lane] = PathIdentifier::start(emitter.id);
        wave.sequence[lane] = {};
    }
}

/// Adds the planes that are hit to the sequences that image sources may count.
void PathTracer::extend_sequences(PathWave& wave, int order, const Emitter& emitter) const {
    if (order >= images_.order() || images_.listed_order() == images_.order()) return;
    for (std::size_t i = 0; i < wave.count; ++i) {
        if (wave.diffuse[i] != 0) continue;
        const std::uint32_t plane = images_.plane_of_triangle(wave.hits.triangle[i]);
        PlaneSequence& sequence = wave.sequence[i];
        sequence =
            emitter.listens ? sequence.then_from_listener(plane) : sequence.then_from_source(plane);
    }
}

/// Takes what of the present segments of diffusely reflected paths is heard at receivers.
void PathTracer::collect_arrivals(const PathWave& wave, int order, const Emitter& emitter,
                                  std::span<const Receiver> receivers, TraceBatch& out) const {
    if (order == 0) return;
    for (std::uint32_t r = 0; r < receivers.size(); ++r) {
        for (std::size_t i = 0; i < wave.count; ++i) {
            if (wave.diffuse[i] == 0) continue;
            const Vec3 direction = wave.rays.direction.at(i);
            const auto chord =
                receivers[r].chord(scene_, wave.rays.origin.at(i), direction,
                                   std::min(wave.hits.distance_m[i], wave.rays.max_m[i]));
            if (!chord) continue;
            const Bands energy = wave.energy[i] *
                                 transmission(settings_.attenuation_per_m, chord->at_m) *
                                 chord->share_1_m2;
            out.arrivals.push_back({wave.identifier[i].ended(r), r, wave.length_m[i] + chord->at_m,
                                    emitter.listens ? out.departures[wave.ray[i]] : -direction,
                                    energy});
        }
    }
}

/// Takes the present segments of paths that no one else finds.
void PathTracer::collect_legs(const PathWave& wave, int order, const Emitter& emitter,
                              TraceBatch& out) const {
    // The direct sound and the listed sequences are found exactly, elsewhere.
    const bool mirrors = settings_.specular && order > images_.listed_order();
    const bool limited = grid_ && settings_.order > 0;
    const bool may_be_image = order <= images_.order();
    if (order == 0 || (!mirrors && !limited)) return;
    for (std::size_t i = 0; i < wave.count; ++i) {
        if (!(wave.diffuse[i] != 0 ? limited && wave.to_diffuse[i] == 0 : mirrors)) continue;
        const Vec3 direction = wave.rays.direction.at(i);
        out.legs.push_back({wave.rays.origin.at(i), direction,
                            std::min(wave.hits.distance_m[i], wave.rays.max_m[i]),
                            wave.length_m[i]});
        out.leg_sounds.push_back({wave.energy[i],
                                  emitter.listens ? out.departures[wave.ray[i]] : -direction,
                                  may_be_image && wave.diffuse[i] == 0 ? wave.sequence[i].key : 0});
        if (subdivision_) out.leg_paths.push_back(wave.identifier[i]);
    }
}

void PathTracer::deposit(const PathWave& wave, TraceBatch& out) const {
    std::array<std::uint32_t, kLanes> patch;
    grid_->find(wave.point, wave.normal, wave.count, patch);
    add_deposits(wave, patch, *bins_, 1 / double{settings_.speed_of_sound_m_s}, out.deposits);
}

}  // namespace aula
