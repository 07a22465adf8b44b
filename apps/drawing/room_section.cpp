#include "apps/drawing/room_section.h"

#include <glm/common.hpp>
#include <glm/vec3.hpp>

namespace aula {

namespace {

/// The section across an axis, in x and the axis `up`.
RoomSection section(const RayScene& scene, int across, float at_m, int up) {
    RoomSection section;
    Bounds bounds;
    const auto flat = [&](const Vec3& point) { return glm::vec2(point.x, point[up]); };
    for (const RayScene::Triangle& triangle : scene.triangles()) {
        bounds.add(triangle.vertices);
        std::array<glm::vec2, 2> line;
        std::size_t ends = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3& a = triangle.vertices[i];
            const Vec3& b = triangle.vertices[(i + 1) % 3];
            // A corner in the plane counts as beyond it, so that neighbours are cut alike.
            if ((a[across] < at_m) == (b[across] < at_m)) continue;
            line[ends++] = flat(glm::mix(a, b, (at_m - a[across]) / (b[across] - a[across])));
        }
        if (ends == 2 && line[0] != line[1]) section.walls.push_back(line);
    }
    if (scene.triangle_count() > 0) {
        section.min = flat(bounds.min);
        section.max = flat(bounds.max);
    }
    return section;
}

}  // namespace

RoomSection floor_plan(const RayScene& scene, float z_m) { return section(scene, 2, z_m, 1); }

RoomSection side_view(const RayScene& scene, float y_m) { return section(scene, 1, y_m, 2); }

}  // namespace aula
