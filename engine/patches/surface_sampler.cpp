#include "engine/patches/surface_sampler.h"

#include <algorithm>
#include <cmath>

#include "engine/base/sampling.h"
#include "engine/base/tolerances.h"
#include "engine/patches/cell_clipping.h"

namespace aula {

namespace {

/// Parts of a patch that are too small for a separate sample. One of them, drawn by area, has one
/// sample for all, so that the number of samples depends on area, not on the number of triangles.
struct Reservoir {
    float area_m2 = 0;
    SurfaceSample drawn;
};

}  // namespace

/// Calls `visit(patch, part, area, normal)` for the part of both sides of a triangle in every cell.
template <typename Visit>
void SurfaceSampler::for_each_part(std::uint32_t t, const Visit& visit) {
    const RayScene::Triangle& triangle = scene_.triangle(t);
    if (triangle.normal == Vec3(0)) return;
    for (const bool back : {false, true}) {
        const Vec3 normal = back ? -triangle.normal : triangle.normal;
        ClippedPolygon whole;
        for (const Vec3& v : triangle.vertices) {
            whole.add(v - grid_.origin() + tolerances::kOffset_m * normal);
        }
        for_each_cell(whole, grid_.cuts(), 0, {},
                      [&](const CellIndex& cell, const ClippedPolygon& part) {
                          const float area = part.area_m2();
                          if (area > 0)
                              visit(index_.use(CellGrid::key(cell, normal)), part, area, normal);
                      });
    }
}

void SurfaceSampler::for_each_patch(
    std::uint32_t triangle, const std::function<void(std::uint32_t, const Vec3&, float)>& visit) {
    for_each_part(triangle, [&](std::uint32_t patch, const ClippedPolygon&, float area,
                                const Vec3& normal) { visit(patch, normal, area); });
}

/// The number of samples per square metre of a patch of share 1. Each sample is tested by rays,
/// which take the longer the more faces cross: without a limit of the samples, time would increase
/// with the square of the number of faces.
float SurfaceSampler::density(std::span<const std::uint32_t> triangles, int per_cell,
                              const ShareOf& share_of) {
    constexpr double kFewSamples = 1 << 14;  // a choice: tested in less than 0.1 s
    const float full_per_m2 = static_cast<float>(per_cell) / (grid_.size_m() * grid_.size_m());
    double all_m2 = 0;
    for (const std::uint32_t t : triangles) all_m2 += 2 * double{scene_.triangle(t).area_m2()};
    if (all_m2 * double{full_per_m2} <= kFewSamples) return full_per_m2;
    double area_m2 = 0;  // times the shares
    double patches = 0;
    std::vector<char> counted;
    for (const std::uint32_t t : triangles) {
        for_each_part(t, [&](std::uint32_t patch, const ClippedPolygon&, float area, const Vec3&) {
            const float share = share_of(patch);
            if (!(share > 0)) return;
            area_m2 += double{share * area};
            if (counted.size() <= patch) counted.resize(index_.size());
            if (counted[patch]) return;
            counted[patch] = 1;
            patches += double{share};
        });
    }
    const double most_per_m2 = kFullCells * per_cell * patches / area_m2;
    return area_m2 > 0 && most_per_m2 < double{full_per_m2} ? static_cast<float>(most_per_m2)
                                                            : full_per_m2;
}

std::vector<SurfaceSample> SurfaceSampler::sample(std::span<const std::uint32_t> triangles,
                                                  int per_cell, const ShareOf& share_of) {
    std::vector<SurfaceSample> samples;
    std::vector<Reservoir> reservoirs;  // [patch]
    const float full_per_m2 = density(triangles, per_cell, share_of);
    for (const std::uint32_t t : triangles) {
        const ScrambledSobol sobol(derive_seed(seed_, t));
        std::uint32_t next = 0;
        for_each_part(t, [&](std::uint32_t patch, const ClippedPolygon& part, float area,
                             const Vec3& normal) {
            const float share = share_of(patch);
            if (!(share > 0)) return;
            const float samples_per_m2 = share * full_per_m2;
            const float most = share * static_cast<float>(per_cell);
            const auto sample_of = [&](float area_m2) {
                const Vec3 point = grid_.origin() + part.point(sobol.point(next++)) -
                                   tolerances::kOffset_m * normal;
                return SurfaceSample{point, normal, t, patch, area_m2};
            };
            if (area * samples_per_m2 >= 1) {
                const int count =
                    static_cast<int>(std::ceil(std::min(area * samples_per_m2, most)));
                for (int i = 0; i < count; ++i) {
                    samples.push_back(sample_of(area / static_cast<float>(count)));
                }
                return;
            }
            if (reservoirs.size() <= patch) reservoirs.resize(index_.size());
            Reservoir& rest = reservoirs[patch];
            rest.area_m2 += area;
            const float u = RandomStream(derive_seed(seed_, t, patch)).uniform();
            if (u * rest.area_m2 < area) rest.drawn = sample_of(0);
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

}  // namespace aula
