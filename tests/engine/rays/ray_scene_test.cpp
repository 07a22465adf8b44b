#include "engine/rays/ray_scene.h"
#include "engine/base/tolerances.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <vector>

#include "engine/base/sampling.h"
#include "tests/support/rooms.h"

using namespace aula;

namespace {

/// Rays without a hit.
std::size_t leaks(const RayScene& scene, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    scene.intersect(rays, hits);
    return static_cast<std::size_t>(
        std::count_if(hits.begin(), hits.end(), [](const Hit& hit) { return !hit.any(); }));
}

}  // namespace

TEST_CASE("rays in a box hit its walls at the right points, in batches of any size") {
    const Vec3 size(5, 4, 3);
    const Vec3 origin(1, 2, 1.5F);
    const RayScene scene(test::grey_room(test::box(size), 0.1F, 1, origin, origin));
    for (const std::size_t count : {1U, 15U, 16U, 17U, 100U}) {
        RandomStream random(count);
        std::vector<Ray> rays(count);
        for (Ray& ray : rays) ray = {origin, uniform_direction(random.uniform_2d())};
        std::vector<Hit> hits(count);
        scene.intersect(rays, hits);
        for (std::size_t i = 0; i < count; ++i) {
            float nearest = 1e9F;
            for (int axis = 0; axis < 3; ++axis) {
                const float d = rays[i].direction[axis];
                nearest = std::min(nearest, ((d > 0 ? size[axis] : 0) - origin[axis]) / d);
            }
            REQUIRE(hits[i].any());
            // Rounding of single precision over a few metres.
            CHECK(hits[i].distance_m == Approx(nearest).epsilon(1e-5));
            const Vec3 point = scene.point(hits[i], rays[i].direction);
            const Vec3 normal = scene.facing_normal(hits[i], rays[i].direction);
            CHECK(glm::dot(normal, rays[i].direction) < 0);
            CHECK(glm::distance(point - tolerances::kOffset_m * normal,
                                origin + nearest * rays[i].direction) < 1e-5F);
        }
    }
}

TEST_CASE("a ray ends at its maximum distance") {
    const RayScene scene(test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1, Vec3(1), Vec3(2)));
    const Ray rays[] = {{Vec3(1, 1, 1), Vec3(1, 0, 0), 3.9F}, {Vec3(1, 1, 1), Vec3(1, 0, 0), 4.1F}};
    Hit hits[2];
    scene.intersect(rays, hits);
    CHECK_FALSE(hits[0].any());
    CHECK(hits[1].any());
}

TEST_CASE("single rays have the hits of rays in packets") {
    const RayScene scene(test::grey_room(test::icosphere(2, 4), 0.1F, 1, Vec3(0), Vec3(0)));
    RandomStream random(1);
    std::vector<Ray> rays(1000);
    for (Ray& ray : rays) {
        // Some end before the wall.
        ray = {Vec3(0), uniform_direction(random.uniform_2d()), 1 + 2 * random.uniform()};
    }
    std::vector<Hit> packets(rays.size());
    std::vector<Hit> singles(rays.size());
    scene.intersect(rays, packets);
    scene.intersect_each(rays, singles);
    std::size_t same = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        REQUIRE(packets[i].any() == singles[i].any());
        if (!packets[i].any()) continue;
        same += packets[i].triangle == singles[i].triangle;
        // Rounding of single precision over two metres.
        CHECK(packets[i].distance_m == Approx(singles[i].distance_m).epsilon(1e-6));
    }
    // A ray through an edge may hit either neighbour.
    CHECK(same > 400);
}

TEST_CASE("the brute-force intersector has the hits of the hierarchy") {
    // A soup of triangles that cross each other, degenerate ones among them.
    Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1, Vec3(1), Vec3(2));
    RandomStream random(2);
    const auto somewhere = [&] {
        return Vec3(5 * random.uniform(), 4 * random.uniform(), 3 * random.uniform());
    };
    Object soup;
    while (soup.triangles.size() + 12 < BruteForceIntersector::kMax) {
        const auto first = static_cast<std::uint32_t>(soup.vertices.size());
        const bool degenerate = soup.triangles.size() % 5 == 0;
        soup.vertices.insert(soup.vertices.end(), {somewhere(), somewhere(), somewhere()});
        if (degenerate) soup.vertices[first + 2] = soup.vertices[first];
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    soup.triangle_materials.assign(soup.triangles.size(), 0);
    scene.objects.push_back(soup);
    const RayScene few(scene);
    std::vector<Ray> rays(20000);
    for (Ray& ray : rays) {
        ray = {somewhere(), uniform_direction(random.uniform_2d()), 4 * random.uniform()};
    }
    std::vector<Hit> tried(rays.size());
    std::vector<Hit> found(rays.size());
    few.intersect(rays, tried);
    few.intersect_each(rays, found);
    std::size_t others = 0;
    std::size_t hits = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        hits += found[i].any() ? 1 : 0;
        if (tried[i].triangle != found[i].triangle) {
            ++others;
            continue;
        }
        if (!tried[i].any()) continue;
        // Both round single precision over a few metres, more so at grazing incidence.
        CHECK(tried[i].distance_m == Approx(found[i].distance_m).margin(1e-4));
        CHECK(tried[i].u == Approx(found[i].u).margin(1e-4));
        CHECK(tried[i].v == Approx(found[i].v).margin(1e-4));
    }
    CHECK(hits > rays.size() / 2);
    // Rays through an edge of the soup, or that end at a wall: an edge of 5 m with rounding of 1e-6
    // m on either side is hit by one ray in 1e5.
    CHECK(others <= 5);
}

TEST_CASE("no ray leaks through the edges of a room of few triangles") {
    const Scene icosahedron = test::grey_room(test::icosphere(2, 0), 0.1F, 1, Vec3(0), Vec3(0));
    const RayScene scene(icosahedron);
    REQUIRE(scene.triangle_count() <= BruteForceIntersector::kMax);
    RandomStream random(6);
    std::vector<Ray> rays;
    for (int i = 0; i < 20000; ++i) {
        const auto& v = scene.triangle(static_cast<std::uint32_t>(i) % 20).vertices;
        const Vec3 from = 1.4F * random.uniform() * uniform_direction(random.uniform_2d());
        const float along = random.uniform();
        rays.push_back({from, glm::normalize(v[0] + along * (v[1] - v[0]) - from)});
    }
    CHECK(leaks(scene, rays) == 0);
}

TEST_CASE("a ray exactly through an edge between two triangles hits one, from either side") {
    // All coordinates are exact.
    const RayScene square(test::grey_room(test::square(1), 0.1F, 1, Vec3(0), Vec3(0)));
    std::vector<Ray> rays;
    for (const float z : {1.0F, -1.0F}) {
        for (int i = -7; i <= 7; ++i) {
            const float at = static_cast<float>(i) / 8;
            rays.push_back({Vec3(at, at, z), Vec3(0, 0, -z)});
            rays.push_back({Vec3(at, -at, z), Vec3(0, 0, -z)});
        }
    }
    std::vector<Hit> hits(rays.size());
    square.intersect(rays, hits);
    for (const Hit& hit : hits) CHECK(hit.distance_m == 1);
}

TEST_CASE("walls block visibility") {
    const RayScene scene(test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1, Vec3(1), Vec3(2)));
    CHECK(scene.visible(Vec3(1, 1, 1), Vec3(4, 3, 2)));
    CHECK_FALSE(scene.visible(Vec3(1, 1, 1), Vec3(6, 1, 1)));
    // Points on a wall are visible from inside.
    CHECK(scene.visible(Vec3(0, 1, 1), Vec3(4, 3, 2)));
    CHECK(scene.visible(Vec3(1, 1, 1), Vec3(1, 1, 1)));
}

TEST_CASE("no ray leaks through the edges of a finely divided sphere") {
    const RayScene scene(test::grey_room(test::icosphere(2, 4), 0.1F, 1, Vec3(0), Vec3(0)));
    RandomStream random(5);
    std::vector<Ray> rays(200000);
    for (Ray& ray : rays) ray = {Vec3(0.1F, 0.2F, 0), uniform_direction(random.uniform_2d())};
    // Aimed at vertices and edges, too.
    for (std::size_t t = 0; t < scene.triangle_count(); ++t) {
        const auto& v = scene.triangle(static_cast<std::uint32_t>(t)).vertices;
        rays.push_back({Vec3(0), glm::normalize(v[0])});
        rays.push_back({Vec3(0), glm::normalize(v[0] + v[1])});
    }
    CHECK(leaks(scene, rays) == 0);
}

TEST_CASE("a moving object is hit at its present position") {
    Scene scene = test::grey_room(test::box(Vec3(10, 4, 3)), 0.1F, 1, Vec3(1), Vec3(2));
    Object door = test::box(Vec3(0.1F, 4, 3));
    door.path = Trajectory{{{0, {Vec3(2, 0, 0)}}, {1, {Vec3(5, 0, 0)}}}, false};
    scene.objects.push_back(door);
    RayScene rays(scene);
    const auto distance = [&] {
        const Ray ray{Vec3(1, 1, 1), Vec3(1, 0, 0)};
        Hit hit;
        rays.intersect({&ray, 1}, {&hit, 1});
        CHECK(rays.triangle(hit.triangle).object == 1);
        return hit.distance_m;
    };
    CHECK(distance() == Approx(1));
    CHECK(rays.move(0) == 0);
    CHECK(rays.move(0.5) == Approx(1.5));
    CHECK(distance() == Approx(2.5));
    CHECK(rays.move(2) == Approx(1.5));
    CHECK(distance() == Approx(4));
}

TEST_CASE("of any number of triangles with the same corners the first is hit") {
    Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1, Vec3(1), Vec3(2));
    Object other = scene.objects[0];
    // The same triangles with other first corners, one of them seen from the other side.
    for (auto& triangle : other.triangles) {
        std::rotate(triangle.begin(), triangle.begin() + 1, triangle.end());
    }
    std::swap(other.triangles[0][0], other.triangles[0][1]);
    for (int i = 0; i < 200; ++i) scene.objects.insert(scene.objects.begin(), other);
    const RayScene many(scene);
    RandomStream random(1);
    std::vector<Ray> rays(1000);
    for (Ray& ray : rays) ray = {Vec3(1, 2, 1.5F), uniform_direction(random.uniform_2d())};
    std::vector<Hit> hits(rays.size());
    many.intersect(rays, hits);
    CHECK(std::all_of(hits.begin(), hits.end(), [](const Hit& h) { return h.triangle < 12; }));
    CHECK(leaks(many, rays) == 0);
    CHECK_FALSE(many.visible(Vec3(1, 2, 1), Vec3(6, 2, 1)));
    // Companion: triangles that share two of three corners are all hit.
    scene.objects.assign(1, other);
    scene.objects[0].triangles.insert(scene.objects[0].triangles.end(), 60, {0, 1, 6});
    scene.objects[0].triangle_materials.resize(72, 0);
    const RayScene with_diagonal(scene);
    std::size_t on_diagonal = 0;
    with_diagonal.intersect(rays, hits);
    for (const Hit& hit : hits) on_diagonal += hit.triangle == 12 ? 1 : 0;
    CHECK(on_diagonal > 10);
}

TEST_CASE("a moving triangle that coincides with another separates from it when it moves") {
    Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1, Vec3(1), Vec3(2));
    for (int i = 0; i < 5; ++i)
        scene.objects.push_back(scene.objects[0]);  // beyond BruteForceIntersector
    scene.objects[3].path = Trajectory{{{0, {Vec3(0)}}, {1, {Vec3(1, 0, 0)}}}, false};
    RayScene moving(scene);
    moving.move(1);
    const Ray ray{Vec3(0.5F, 2, 1.5F), Vec3(1, 0, 0)};
    Hit hit;
    moving.intersect({&ray, 1}, {&hit, 1});
    CHECK(hit.distance_m == Approx(0.5F));
    CHECK(moving.triangle(hit.triangle).object == 3);
}

TEST_CASE("the movement of the scene is that of the object that moved farthest") {
    Scene scene = test::grey_room(test::box(Vec3(10, 4, 3)), 0.1F, 1, Vec3(1), Vec3(2));
    for (const float distance_m : {0.2F, 2.0F, 0.1F}) {
        Object object = test::box(Vec3(0.1F));
        object.path = Trajectory{{{0, {Vec3(2)}}, {1, {Vec3(2) + Vec3(distance_m, 0, 0)}}}, false};
        scene.objects.push_back(object);
    }
    RayScene rays(scene);
    CHECK(rays.move(1) == Approx(2));
}

TEST_CASE("A given transform of an object that does not move is ignored") {
    const Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1, Vec3(1), Vec3(2));
    RayScene rays(scene);
    RigidTransform shifted;
    shifted.translation = Vec3(1, 0, 0);
    CHECK(rays.move(std::vector<RigidTransform>(scene.objects.size(), shifted)) == 0);
    const Ray ray{Vec3(1, 1, 1), Vec3(1, 0, 0)};
    Hit hit;
    rays.intersect({&ray, 1}, {&hit, 1});
    CHECK(hit.distance_m == Approx(4));
}
