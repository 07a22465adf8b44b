#include "aula/engine/scene.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <random>

using aula::Pose;
using aula::Vec3;

namespace {

constexpr float kQuarter_rad = glm::half_pi<float>();

// Rounding of sines and a few products of numbers up to 10: some eps.
void check_near(const Vec3& a, const Vec3& b) {
    INFO("(" << a.x << ", " << a.y << ", " << a.z << ") against (" << b.x << ", " << b.y << ", "
             << b.z << ")");
    CHECK(glm::distance(a, b) < 1e-5F);
}

Pose pose_at_x(float x, float yaw_rad = 0) {
    Pose pose;
    pose.position.x = x;
    pose.yaw_rad = yaw_rad;
    return pose;
}

}  // namespace

TEST_CASE("a positive yaw turns the front to the left") {
    const glm::mat3 turned = Pose{.yaw_rad = kQuarter_rad}.rotation();
    check_near(turned * Vec3(1, 0, 0), {0, 1, 0});
    check_near(turned * Vec3(0, 1, 0), {-1, 0, 0});
    check_near(turned * Vec3(0, 0, 1), {0, 0, 1});
}

TEST_CASE("a positive pitch turns the front up") {
    const glm::mat3 turned = Pose{.pitch_rad = kQuarter_rad}.rotation();
    check_near(turned * Vec3(1, 0, 0), {0, 0, 1});
    check_near(turned * Vec3(0, 1, 0), {0, 1, 0});
    check_near(turned * Vec3(0, 0, 1), {-1, 0, 0});
}

TEST_CASE("a positive roll turns the right ear down") {
    const glm::mat3 turned = Pose{.roll_rad = kQuarter_rad}.rotation();
    check_near(turned * Vec3(0, -1, 0), {0, 0, -1});
    check_near(turned * Vec3(1, 0, 0), {1, 0, 0});
}

TEST_CASE("roll is applied before pitch and pitch before yaw") {
    const Pose pose{Vec3(0), kQuarter_rad, kQuarter_rad, kQuarter_rad};
    // The right ear: rolled down, pitched to the front, turned to the left.
    check_near(pose.rotation() * Vec3(0, -1, 0), {0, 1, 0});
}

TEST_CASE("a path is linear between its points and constant before and after them") {
    const aula::Trajectory path{{{1, pose_at_x(0, 0)}, {3, pose_at_x(4, 2)}, {4, pose_at_x(4, 6)}},
                                false};
    CHECK(path.at(0).position.x == 0);
    CHECK(path.at(1).position.x == 0);
    CHECK(path.at(1.5).position.x == 1);
    CHECK(path.at(2.5).yaw_rad == 1.5F);
    CHECK(path.at(3.5).yaw_rad == 4);
    CHECK(path.at(100).yaw_rad == 6);
    CHECK(path.duration_s() == 4);
}

TEST_CASE("a looped path repeats after its last time") {
    const aula::Trajectory path{{{0, pose_at_x(0)}, {4, pose_at_x(8)}}, true};
    CHECK(path.at(3).position.x == 6);
    CHECK(path.at(4).position.x == 0);
    CHECK(path.at(4 * 1000 + 1).position.x == 2);
    CHECK(path.at(-1).position.x == 6);
}

TEST_CASE("two points at one time are a jump to the second") {
    const aula::Trajectory path{{{0, pose_at_x(0)}, {1, pose_at_x(1)}, {1, pose_at_x(5)}}, false};
    CHECK(path.at(0.5).position.x == 0.5F);
    CHECK(path.at(1).position.x == 5);
}

TEST_CASE("a path of one point is constant, looped or not") {
    for (const bool loop : {false, true}) {
        const aula::Trajectory path{{{0, pose_at_x(7)}}, loop};
        CHECK(path.at(0).position.x == 7);
        CHECK(path.at(12).position.x == 7);
    }
}

TEST_CASE("world vertices are rotated about the local origin, then moved by path and translation") {
    aula::Object object;
    object.vertices = {{1, 0, 0}, {0, 0, 2}};
    object.translation = {100, 0, 0};
    const auto still = object.world_vertices(5);
    CHECK(still[0] == Vec3(101, 0, 0));
    CHECK(still[1] == Vec3(100, 0, 2));

    Pose turned;
    turned.position = {0, 10, 0};
    turned.yaw_rad = kQuarter_rad;
    object.path = aula::Trajectory{{{0, Pose{}}, {1, turned}}, false};
    check_near(object.world_vertices(0)[0], {101, 0, 0});
    check_near(object.world_vertices(1)[0], {100, 11, 0});
    check_near(object.world_vertices(1)[1], {100, 10, 2});
}

TEST_CASE(
    "the bounds of geometry contain its vertices at every point of their paths, and those of boxes "
    "are "
    "exact") {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> coordinate(-3, 3);
    const auto point = [&] {
        return Vec3(coordinate(random), coordinate(random), coordinate(random));
    };
    for (int i = 0; i < 100; ++i) {
        const bool is_box = i % 2 == 0;
        aula::Object object;
        const Vec3 size = point();
        for (unsigned v = 0; v < 8; ++v) {
            const Vec3 corner((v & 1U) != 0, (v & 2U) != 0, (v & 4U) != 0);
            object.vertices.push_back(is_box ? size * corner : point());
        }
        object.translation = point();
        object.path.emplace();
        object.path->loop = i % 3 == 0;
        for (int p = 0; p < 6; ++p) {
            const double time_s = p / 2;  // every second point is a jump
            object.path->points.push_back({time_s, {point(), coordinate(random)}});
        }
        aula::Bounds every;
        for (const auto& p : object.path->points) {
            for (const Vec3& v : object.world_vertices(p.time_s)) every.add(v);
        }
        const aula::Bounds found = aula::geometry_bounds({object});
        CHECK(found.contains(every.min));
        CHECK(found.contains(every.max));
        if (is_box) CHECK(found.min == every.min);
        if (is_box) CHECK(found.max == every.max);
    }
}

TEST_CASE("the bounds of a mesh on a path of a million points are found in linear time") {
    // Every vertex at every point would be 1e11 operations: hours.
    aula::Object object;
    for (int v = 0; v < 100'000; ++v) {
        const auto angle = static_cast<float>(v);
        object.vertices.emplace_back(std::cos(angle), std::sin(angle), 0);
    }
    object.path.emplace();
    for (int p = 0; p < 1'000'000; ++p) {
        object.path->points.push_back(
            {static_cast<double>(p), pose_at_x(std::cos(0.1F * static_cast<float>(p)))});
    }
    // Rounding, and the angles between vertices.
    CHECK(aula::geometry_bounds({object}).max.x == Approx(2).margin(1e-3));
}

TEST_CASE("between two points of a path the position and all angles are interpolated") {
    const aula::Pose a{{1, 2, 3}, 0.1F, 0.2F, 0.3F};
    const aula::Pose b{{3, 6, 9}, 0.5F, 1.0F, 1.5F};
    aula::Trajectory path;
    path.points = {{1, a}, {3, b}};
    const aula::Pose quarter = path.at(1.5);
    CHECK(quarter.position == aula::Vec3(1.5F, 3, 4.5F));
    CHECK(quarter.yaw_rad == Approx(0.2));
    CHECK(quarter.pitch_rad == Approx(0.4));
    CHECK(quarter.roll_rad == Approx(0.6));
}

TEST_CASE("a material of the scene takes precedence over the library's of the same name") {
    aula::Scene scene;
    const aula::Material library = scene.find_material("wood");
    scene.materials = {{"own", aula::Bands::filled(0.2F), aula::Bands{}},
                       {"wood", aula::Bands::filled(0.77F), aula::Bands{}}};
    CHECK(library.absorption != scene.materials[1].absorption);
    CHECK(scene.find_material("wood").absorption == scene.materials[1].absorption);
    CHECK(scene.find_material("own").absorption == scene.materials[0].absorption);
}

TEST_CASE("a material may transmit what it absorbs, to the rounding of single precision") {
    aula::Material material;
    material.sound_reduction_db = aula::Bands::filled(0);  // all sound
    const auto refused = [&](double excess) {
        material.absorption = aula::Bands::filled(static_cast<float>(1 / (1 + excess)));
        return material.transmits_too_much(3);
    };
    CHECK_FALSE(refused(0));
    CHECK_FALSE(refused(0.5e-6));  // eight roundings
    CHECK(refused(1.5e-6));
}
