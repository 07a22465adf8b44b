#include "engine/rays/nudge_off_surface.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "tests/support/rooms.h"

using namespace aula;

namespace {

const Vec3 kSize(5, 4, 3);

/// Inside the box by a step of 1 mm, up to rounding.
bool is_inside(const Vec3& position) {
    constexpr float kStep_m = 0.99e-3F;
    for (int axis = 0; axis < 3; ++axis) {
        if (position[axis] < kStep_m || position[axis] > kSize[axis] - kStep_m) return false;
    }
    return true;
}

}  // namespace

TEST_CASE(
    "a position on a wall, an edge or a corner is moved into the room, for any orientation of the "
    "faces") {
    Object walls = test::box(kSize);
    for (const bool outward : {false, true}) {
        if (outward)
            for (auto& triangle : walls.triangles) std::swap(triangle[0], triangle[1]);
        const RayScene rays(test::grey_room(walls, 0.1F, 1, Vec3(1), Vec3(2)));
        for (int position = 0; position < 27; ++position) {
            const Vec3 share(static_cast<float>(position % 3), static_cast<float>(position / 3 % 3),
                             static_cast<float>(position / 9));
            const Vec3 at = 0.5F * share * kSize;
            if (share == Vec3(1)) continue;  // the centre
            const Vec3 moved = nudge_off_surface(rays, at);
            CAPTURE(outward, at.x, at.y, at.z, moved.x, moved.y, moved.z);
            CHECK(is_inside(moved));
            // A step from each of three walls.
            CHECK(glm::distance(moved, at) < 2e-3F);
        }
        const Vec3 free(1, 2, 1.5F);
        CHECK(nudge_off_surface(rays, free) == free);
    }
}
