#include "engine/path_wave.h"

#include "engine/multiversion.h"
#include "engine/sampling.h"
#include "engine/transmission.h"

namespace aula {

namespace {

/// Corners and normals of the triangles that were hit.
struct Corners {
    std::array<LanePoints, 3> vertex;
    LanePoints normal;
};

AULA_MULTIVERSION
void find_points(const Corners& corners, const LanePoints& direction, const HitLanes& hits,
                 std::size_t count, PathWave& wave) {
    const auto& [a, b, c] = corners.vertex;
    const LanePoints& n = corners.normal;
    for (std::size_t i = 0; i < padded_lanes(count); ++i) {
        const float along =
            n.x[i] * direction.x[i] + n.y[i] * direction.y[i] + n.z[i] * direction.z[i];
        const float side = along <= 0 ? 1.0F : -1.0F;
        const float u = hits.u[i];
        const float v = hits.v[i];
        const float nx = side * n.x[i];
        const float ny = side * n.y[i];
        const float nz = side * n.z[i];
        wave.normal.x[i] = nx;
        wave.normal.y[i] = ny;
        wave.normal.z[i] = nz;
        wave.point.x[i] =
            a.x[i] + u * (b.x[i] - a.x[i]) + v * (c.x[i] - a.x[i]) + RayScene::kOffset_m * nx;
        wave.point.y[i] =
            a.y[i] + u * (b.y[i] - a.y[i]) + v * (c.y[i] - a.y[i]) + RayScene::kOffset_m * ny;
        wave.point.z[i] =
            a.z[i] + u * (b.z[i] - a.z[i]) + v * (c.z[i] - a.z[i]) + RayScene::kOffset_m * nz;
        wave.back[i] = along <= 0 ? 0 : 1;
        wave.length_m[i] += hits.distance_m[i];
    }
}

/// Draws what decides on lobe and roulette.
AULA_MULTIVERSION
void draw_choices(std::size_t count, PathWave& wave) {
    for (std::size_t i = 0; i < padded_lanes(count); ++i) {
        RandomStream random(wave.random[i]);
        const auto u = random.uniform_2d();
        wave.choice[i] = u[0];
        wave.roulette[i] = u[1];
        wave.random[i] = random.state();
    }
}

AULA_MULTIVERSION
void scatter_energies(const RayScene& scene, const Bands& attenuation_per_m, PathWave& wave) {
    const BandVector attenuation = load_bands(attenuation_per_m);
    for (std::size_t i = 0; i < wave.count; ++i) {
        const Material& material = scene.material(wave.material[i]);
        const BandVector scattering = load_bands(material.scattering);
        const BandVector energy = load_bands(wave.energy[i]) *
                                  transmission(attenuation, wave.hits.distance_m[i]) *
                                  (1 - load_bands(material.absorption));
        const BandVector scattered = energy * scattering;
        store_bands(scattered, wave.scattered[i].value.data());
        // One ray carries all bands: choose the lobe with p, the energy-weighted mean of s, and
        // weigh each band by s_b / p or (1 - s_b) / (1 - p).
        const auto [total, to_diffuse] = sums_of_bands(energy, scattered);
        // Chosen in every lane: a branch would be mispredicted.
        const BandVector all_diffuse = BandVector{} + to_diffuse;
        const BandIntegers diffuse = BandVector{} + wave.choice[i] * total < all_diffuse;
        const BandVector lobe = diffuse ? all_diffuse : total - all_diffuse;
        BandVector leaving = (diffuse ? scattered : energy - scattered) * (total / lobe);
        const float strongest = max_of_bands(leaving)[0];
        wave.to_diffuse[i] = diffuse[0] != 0 ? 1 : 0;
        wave.ended[i] = total > 0 ? 0 : 1;
        if (strongest < PathWave::kRouletteEnergy) {
            const float survival = strongest / PathWave::kRouletteEnergy;
            if (!(wave.roulette[i] < survival)) wave.ended[i] = 1;
            leaving *= 1 / survival;
        }
        store_bands(leaving, wave.energy[i].value.data());
    }
}

/// Lambert's or the mirror's direction.
AULA_MULTIVERSION
void turn_away(std::size_t count, float max_length_m, PathWave& wave) {
    LanePoints& direction = wave.rays.direction;
    const LanePoints& n = wave.normal;
    for (std::size_t i = 0; i < padded_lanes(count); ++i) {
        RandomStream random(wave.random[i]);
        const Vec3 normal(n.x[i], n.y[i], n.z[i]);
        const Vec3 before(direction.x[i], direction.y[i], direction.z[i]);
        const Vec3 lambert = lambert_direction(normal, random.uniform_2d());
        const Vec3 mirrored = mirror(before, normal);
        wave.random[i] = random.state();
        const bool diffuse = wave.to_diffuse[i] != 0;
        direction.x[i] = diffuse ? lambert.x : mirrored.x;
        direction.y[i] = diffuse ? lambert.y : mirrored.y;
        direction.z[i] = diffuse ? lambert.z : mirrored.z;
        wave.rays.origin.x[i] = wave.point.x[i];
        wave.rays.origin.y[i] = wave.point.y[i];
        wave.rays.origin.z[i] = wave.point.z[i];
        wave.rays.max_m[i] = max_length_m - wave.length_m[i];
        wave.diffuse[i] |= wave.to_diffuse[i];
    }
}

void move_lane(LanePoints& points, std::size_t from, std::size_t to) {
    points.x[to] = points.x[from];
    points.y[to] = points.y[from];
    points.z[to] = points.z[from];
}

}  // namespace

void PathWave::remove(std::size_t lane) {
    const std::size_t last = --count;
    move_lane(rays.origin, last, lane);
    move_lane(rays.direction, last, lane);
    rays.max_m[lane] = rays.max_m[last];
    ray[lane] = ray[last];
    energy[lane] = energy[last];
    length_m[lane] = length_m[last];
    random[lane] = random[last];
    diffuse[lane] = diffuse[last];
    to_diffuse[lane] = to_diffuse[last];
    identifier[lane] = identifier[last];
    hits.triangle[lane] = hits.triangle[last];
    hits.distance_m[lane] = hits.distance_m[last];
    hits.u[lane] = hits.u[last];
    hits.v[lane] = hits.v[last];
    ended[lane] = ended[last];
}

void PathWave::arrive(const RayScene& scene) {
    Corners corners;
    for (std::size_t i = 0; i < count; ++i) {
        const RayScene::Triangle& triangle = scene.triangle(hits.triangle[i]);
        for (std::size_t k = 0; k < 3; ++k) corners.vertex[k].set(i, triangle.vertices[k]);
        corners.normal.set(i, triangle.normal);
        material[i] = triangle.material;
    }
    find_points(corners, rays.direction, hits, count, *this);
}

void PathWave::scatter(const RayScene& scene, const Bands& attenuation_per_m) {
    draw_choices(count, *this);
    scatter_energies(scene, attenuation_per_m, *this);
}

void PathWave::leave(float max_length_m) { turn_away(count, max_length_m, *this); }

}  // namespace aula
