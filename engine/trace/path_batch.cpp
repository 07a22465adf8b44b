#include "engine/trace/path_batch.h"

#include <algorithm>

#include "engine/base/air_attenuation.h"
#include "engine/base/sampling.h"
#include "process/multiversion.h"

namespace aula {

namespace {

enum class ReflectionSeed : std::uint64_t { mirrored = 1 };

/// Moves to the hits. `normal` holds the triangles' normals on entry and the facing normals on
/// exit.
AULA_MULTIVERSION
void find_points(std::size_t count, PathBatch& paths) {
    const LanePoints& origin = paths.rays.origin;
    const LanePoints& direction = paths.rays.direction;
    LanePoints& normal = paths.normal;
    for (std::size_t i = 0; i < padded_lanes(count); ++i) {
        const float along = normal.x[i] * direction.x[i] + normal.y[i] * direction.y[i] +
                            normal.z[i] * direction.z[i];
        const float side = along <= 0 ? 1.0F : -1.0F;
        const float distance_m = paths.hits.distance_m[i];
        const RayScene::PointOff at = RayScene::point_off(distance_m, -side * along);
        normal.x[i] *= side;
        normal.y[i] *= side;
        normal.z[i] *= side;
        paths.point.x[i] = origin.x[i] + at.along_m * direction.x[i] + at.off_m * normal.x[i];
        paths.point.y[i] = origin.y[i] + at.along_m * direction.y[i] + at.off_m * normal.y[i];
        paths.point.z[i] = origin.z[i] + at.along_m * direction.z[i] + at.off_m * normal.z[i];
        paths.back[i] = along <= 0 ? 0 : 1;
        paths.length_m[i] += distance_m;
    }
}

/// Draws the random numbers for lobe and roulette.
AULA_MULTIVERSION
void draw_choices(std::size_t count, PathBatch& paths) {
    for (std::size_t i = 0; i < padded_lanes(count); ++i) {
        RandomStream random(paths.random[i]);
        const auto u = random.uniform_2d();
        paths.choice[i] = std::max(u[0], PathBatch::kLeastChoice);
        paths.roulette[i] = u[1];
        paths.random[i] = random.state();
    }
}

/// Processes as many paths together as there are bands, so that values with one number per path
/// fill vectors as well.
AULA_MULTIVERSION
void scatter_energies(const RayScene& scene, const Bands& attenuation_per_m, PathBatch& paths) {
    constexpr std::size_t kPaths = kBandCount;
    const BandVector attenuation = load_bands(attenuation_per_m);
    for (std::size_t first = 0; first < paths.count; first += kPaths) {
        std::array<BandVector, kPaths> energy;
        std::array<BandVector, kPaths> scattered;
        for (std::size_t k = 0; k < kPaths; ++k) {
            const std::size_t i = first + k;
            const Material& material = scene.material(paths.material[i]);
            energy[k] = load_bands(paths.energy[i]) *
                        transmission(attenuation, paths.hits.distance_m[i]) *
                        (1 - load_bands(material.absorption));
            scattered[k] = energy[k] * load_bands(material.scattering);
            store_bands(scattered[k], paths.scattered[i].value.data());
        }
        // One ray carries all bands (broad-spectrum diffusion, Embrechts 2000): choose the diffuse
        // lobe with probability p, the energy-weighted mean of s, and weight each band by s_b / p
        // or (1 - s_b) / (1 - p). Where the specular lobe is not chosen but always followed, its
        // weight is 1, and the diffuse one has the probability of all choices so far.
        const BandVector total = sums_over_bands(energy);
        const BandVector to_diffuse = sums_over_bands(scattered);
        BandIntegers diffuse = load_bands(&paths.choice[first]) * total < to_diffuse;
        if (paths.lobes == PathBatch::Lobes::mirrored) diffuse = BandIntegers{};
        BandVector weight = total / (diffuse ? to_diffuse : total - to_diffuse);
        if (paths.lobes == PathBatch::Lobes::mirrored) weight = BandVector{} + 1;
        if (paths.lobes == PathBatch::Lobes::both) {
            const BandIntegers mirrored_so_far = load_integers(&paths.diffuse[first]) == 0;
            const BandVector undivided = load_bands(&paths.undivided[first]);
            const BandVector of_path = diffuse ? weight / undivided : BandVector{} + 1;
            weight = mirrored_so_far ? of_path : weight;
            store_bands(undivided * ((total - to_diffuse) / total), &paths.undivided[first]);
            for (std::size_t k = 0; k < kPaths; ++k) {
                store_bands(energy[k] - scattered[k], paths.specular[first + k].value.data());
            }
        }
        for (std::size_t k = 0; k < kPaths; ++k) {
            const BandIntegers is_diffuse = BandIntegers{} + diffuse[k];
            energy[k] = is_diffuse ? scattered[k] : energy[k] - scattered[k];
        }
        const BandVector before = load_bands(&paths.roulette_energy[first]);
        const BandVector left = maxima_over_bands(energy) * weight / before;
        const BandVector survival = square_roots(left < 1 ? left : BandVector{} + 1);
        const BandIntegers lost = ~(load_bands(&paths.roulette[first]) < survival);
        weight /= survival;
        store_bands(before * survival, &paths.roulette_energy[first]);
        store_integers(diffuse & 1, &paths.to_diffuse[first]);
        store_integers((lost | ~(total > 0)) & 1, &paths.ended[first]);
        for (std::size_t k = 0; k < kPaths; ++k) {
            store_bands(energy[k] * weight[k], paths.energy[first + k].value.data());
        }
    }
}

/// Sets Lambert's or the specular direction.
AULA_MULTIVERSION
void turn_away(std::size_t count, float max_length_m, PathBatch& paths) {
    LanePoints& direction = paths.rays.direction;
    const LanePoints& n = paths.normal;
    for (std::size_t i = 0; i < padded_lanes(count); ++i) {
        RandomStream random(paths.random[i]);
        const Vec3 normal(n.x[i], n.y[i], n.z[i]);
        const Vec3 before(direction.x[i], direction.y[i], direction.z[i]);
        const Vec3 lambert = lambert_direction(normal, random.uniform_2d());
        const Vec3 mirrored = mirror(before, normal);
        paths.random[i] = random.state();
        const bool diffuse = paths.to_diffuse[i] != 0;
        direction.x[i] = diffuse ? lambert.x : mirrored.x;
        direction.y[i] = diffuse ? lambert.y : mirrored.y;
        direction.z[i] = diffuse ? lambert.z : mirrored.z;
        paths.rays.origin.x[i] = paths.point.x[i];
        paths.rays.origin.y[i] = paths.point.y[i];
        paths.rays.origin.z[i] = paths.point.z[i];
        paths.rays.max_m[i] = max_length_m - paths.length_m[i];
        paths.diffuse[i] |= paths.to_diffuse[i];
    }
}

}  // namespace

void PathBatch::set_path(std::size_t lane, const PathBatch& from, std::size_t other) {
    rays.origin.set(lane, from.rays.origin.at(other));
    rays.direction.set(lane, from.rays.direction.at(other));
    rays.max_m[lane] = from.rays.max_m[other];
    ray[lane] = from.ray[other];
    energy[lane] = from.energy[other];
    length_m[lane] = from.length_m[other];
    random[lane] = from.random[other];
    diffuse[lane] = from.diffuse[other];
    to_diffuse[lane] = from.to_diffuse[other];
    identifier[lane] = from.identifier[other];
    image[lane] = from.image[other];
    roulette_energy[lane] = from.roulette_energy[other];
    undivided[lane] = from.undivided[other];
    crossings[lane] = from.crossings[other];
    reflected[lane] = from.reflected[other];
}

void PathBatch::append(const PathBatch& from, std::size_t lane) { set_path(count++, from, lane); }

void PathBatch::take_mirrored(const PathBatch& from, float max_length_m) {
    for (std::size_t i = 0; i < from.count; ++i) {
        if (from.diffuse[i] != 0 || from.to_diffuse[i] == 0 || !(from.specular[i].max() > 0)) {
            continue;
        }
        const std::size_t lane = count++;
        set_path(lane, from, i);
        rays.origin.set(lane, from.point.at(i));
        rays.direction.set(lane, mirror(from.rays.direction.at(i), from.normal.at(i)));
        rays.max_m[lane] = max_length_m - from.length_m[i];
        energy[lane] = from.specular[i];
        to_diffuse[lane] = 0;
        random[lane] = derive_seed(from.random[i], ReflectionSeed::mirrored);
    }
}

void PathBatch::remove(std::size_t lane) {
    const std::size_t last = --count;
    set_path(lane, *this, last);
    hits.triangle[lane] = hits.triangle[last];
    hits.distance_m[lane] = hits.distance_m[last];
    hits.u[lane] = hits.u[last];
    hits.v[lane] = hits.v[last];
    ended[lane] = ended[last];
}

void PathBatch::remove_escaped() {
    for (std::size_t i = count; i-- > 0;) {
        if (hits.triangle[i] == kNoTriangle) remove(i);
    }
}

void PathBatch::remove_ended() {
    for (std::size_t i = count; i-- > 0;) {
        if (ended[i] != 0) remove(i);
    }
}

void PathBatch::arrive(const RayScene& scene) {
    for (std::size_t i = 0; i < count; ++i) {
        const RayScene::Surface& surface = scene.surface(hits.triangle[i]);
        normal.set(i, surface.normal);
        material[i] = surface.material;
    }
    std::fill(material.begin() + count, material.begin() + padded_lanes(count), 0);
    best_version<find_points>(count, *this);
}

void PathBatch::scatter(const RayScene& scene, const Bands& attenuation_per_m) {
    best_version<draw_choices>(count, *this);
    best_version<scatter_energies>(scene, attenuation_per_m, *this);
}

void PathBatch::leave(float max_length_m) {
    best_version<turn_away>(count, max_length_m, *this);
    if (behind_walls) std::fill_n(reflected.begin(), count, 1);
}

}  // namespace aula
