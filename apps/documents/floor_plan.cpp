#include "apps/documents/floor_plan.h"

#include <glm/common.hpp>
#include <glm/vec3.hpp>

namespace aula {

FloorPlan floor_plan(const RayScene& scene, float z_m) {
    FloorPlan plan;
    Bounds bounds;
    for (const RayScene::Triangle& triangle : scene.triangles()) {
        bounds.add(triangle.vertices);
        std::array<glm::vec2, 2> line;
        std::size_t ends = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3& a = triangle.vertices[i];
            const Vec3& b = triangle.vertices[(i + 1) % 3];
            // A corner in the plane counts as above it, so that neighbours are cut alike.
            if ((a.z < z_m) == (b.z < z_m)) continue;
            line[ends++] = glm::vec2(glm::mix(a, b, (z_m - a.z) / (b.z - a.z)));
        }
        if (ends == 2 && line[0] != line[1]) plan.walls.push_back(line);
    }
    if (scene.triangle_count() > 0) {
        plan.min = glm::vec2(bounds.min);
        plan.max = glm::vec2(bounds.max);
    }
    return plan;
}

}  // namespace aula
