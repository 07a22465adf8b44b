#include "engine/trace/path_batch.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <utility>

#include "engine/base/sampling.h"
#include "tests/support/rooms.h"

using namespace aula;

TEST_CASE("hit points are off the surface on the ray's side, at any distance and angle") {
    // Few triangles, and more than the brute-force intersector takes.
    const std::pair<Object, float> rooms[] = {
        {test::box(Vec3(1000, 150, 40), 0, Vec3(-500, -75, -20)), 19.9F},
        {test::icosphere(100, 4), 99},
        {test::icosphere(680, 4), 670}};  // across it: the longest path
    for (const auto& [walls, from_m] : rooms) {
        const Scene scene = test::grey_room(walls, 0.1F, 1, Vec3(0), Vec3(1));
        const RayScene rays(scene);
        RandomStream random(1);
        const auto paths = std::make_unique<PathBatch>();
        for (int round = 0; round < 50; ++round) {
            paths->count = kLanes;
            for (std::size_t i = 0; i < kLanes; ++i) {
                paths->rays.origin.set(i, from_m * uniform_direction(random.uniform_2d()));
                paths->rays.direction.set(i, uniform_direction(random.uniform_2d()));
                paths->rays.max_m[i] = 1400;
            }
            rays.intersect(paths->rays, paths->count, paths->hits);
            paths->arrive(rays);
            for (std::size_t i = 0; i < kLanes; ++i) {
                REQUIRE(paths->hits.triangle[i] != kNoTriangle);
                const RayScene::Triangle& t = rays.triangle(paths->hits.triangle[i]);
                const glm::dvec3 normal(paths->normal.at(i));
                const double off_m =
                    glm::dot(normal, glm::dvec3(paths->point.at(i)) - glm::dvec3(t.vertices[0]));
                // Single precision rounds positions of a kilometre to 3e-5.
                const float distance_m = paths->hits.distance_m[i];
                CHECK(off_m > 5e-5);
                CHECK(off_m < 2 * double{RayScene::offset_after(distance_m)});
                CHECK(glm::dot(normal, glm::dvec3(paths->rays.direction.at(i))) < 0);
            }
        }
    }
}

TEST_CASE("hit points lie between faces that meet at an acute angle") {
    // Two faces that meet at x = z = 0 with 30 degrees between them, the lower one at z = 0.
    const float slope = std::tan(std::numbers::pi_v<float> / 6);
    Object wedge;
    wedge.vertices = {Vec3(0, -2, 0), Vec3(0, 2, 0),          Vec3(3, -2, 0),
                      Vec3(3, 2, 0),  Vec3(3, -2, 3 * slope), Vec3(3, 2, 3 * slope)};
    wedge.triangles = {{0, 2, 3}, {0, 3, 1}, {0, 4, 5}, {0, 5, 1}};
    wedge.triangle_materials.assign(4, 0);
    const RayScene rays(test::grey_room(wedge, 0.1F, 1, Vec3(2, 0, 0.5F), Vec3(2, 0, 0.6F)));
    RandomStream random(1);
    const auto paths = std::make_unique<PathBatch>();
    int tested = 0;
    for (int round = 0; round < 20; ++round) {
        paths->count = kLanes;
        for (std::size_t i = 0; i < kLanes; ++i) {
            // To the lower face within 0.1 mm of the edge: the point along the normal is on the
            // other side.
            const auto [u, v] = random.uniform_2d();
            const Vec3 origin(1 + u, 0, (0.2F + 0.7F * v) * slope);
            const Vec3 target(2e-5F + 8e-5F * random.uniform(), 2 * random.uniform() - 1, 0);
            paths->rays.origin.set(i, origin);
            paths->rays.direction.set(i, glm::normalize(target - origin));
            paths->rays.max_m[i] = 10;
        }
        rays.intersect(paths->rays, paths->count, paths->hits);
        paths->arrive(rays);
        for (std::size_t i = 0; i < kLanes; ++i) {
            const Vec3 point = paths->point.at(i);
            // Exact, except for rays nearly parallel to the face: their point is offset along the
            // normal.
            if (paths->rays.direction.at(i).z > -0.11F) continue;
            if (paths->hits.triangle[i] > 1) continue;
            CHECK(point.z < slope * point.x);
            CHECK(point.z > 5e-5F);
            ++tested;
        }
    }
    CHECK(tested > 1000);  // companion
}

TEST_CASE("a lobe of negligible energy is never chosen") {
    std::uint64_t state = 0;
    while (RandomStream(state).uniform_2d()[0] != 0) ++state;
    const Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1e-40F, Vec3(1), Vec3(2));
    const auto paths = std::make_unique<PathBatch>();
    paths->count = 1;
    paths->energy[0] = Bands::filled(1);
    paths->random[0] = state;
    paths->scatter(RayScene(scene), Bands{});
    CHECK(paths->to_diffuse[0] == 0);
    CHECK(paths->energy[0].sum() == Approx(0.9 * kBandCount));
}
