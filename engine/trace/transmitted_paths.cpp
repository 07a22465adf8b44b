#include "engine/trace/transmitted_paths.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

#include "engine/base/air_attenuation.h"
#include "engine/base/sampling.h"

namespace aula {

namespace {

enum class TransmissionSeed : std::uint64_t { crossing = 1, copy = 2, roulette = 3 };

/// Below 1.2e-38 single precision loses digits; a reflection may leave 1e-8 of this energy.
constexpr float kLeastRouletteEnergy = 1e-30F;

}  // namespace

TransmittedPaths::TransmittedPaths(const RayScene& scene, const Bands& attenuation_per_m,
                                   float max_length_m, std::uint64_t seed)
    : scene_(scene),
      attenuation_per_m_(attenuation_per_m),
      max_length_m_(max_length_m),
      seed_(seed) {
    for (PathBatch* batch : {paths_.get(), next_.get(), emerging_.get()}) {
        batch->behind_walls = true;
    }
}

void TransmittedPaths::transmit(const PathBatch& from, int reflections) {
    entries_.clear();
    lanes_.clear();
    for (std::size_t i = 0; i < from.count; ++i) {
        if (!scene_.transmits(from.material[i])) continue;
        const Vec3 direction = from.rays.direction.at(i);
        const Vec3 normal = from.normal.at(i);
        const float distance_m = from.hits.distance_m[i];
        const RayScene::PointOff at =
            RayScene::point_beyond(distance_m, -glm::dot(direction, normal));
        entries_.push_back({{from.hits.triangle[i], distance_m, from.hits.u[i], from.hits.v[i]},
                            from.rays.origin.at(i) + at.along_m * direction + at.off_m * normal,
                            normal});
        lanes_.push_back(i);
    }
    emerging_->count = 0;
    if (entries_.empty()) return;
    find_wall_exits(scene_, entries_, exits_);
    for (std::size_t k = 0; k < exits_.size(); ++k) {
        const WallExit& exit = exits_[k];
        const std::size_t i = lanes_[k];
        const Bands arrived =
            from.energy[i] * transmission(attenuation_per_m_, from.hits.distance_m[i]);
        const Bands transmitted = arrived * exit.wall.transmission;
        const Bands scattered = transmitted * exit.wall.scattering;
        const float length_m = from.length_m[i] + exit.thickness_m;
        const float total = transmitted.sum();
        const float to_diffuse = scattered.sum();
        if (!(total > 0) || length_m >= max_length_m_) continue;

        // The lobe for all bands, as in PathBatch::scatter.
        RandomStream random(derive_seed(from.random[i], TransmissionSeed::crossing));
        const auto u = random.uniform_2d();
        const Vec3 lambert = lambert_direction(exit.normal, random.uniform_2d());
        const bool diffuse = std::max(u[0], PathBatch::kLeastChoice) * total < to_diffuse;
        Bands energy = diffuse ? scattered : transmitted * complement(exit.wall.scattering);
        energy *= total / (diffuse ? to_diffuse : total - to_diffuse);
        // The faces of a wall may not be parallel.
        Vec3 onward = from.rays.direction.at(i);
        if (glm::dot(onward, exit.normal) <= 0) onward = mirror(onward, exit.normal);

        const std::size_t lane = emerging_->count++;
        emerging_->ray[lane] = from.ray[i];
        emerging_->energy[lane] = energy;
        emerging_->scattered[lane] = scattered;
        emerging_->length_m[lane] = length_m;
        emerging_->roulette[lane] = u[1];
        emerging_->random[lane] = random.state();
        emerging_->to_diffuse[lane] = diffuse ? 1 : 0;
        emerging_->diffuse[lane] = from.diffuse[i] | emerging_->to_diffuse[lane];
        emerging_->identifier[lane] = from.identifier[i].transmitted();
        emerging_->point.set(lane, exit.point);
        emerging_->normal.set(lane, exit.normal);
        emerging_->hits.triangle[lane] = exit.hit.triangle;
        emerging_->hits.distance_m[lane] = exit.hit.distance_m;
        emerging_->hits.u[lane] = exit.hit.u;
        emerging_->hits.v[lane] = exit.hit.v;
        const Vec3& front = scene_.surface(exit.hit.triangle).normal;
        emerging_->back[lane] = glm::dot(front, exit.normal) >= 0 ? 0 : 1;
        emerging_->rays.origin.set(lane, exit.point);
        emerging_->rays.direction.set(lane, diffuse ? lambert : onward);
        emerging_->rays.max_m[lane] = max_length_m_ - length_m;
        emerging_->roulette_energy[lane] =
            std::max(from.roulette_energy[i] * exit.wall.transmission.max(), kLeastRouletteEnergy);
        emerging_->crossings[lane] = from.behind_walls ? from.crossings[i] + 1 : 1;
        emerging_->reflected[lane] =
            from.behind_walls ? from.reflected[i] : (reflections > 0 ? 1 : 0);
    }
}

void TransmittedPaths::admit() {
    PathBatch& present = *paths_;
    if (present.count + emerging_->count == 0) return;
    energies_.assign(present.energy.begin(), present.energy.begin() + present.count);
    crossings_.assign(present.crossings.begin(), present.crossings.begin() + present.count);
    energies_.insert(energies_.end(), emerging_->energy.begin(),
                     emerging_->energy.begin() + emerging_->count);
    crossings_.insert(crossings_.end(), emerging_->crossings.begin(),
                      emerging_->crossings.begin() + emerging_->count);
    const std::uint64_t seed = derive_seed(seed_, admissions_++);
    double energy = 0;
    for (const Bands& of_path : energies_) energy += double{of_path.sum()};
    next_->count = 0;
    const float factor = thinning_.next(
        energy, double{RandomStream(derive_seed(seed, TransmissionSeed::roulette)).uniform()});
    if (!(factor > 0)) return std::swap(paths_, next_);
    const auto survivors = resampler_.choose(energies_, crossings_, thinning_.places(), seed);
    std::size_t last = energies_.size();
    for (const Resampler::Survivor& survivor : survivors) {
        const std::size_t lane = next_->count;
        if (survivor.index < present.count) {
            next_->append(present, survivor.index);
        } else {
            next_->append(*emerging_, survivor.index - present.count);
        }
        next_->energy[lane] *= factor * survivor.factor;
        if (survivor.index == last) {
            next_->random[lane] = derive_seed(next_->random[lane], TransmissionSeed::copy, lane);
        }
        last = survivor.index;
    }
    std::swap(paths_, next_);
}

}  // namespace aula
