#include "engine/path_tracer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "engine/sampling.h"
#include "engine/transmission.h"

namespace aula {

namespace {

/// A ray below this share of its first energy in every band (-80 dB) plays roulette.
constexpr float kRouletteEnergy = 1e-8F;

enum class SeedPurpose : std::uint64_t { directions = 1, rays = 2 };

}  // namespace

struct PathTracer::Path {
    Vec3 origin{0};
    Vec3 direction{0};
    Bands energy = Bands::filled(1);
    float length_m = 0;
    int order = 0;
    bool diffuse = false;  // a diffuse reflection has happened
    PathIdentifier identifier;
    RandomStream random;
};

PathTracer::PathTracer(const RayScene& scene, const PatchSubdivision& subdivision,
                       const TraceSettings& settings)
    : scene_(scene), subdivision_(&subdivision), settings_(settings) {}

PathTracer::PathTracer(const RayScene& scene, const PatchGrid& grid, const TimeBins& bins,
                       const TraceSettings& settings)
    : scene_(scene), grid_(&grid), bins_(&bins), settings_(settings) {}

void PathTracer::trace(std::size_t source, const Vec3& position, std::span<const Vec3> listeners,
                       std::uint64_t frame_seed, int batch, TraceBatch& out) const {
    trace_waves(source, position, listeners, frame_seed, batch, out, [](std::span<const Ray>) {});
}

std::vector<Ray> PathTracer::rays(std::size_t source, const Vec3& position,
                                  std::uint64_t frame_seed, int batch) const {
    std::vector<Ray> all;
    TraceBatch unused;
    trace_waves(source, position, {}, frame_seed, batch, unused, [&](std::span<const Ray> wave) {
        all.insert(all.end(), wave.begin(), wave.end());
    });
    return all;
}

std::vector<PathLine> PathTracer::lines(std::size_t source, const Vec3& position,
                                        std::uint64_t frame_seed, int count, int order) const {
    constexpr float kIntoTheOpen_m = 3;
    std::vector<PathLine> all;
    TraceBatch unused;
    std::vector<Path> paths;
    for (int batch = 0; batch < batch_count(); ++batch)
        start(source, position, frame_seed, batch, paths);
    paths.resize(std::min(paths.size(), static_cast<std::size_t>(count)));
    for (Path& path : paths) {
        PathLine& line = all.emplace_back(PathLine{{position}, {1}});
        for (bool goes_on = true; goes_on && path.order < order;) {
            const Ray ray{path.origin, path.direction, settings_.max_length_m - path.length_m};
            Hit hit;
            scene_.intersect(std::span(&ray, 1), std::span(&hit, 1));
            if (!hit.any()) {
                line.points.push_back(path.origin + kIntoTheOpen_m * path.direction);
                line.energy.push_back(line.energy.back());
                break;
            }
            goes_on = reflect(path, hit, unused);
            line.points.push_back(path.origin);
            line.energy.push_back(path.energy.sum() / kBandCount);
        }
    }
    return all;
}

/// Traces a batch wave by wave, a wave being the next segment of every path; `sent` sees each.
template <typename Sent>
void PathTracer::trace_waves(std::size_t source, const Vec3& position,
                             std::span<const Vec3> listeners, std::uint64_t frame_seed, int batch,
                             TraceBatch& out, const Sent& sent) const {
    std::vector<Path> paths;
    start(source, position, frame_seed, batch, paths);
    std::vector<Ray> rays(paths.size());
    std::vector<Hit> hits(paths.size());
    while (!paths.empty()) {
        // Intersect all paths' next segments.
        for (std::size_t i = 0; i < paths.size(); ++i) {
            rays[i] = {paths[i].origin, paths[i].direction,
                       settings_.max_length_m - paths[i].length_m};
        }
        scene_.intersect(std::span(rays).first(paths.size()), std::span(hits).first(paths.size()));
        sent(std::span<const Ray>(rays).first(paths.size()));
        out.segments += paths.size();

        // Collect arrivals along each segment, reflect at its end; keep the paths that go on.
        std::size_t alive = 0;
        for (std::size_t i = 0; i < paths.size(); ++i) {
            Path& path = paths[i];
            collect_arrivals(path, std::min(hits[i].distance_m, rays[i].max_m), listeners, out);
            const bool last = settings_.order > 0 && path.order == settings_.order;
            if (!hits[i].any() || last || !reflect(path, hits[i], out)) continue;
            if (alive != i) paths[alive] = path;
            ++alive;
        }
        paths.resize(alive);
    }
}

void PathTracer::start(std::size_t source, const Vec3& position, std::uint64_t frame_seed,
                       int batch, std::vector<Path>& paths) const {
    const ScrambledSobol sobol(derive_seed(frame_seed, SeedPurpose::directions, source));
    const int first = batch * kBatchRays;
    const int end = std::min(first + kBatchRays, settings_.rays);
    paths.reserve(static_cast<std::size_t>(std::max(0, end - first)));
    for (int i = first; i < end; ++i) {
        Path path;
        path.origin = position;
        path.random = RandomStream(derive_seed(frame_seed, SeedPurpose::rays, source, i));
        path.identifier = PathIdentifier::start(source);
        path.direction =
            uniform_direction(settings_.independent_rays ? path.random.uniform_2d()
                                                         : sobol.point(static_cast<unsigned>(i)));
        paths.push_back(path);
    }
}

void PathTracer::collect_arrivals(const Path& path, float segment_m,
                                  std::span<const Vec3> listeners, TraceBatch& out) const {
    // The direct sound and the image sources' paths are found exactly, elsewhere.
    if (path.order == 0) return;
    if (path.diffuse) {
        if (!subdivision_) return;
    } else if (!settings_.specular || path.order <= settings_.specular_order) {
        return;
    }
    const float radius_m = settings_.listener_radius_m;
    const float volume_m3 =
        4.0F / 3.0F * std::numbers::pi_v<float> * radius_m * radius_m * radius_m;
    for (std::uint32_t l = 0; l < listeners.size(); ++l) {
        const Vec3 to_centre = listeners[l] - path.origin;
        const float nearest_m = glm::dot(to_centre, path.direction);
        const float half_chord_2 =
            radius_m * radius_m - (glm::dot(to_centre, to_centre) - nearest_m * nearest_m);
        if (half_chord_2 <= 0) continue;
        const float half_chord_m = std::sqrt(half_chord_2);
        const float enter_m = std::max(0.0F, nearest_m - half_chord_m);
        const float leave_m = std::min(segment_m, nearest_m + half_chord_m);
        if (leave_m <= enter_m) continue;
        const float middle_m = (enter_m + leave_m) / 2;
        // The volume average of fluence: energy * chord / (4/3 pi R^3).
        const Bands energy = path.energy * transmission(settings_.attenuation_per_m, middle_m) *
                             ((leave_m - enter_m) / volume_m3);
        out.arrivals.push_back({subdivision_ ? path.identifier.ended(l) : PathIdentifier{}, l,
                                path.length_m + middle_m, -path.direction, energy});
    }
}

/// Brings a path to its hit and sends it on; false if it ends there.
bool PathTracer::reflect(Path& path, const Hit& hit, TraceBatch& out) const {
    const RayScene::Triangle& triangle = scene_.triangle(hit.triangle);
    const Material& material = scene_.material(triangle);
    const Vec3 normal = scene_.facing_normal(hit, path.direction);
    path.length_m += hit.distance_m;
    path.energy *= transmission(settings_.attenuation_per_m, hit.distance_m);
    path.energy *= complement(material.absorption);
    path.origin = scene_.point(hit, path.direction);
    ++path.order;

    const Bands scattered = path.energy * material.scattering;
    if (grid_) {
        const std::uint32_t patch = grid_->find(path.origin, normal);
        const std::size_t bin =
            bins_->index(double{path.length_m} / double{settings_.speed_of_sound_m_s});
        if (patch != PatchGrid::kNone && bin < bins_->count() && scattered.max() > 0) {
            out.deposits.push_back({scattered.value, patch, static_cast<std::uint32_t>(bin)});
        }
    } else {
        const bool back = glm::dot(triangle.normal, path.direction) > 0;
        path.identifier = path.identifier.extended(subdivision_->patch(hit, back));
    }

    // One ray carries all bands: choose the lobe with p, the energy-weighted mean of s, and weigh
    // each band by s_b / p or (1 - s_b) / (1 - p).
    const float total = path.energy.sum();
    if (!(total > 0)) return false;
    const float p = scattered.sum() / total;
    if (path.random.uniform() < p) {
        path.energy = scattered * (1 / p);
        path.direction = lambert_direction(normal, path.random.uniform_2d());
        path.diffuse = true;
    } else {
        path.energy = path.energy * complement(material.scattering) * (1 / (1 - p));
        path.direction = mirror(path.direction, normal);
    }
    const float strongest = path.energy.max();
    if (strongest < kRouletteEnergy) {
        const float survival = strongest / kRouletteEnergy;
        if (!(path.random.uniform() < survival)) return false;
        path.energy *= 1 / survival;
    }
    return true;
}

}  // namespace aula
