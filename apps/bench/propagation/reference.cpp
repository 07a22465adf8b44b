#include "apps/bench/propagation/reference.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

#include "engine/base/sampling.h"

namespace aula::bench {

namespace {

/// Roulette starts when a ray is below this share of its initial energy in every band (-120 dB).
constexpr float kRouletteEnergy = 1e-12F;

}  // namespace

struct Reference::Path {
    Vec3 origin{0};
    Vec3 direction{0};
    Bands energy = Bands::filled(1);  // without air
    float length_m = 0;
    int order = 0;
    bool diffuse = false;        // a diffuse reflection has happened
    float undivided = 1;         // probability of no diffuse path so far; 0 after it has left
    bool mirrored_last = false;  // the last reflection was specular
    ImageTransform image;        // of a purely specular path
    RandomStream random;
};

Reference::Reference(const Scene& scene, const Simulation& simulation, double time_s,
                     const Vec3& emitter, std::vector<Vec3> receivers, std::size_t bin_count)
    : scene_(scene, time_s),
      simulation_(simulation),
      emitter_(emitter),
      receivers_(std::move(receivers)),
      bin_count_(bin_count),
      speed_of_sound_m_s_(scene.medium.speed_of_sound_m_s()),
      max_length_m_(static_cast<float>(static_cast<double>(bin_count) * kBin_s) *
                    speed_of_sound_m_s_),
      attenuation_per_m_(scene.medium.attenuation_per_m()),
      estimates_(kEstimates, Sums(receivers_.size() * bin_count, 0)),
      images_(receivers_.size() * bin_count, 0) {
    add_image_sources();
}

/// Chains of rays discover image sources of higher orders. Rays count the images that they miss.
void Reference::add_image_sources() {
    constexpr std::uint64_t kDiscoveries = 100;
    const int order = simulation_.order > 0
                          ? std::min(simulation_.order, simulation_.specular_order)
                          : simulation_.specular_order;
    sounds_.resize(receivers_.size());
    if (!simulation_.specular || order == 0) return;
    paths_.emplace(scene_, order, kDetectionRadius_m, derive_seed(simulation_.seed, 0x1ea5));
    for (std::size_t r = 0; r < receivers_.size(); ++r) {
        SpecularSound& sound = sounds_[r];
        for (std::uint64_t frame = 0; frame < kDiscoveries; ++frame) {
            paths_->discover(receivers_[r], frame);
            sound = paths_->find(emitter_, receivers_[r], false, attenuation_per_m_);
            if (paths_->listed_order() == order) break;
        }
        for (const SoundPath& path : sound.paths) {
            const std::size_t bin = bin_of(path.length_m);
            if (bin < bin_count_) images_[r * bin_count_ + bin] += double{path.energy.sum()};
        }
    }
}

/// True if a purely specular path is among the image sources of a receiver.
bool Reference::is_image(const Path& path, std::size_t receiver) const {
    if (path.diffuse || !paths_ || path.order > paths_->order()) return false;
    if (!path.image.may_be_image) return false;
    return path.order <= paths_->listed_order() || sounds_[receiver].has_tried(path.image.key());
}

void Reference::trace(std::uint64_t rays, WorkerPool& workers) {
    const std::uint64_t rounds = (rays + kBatchRays * kEstimates - 1) / (kBatchRays * kEstimates);
    workers.run(kEstimates, [&](std::size_t estimate) {
        for (std::uint64_t round = 0; round < rounds; ++round) {
            trace_batch(derive_seed(simulation_.seed, 0x5eed, estimate, rounds_ + round),
                        estimates_[estimate]);
        }
    });
    rounds_ += static_cast<std::uint32_t>(rounds);
}

void Reference::trace_batch(std::uint64_t seed, Sums& sums) const {
    const ScrambledSobol directions(seed);
    std::vector<Path> paths(kBatchRays);
    for (std::uint32_t i = 0; i < kBatchRays; ++i) {
        paths[i].origin = emitter_;
        paths[i].direction = uniform_direction(directions.point(i));
        paths[i].random = RandomStream(derive_seed(seed, i));
    }
    std::vector<Path> next;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    while (!paths.empty()) {
        rays.clear();
        for (const Path& path : paths) {
            rays.push_back({path.origin, path.direction, max_length_m_ - path.length_m});
        }
        hits.resize(rays.size());
        scene_.intersect(rays, hits);

        next.clear();
        for (std::size_t i = 0; i < paths.size(); ++i) {
            Path path = paths[i];
            const Hit& hit = hits[i];
            cross_detection_spheres(path, std::min(hit.distance_m, rays[i].max_m), sums);
            if (!hit.any()) continue;
            if (simulation_.order > 0 && path.order == simulation_.order) continue;

            // Advance to the hit.
            const Material& material = scene_.material(scene_.triangle(hit.triangle));
            const Vec3 normal = scene_.facing_normal(hit, path.direction);
            path.origin = scene_.point(hit, path.direction);
            path.length_m += hit.distance_m;
            path.energy *= complement(material.absorption);
            ++path.order;

            // Diffusely reflected energy also reaches a receiver directly.
            const Bands scattered = path.energy * material.scattering;
            next_event(path, normal, scattered, path.random.uniform(), sums);

            // Choose the reflection of the ray. From a purely specular path one diffuse path
            // leaves; itself goes on in the mirror direction without a choice.
            const float total = path.energy.sum();
            if (!(total > 0)) continue;
            const float p = scattered.sum() / total;
            const bool diffuse = path.random.uniform() < p;
            const bool divides = !path.diffuse;
            if (diffuse && path.undivided > 0) {
                Path scattered_path = path;
                scattered_path.mirrored_last = false;
                scattered_path.energy = scattered * (1 / (p * path.undivided));
                scattered_path.direction = lambert_direction(normal, path.random.uniform_2d());
                scattered_path.diffuse = true;
                scattered_path.undivided = 1;
                scattered_path.random = RandomStream(derive_seed(path.random.state(), 0xd1));
                add_surviving(scattered_path, next);
                path.undivided = 0;
            }
            if (divides || !diffuse) {
                path.mirrored_last = true;
                if (paths_ && !path.diffuse && path.order <= paths_->order()) {
                    const MirrorPlane& plane = paths_->mirror_of_triangle(hit.triangle);
                    path.image = path.image.then_from_source(plane);
                }
                path.energy *= complement(material.scattering) * (divides ? 1 : 1 / (1 - p));
                path.direction = mirror(path.direction, normal);
                if (divides) path.undivided *= 1 - p;
                add_surviving(path, next);
            }
        }
        paths.swap(next);
    }
}

/// Adds a path unless it is absorbed or ends by roulette.
void Reference::add_surviving(Path path, std::vector<Path>& paths) {
    const float strongest = path.energy.max();
    if (!(strongest > 0)) return;
    if (strongest < kRouletteEnergy) {
        if (!(path.random.uniform() * kRouletteEnergy < strongest)) return;
        path.energy *= kRouletteEnergy / strongest;
    }
    paths.push_back(path);
}

/// A Lambert surface that radiates the energy B sends B cos(theta) / pi into a unit of solid angle:
/// at the distance d the fluence is B cos(theta) / (pi d^2). One of P receivers is chosen at
/// random, hence the factor P.
void Reference::next_event(const Path& path, const Vec3& normal, const Bands& radiated, float pick,
                           Sums& sums) const {
    const auto count = static_cast<float>(receivers_.size());
    const std::size_t receiver =
        std::min(static_cast<std::size_t>(pick * count), receivers_.size() - 1);
    const Vec3 offset = receivers_[receiver] - path.origin;
    const float distance_m = glm::length(offset);
    const float cosine = glm::dot(offset, normal) / distance_m;
    if (!(cosine > 0) || path.length_m + distance_m >= max_length_m_) return;
    if (!scene_.visible(path.origin, receivers_[receiver])) return;
    const float factor = count * cosine / (std::numbers::pi_v<float> * distance_m * distance_m);
    add(receiver, path.length_m + distance_m, radiated * factor, sums);
}

/// Paths that end in a mirror cannot be aimed at a point: they are found by crossing a small
/// sphere, energy * chord / (4/3 pi R^3).
void Reference::cross_detection_spheres(const Path& path, float segment_m, Sums& sums) const {
    if (!path.mirrored_last) return;
    if (!path.diffuse && !simulation_.specular) return;
    constexpr float kRadius2_m2 = kDetectionRadius_m * kDetectionRadius_m;
    constexpr float kVolume_m3 =
        4.0F / 3.0F * std::numbers::pi_v<float> * kRadius2_m2 * kDetectionRadius_m;
    for (std::size_t r = 0; r < receivers_.size(); ++r) {
        const Vec3 to_centre = receivers_[r] - path.origin;
        const float nearest_m = glm::dot(to_centre, path.direction);
        const float half_2 = kRadius2_m2 - (glm::dot(to_centre, to_centre) - nearest_m * nearest_m);
        if (half_2 <= 0) continue;
        const float enter_m = std::max(0.0F, nearest_m - std::sqrt(half_2));
        const float leave_m = std::min(segment_m, nearest_m + std::sqrt(half_2));
        if (leave_m <= enter_m || is_image(path, r)) continue;
        const float middle_m = (enter_m + leave_m) / 2;
        add(r, path.length_m + middle_m, path.energy * ((leave_m - enter_m) / kVolume_m3), sums);
    }
}

std::size_t Reference::bin_of(float length_m) const {
    return static_cast<std::size_t>(double{length_m} / (double{speed_of_sound_m_s_} * kBin_s));
}

/// Air attenuates by the length of the whole path.
void Reference::add(std::size_t receiver, float length_m, const Bands& energy, Sums& sums) const {
    const std::size_t bin = bin_of(length_m);
    if (bin >= bin_count_) return;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        sums[receiver * bin_count_ + bin] +=
            double{energy[b] * std::exp(-attenuation_per_m_[b] * length_m)};
    }
}

std::vector<double> Reference::estimates(std::size_t receiver, BinRange bins) const {
    const double rays_of_estimate = static_cast<double>(rays()) / kEstimates;
    const auto first = static_cast<std::ptrdiff_t>(receiver * bin_count_ + bins.first);
    const auto end = static_cast<std::ptrdiff_t>(receiver * bin_count_ + bins.end);
    const double images = std::accumulate(images_.begin() + first, images_.begin() + end, 0.0);
    std::vector<double> energies;
    for (const Sums& sums : estimates_) {
        const double traced = std::accumulate(sums.begin() + first, sums.begin() + end, 0.0);
        energies.push_back(traced / rays_of_estimate + images);
    }
    return energies;
}

Reference::Estimate Reference::energy(std::size_t receiver, BinRange bins) const {
    const std::vector<double> energies = estimates(receiver, bins);
    return {mean(energies), standard_error(energies)};
}

std::vector<double> Reference::response(std::size_t receiver) const {
    std::vector<double> means;
    for (std::size_t b = 0; b < bin_count_; ++b) means.push_back(energy(receiver, {b, b + 1}).mean);
    return means;
}

double Reference::relative_error(std::size_t receiver, BinRange bins) const {
    double sum = 0;
    for (std::size_t b = bins.first; b < bins.end; ++b) {
        const Estimate estimate = energy(receiver, {b, b + 1});
        const double relative = estimate.standard_error / estimate.mean;
        sum += relative * relative;
    }
    return std::sqrt(sum / static_cast<double>(bins.count()));
}

}  // namespace aula::bench
