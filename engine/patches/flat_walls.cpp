#include "engine/patches/flat_walls.h"

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <map>

#include "engine/base/tolerances.h"

namespace aula {

std::vector<GridAxis::Wall> flat_walls(const RayScene& scene, const Vec3& origin,
                                       const Vec3& direction, WallsOf which) {
    struct Slice {
        GridAxis::Wall wall;
        float largest_m2 = 0;
    };
    std::map<std::int64_t, Slice> slices;  // of the thickness kSame_m
    for (const RayScene::Triangle& triangle : scene.triangles()) {
        if (std::abs(glm::dot(triangle.normal, direction)) < tolerances::kAlongCosine) continue;
        if (which == WallsOf::static_objects && scene.moves(triangle)) continue;
        const float at_m = glm::dot(triangle.vertices[0] - origin, direction);
        const float area_m2 = triangle.area_m2();
        Slice& slice = slices[std::llround(double{at_m} / tolerances::kSame_m)];
        slice.wall.area_m2 += double{area_m2};
        if (area_m2 <= slice.largest_m2) continue;
        slice.largest_m2 = area_m2;
        slice.wall.at_m = at_m;
    }
    std::vector<GridAxis::Wall> walls;
    for (const auto& [number, slice] : slices) walls.push_back(slice.wall);
    return walls;
}

}  // namespace aula
