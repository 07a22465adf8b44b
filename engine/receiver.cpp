#include "engine/receiver.h"

#include <algorithm>
#include <vector>

#include "engine/sampling.h"

namespace aula {

Receiver make_receiver(const RayScene& scene, const Vec3& position, float radius_m) {
    constexpr std::uint32_t kLooks = 512;  // 0.3 % for half a sphere
    const ScrambledSobol sobol(1);
    std::vector<Ray> looks(kLooks);
    for (std::uint32_t i = 0; i < kLooks; ++i) {
        looks[i] = {position, uniform_direction(sobol.point(i)), radius_m};
    }
    std::vector<Hit> hits(kLooks);
    scene.intersect(looks, hits);
    // A cone that ends after r of R holds (r / R)^3 of its part of the sphere.
    float share = 0;
    for (const Hit& hit : hits) {
        const float r = std::min(hit.distance_m, radius_m) / radius_m;
        share += r * r * r / kLooks;
    }
    return {position, std::max(share, 1e-3F)};
}

}  // namespace aula
