#include "aula/engine/axes.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "aula/exception.h"

using namespace aula;

namespace {

double distance(const Vec3& a, const Vec3& b) { return static_cast<double>(glm::distance(a, b)); }

// Rounding: a dozen operations of 6e-8 on numbers below 10.
constexpr double kRounding = 1e-5;

}  // namespace

TEST_CASE("Conversions from and to the axes of other programs are inverse") {
    const Vec3 v{1, 2, 3};
    CHECK(from_axes(Axes::z_up, v) == v);
    CHECK(from_axes(Axes::y_up, v) == Vec3(1, -3, 2));
    CHECK(from_axes(Axes::y_up_left_handed, v) == Vec3(1, 3, 2));
    CHECK(from_axes(Axes::z_up_left_handed, v) == Vec3(1, -2, 3));
    for (const Axes axes : {Axes::z_up, Axes::y_up, Axes::y_up_left_handed, Axes::z_up_left_handed})
        CHECK(to_axes(axes, from_axes(axes, v)) == v);
}

TEST_CASE("A rigid motion in other axes moves the same points, and stays a rotation") {
    Pose pose;
    pose.position = {0.5F, -1, 2};
    pose.yaw_rad = 0.7F;
    pose.pitch_rad = -0.3F;
    pose.roll_rad = 1.1F;
    const RigidTransform host(pose);
    for (const Axes axes :
         {Axes::z_up, Axes::y_up, Axes::y_up_left_handed, Axes::z_up_left_handed}) {
        const RigidTransform here = from_axes(axes, host);
        const Vec3 point{3, -2, 5};
        const Vec3 moved = host.rotation * point + host.translation;
        CHECK(distance(here.rotation * from_axes(axes, point) + here.translation,
                       from_axes(axes, moved)) < kRounding);
        CHECK(static_cast<double>(glm::determinant(here.rotation)) == Approx(1).margin(kRounding));
    }
}

TEST_CASE("A pose from a front and a top of the head has these axes") {
    const auto check = [](const Vec3& front, const Vec3& up) {
        const glm::mat3 axes = pose_looking({1, 2, 3}, front, up).rotation();
        CHECK(distance(axes[0], glm::normalize(front)) < 2e-4);
        // Component of the top perpendicular to the front.
        const Vec3 x = glm::normalize(front);
        CHECK(distance(axes[2], glm::normalize(up - glm::dot(up, x) * x)) < 2e-4);
    };
    check({1, 0, 0}, {0, 0, 1});
    check({-3, 1, 0.5F}, {0, 0, 1});
    check({0, 2, -1}, {1, 0, 1});
    check({1, 1, 0}, {0, 0, -1});
    // Straight up and down; the arcsine of 1 is rounded to 1e-4.
    check({0, 0, 1}, {-1, 0, 0});
    check({0, 0, -2}, {0, 1, 0});
}

TEST_CASE("An object from memory has a material of the scene or of the library") {
    Scene scene;
    scene.materials.push_back({"felt", Bands::filled(0.9F), Bands::filled(0.5F)});
    const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    CHECK(scene.add_object(vertices, {{0, 1, 2}}, "felt", "curtain") == 0);
    CHECK(scene.add_object(vertices, {{0, 1, 2}}, "wood") == 1);
    CHECK(scene.add_object(vertices, {{0, 1, 2}}, "wood") == 2);
    REQUIRE(scene.materials.size() == 2);
    CHECK(scene.materials[1].name == "wood");
    CHECK(scene.objects[0].name == "curtain");
    CHECK(scene.objects[0].triangle_materials == std::vector<std::uint32_t>{0});
    CHECK(scene.objects[2].triangle_materials == std::vector<std::uint32_t>{1});
    CHECK_THROWS_AS(scene.add_object(vertices, {{0, 1, 2}}, "cheese"), InputError);
}
