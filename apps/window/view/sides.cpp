#include "apps/window/view/sides.h"

#include <glm/geometric.hpp>

#include "engine/rays/room_survey.h"

namespace aula {

std::vector<std::uint8_t> interior_sides(const RayScene& rays, std::span<const Vec3> inside) {
    constexpr int kPaths = 4096;
    constexpr int kBounces = 24;
    constexpr float kSmall_m2 = 0.5F;
    constexpr std::uint8_t kBoth = 3;
    std::vector<std::uint8_t> sides(rays.triangle_count(), 0);
    trace_random_walks(rays, inside, {.paths = kPaths, .bounces = kBounces, .seed = 1},
                       [&](float, const Ray& ray, const Hit& hit) {
                           if (!hit.any()) return;
                           const bool front =
                               glm::dot(rays.triangle(hit.triangle).normal, ray.direction) < 0;
                           sides[hit.triangle] |= front ? 1 : 2;
                       });
    for (std::uint32_t t = 0; t < sides.size(); ++t) {
        const RayScene::Triangle& triangle = rays.triangle(t);
        if (rays.moves(triangle) || (sides[t] == 0 && triangle.area_m2() < kSmall_m2))
            sides[t] = kBoth;
    }
    return sides;
}

}  // namespace aula
