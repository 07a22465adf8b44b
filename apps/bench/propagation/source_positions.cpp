#include "apps/bench/propagation/source_positions.h"

#include "engine/base/sampling.h"
#include "engine/rays/ray_scene.h"

namespace aula::bench {

namespace {

constexpr float kSourceFraction = 0.5F;  // position of a source along a ray to the wall
constexpr float kClear_m = 0.25F;        // around a source, which may walk within it

}  // namespace

std::vector<Vec3> source_positions(const Scene& scene, int count) {
    const RayScene rays(scene);
    std::vector<Vec3> found{scene.sources[0].position_at(0)};
    RandomStream random(derive_seed(scene.simulation.seed, 0xc0d));
    for (int tries = 0; static_cast<int>(found.size()) < count && tries < 100 * count; ++tries) {
        const Ray ray{found[static_cast<std::size_t>(tries) % found.size()],
                      uniform_direction(random.uniform_2d())};
        Hit hit;
        rays.intersect({&ray, 1}, {&hit, 1});
        if (!hit.any() || hit.distance_m < 1) continue;
        const Vec3 place = ray.origin + kSourceFraction * hit.distance_m * ray.direction;
        if (rays.clear_m(place, kClear_m) >= kClear_m) found.push_back(place);
    }
    return found;
}

}  // namespace aula::bench
