#include "apps/window/view/camera.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

using namespace aula;

TEST_CASE("A room fills the picture in any shape of it and from any side") {
    const std::array<Vec3, 8> room{Vec3(2, 1, 0), {14, 1, 0}, {14, 6, 0}, {2, 6, 0},
                                   Vec3(2, 1, 3), {14, 1, 3}, {14, 6, 3}, {2, 6, 3}};
    struct Size {
        float width;
        float height;
    };
    for (const Size size : {Size{560, 380}, {940, 560}, {1560, 770}, {400, 900}}) {
        for (const float yaw_rad : {-2.2F, 0.3F, 1.6F}) {
            INFO(size.width << " x " << size.height << ", yaw " << yaw_rad);
            Camera camera{.yaw_rad = yaw_rad};
            camera.show(room, size.width, size.height);
            const Screen screen(camera, Pose{}, {0, 0}, {size.width, size.height});
            float from_left = 1;
            float from_right = 1;
            float from_top = 1;
            float from_bottom = 1;
            for (const Vec3& corner : room) {
                const auto at = screen.project(corner);
                REQUIRE(at);
                from_left = std::min(from_left, at->x / size.width);
                from_right = std::min(from_right, 1 - at->x / size.width);
                from_top = std::min(from_top, at->y / size.height);
                from_bottom = std::min(from_bottom, 1 - at->y / size.height);
            }
            // A twentieth of the picture is free at each side in one direction, and more in the
            // other, evenly.
            CHECK(std::min(from_left, from_top) == Approx(0.05F).margin(1e-3));
            CHECK(std::min(from_right, from_bottom) == Approx(0.05F).margin(1e-3));
            const bool fills_width = from_left < from_top;
            CHECK((fills_width ? from_left - from_right : from_top - from_bottom) ==
                  Approx(0).margin(1e-3));
        }
    }
}

TEST_CASE("Without points or without a picture the view stays") {
    Camera camera{.target = {1, 2, 3}, .distance_m = 4};
    camera.show({}, 100, 100);
    camera.show(std::array{Vec3(9)}, 0, 100);
    CHECK(camera.target == Vec3(1, 2, 3));
    CHECK(camera.distance_m == 4);
}

TEST_CASE("Rooms of any size lie between the near and the far plane, with depths that differ") {
    for (const float size_m : {0.5F, 10.0F, 800.0F, 30'000.0F}) {
        INFO("size " << size_m << " m");
        const std::array<Vec3, 3> room{Vec3(0), Vec3(size_m, 0.6F * size_m, 0.2F * size_m),
                                       Vec3(0.5F * size_m, 0.01F * size_m, 0)};
        Camera camera;
        camera.surround(room);
        camera.show(room, 800, 600);
        const auto depth = [&](const Vec3& point) {
            const Screen screen(camera, Pose{}, {0, 0}, {800, 600});
            const glm::vec4 clip = screen.matrix() * glm::vec4(point, 1);
            return clip.z / clip.w;
        };
        constexpr float kSteps = 1 << 23;  // of 24 bits between -1 and 1
        for (int zooms = 0; zooms < 60; ++zooms) {
            for (const Vec3& point : room) {
                CHECK(depth(point) < 1);
                if (camera.distance_m > camera.radius_m) CHECK(depth(point) > -1);
            }
            camera.zoom(1.2F);
        }
        // A thousandth of the room is resolved from the farthest eye.
        const Vec3 away = glm::normalize(camera.eye(Pose{}) - camera.target);
        CHECK(std::abs(depth(camera.target) - depth(camera.target - 1e-3F * size_m * away)) >
              1 / kSteps);
        camera.first_person = true;
        CHECK(depth(room[1]) < 1);
    }
}
