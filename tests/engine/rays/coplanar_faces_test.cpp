#include "engine/rays/coplanar_faces.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "aula/engine/propagation.h"
#include "engine/base/sampling.h"
#include "engine/edges/scene_edges.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/room_survey.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"

using namespace aula;

namespace {

constexpr std::uint32_t kWall = 0;
constexpr std::uint32_t kGlass = 1;
constexpr std::uint32_t kWood = 2;

/// A rectangle of the wall y = 0 of a room of 5 x 4 x 3 m.
struct Rectangle {
    std::uint32_t material = kGlass;
    float x = 1;
    float z = 1;
    float width = 2;
    float height = 1;
    float off_m = 0;  ///< from the wall, into the room
};

/// The room turned about the vertical axis. Its wall y = 0 has 15 m2.
class Room {
 public:
    explicit Room(float turned_rad = 0) : turned_rad_(turned_rad) {
        Object walls = test::box(Vec3(5, 4, 3), kWall);
        // Without the wall y = 0.
        walls.triangles.erase(walls.triangles.begin() + 4, walls.triangles.begin() + 6);
        walls.triangle_materials.assign(walls.triangles.size(), kWall);
        for (Vec3& v : walls.vertices) v = turned(v);
        scene_ =
            test::grey_room(walls, 0.05F, 0.5F, turned(Vec3(1, 1, 1.5F)), turned(Vec3(3, 2, 1.5F)));
        scene_.materials.resize(3, scene_.materials[0]);
        scene_.materials[kGlass].name = "glass";
        scene_.materials[kGlass].absorption = Bands::filled(0.9F);
        scene_.materials[kWood].name = "wood";
        scene_.materials[kWood].absorption = Bands::filled(0.5F);
    }

    Room& add(const Rectangle& r) {
        Object object;
        for (const auto& [x, z] :
             {std::pair(r.x, r.z), std::pair(r.x, r.z + r.height),
              std::pair(r.x + r.width, r.z + r.height), std::pair(r.x + r.width, r.z)})
            object.vertices.push_back(turned(Vec3(x, r.off_m, z)));
        object.triangles = {{0, 1, 2}, {0, 2, 3}};
        object.triangle_materials = {r.material, r.material};
        scene_.objects.push_back(object);
        return *this;
    }

    Room& add_wall() { return add({kWall, 0, 0, 5, 3}); }

    Room& add_wall_with_hole() {
        add({kWall, 0, 0, 1, 3}).add({kWall, 3, 0, 2, 3});
        return add({kWall, 1, 0, 2, 1}).add({kWall, 1, 2, 2, 1});
    }

    Scene& scene() { return scene_; }

    /// Areas that sound reaches, by material.
    std::vector<double> areas_m2() const {
        const RayScene rays(scene_);
        const std::array inside{scene_.sources[0].position, scene_.listener.pose.position};
        return measure_room(rays, inside, 1).area_m2;
    }

    /// The material that a ray meets at a point of the wall, from inside or outside.
    std::uint32_t material_at(const RayScene& rays, float x, float z, float side) const {
        const Vec3 from = turned(Vec3(x + 0.3F, side, z + 0.2F));
        const Vec3 way = turned(Vec3(x, 0, z)) - from;
        const Ray ray{from, glm::normalize(way)};
        Hit hit;
        rays.intersect({&ray, 1}, {&hit, 1});
        REQUIRE(hit.any());
        // A point of the room: no closer to the wall than other hits.
        CHECK(hit.distance_m == Approx(glm::length(way)).margin(2e-3));
        const Vec3 off = rays.point(hit, ray.direction);
        CHECK(rays.visible(off, from, 0));
        return rays.surface(hit.triangle).material;
    }

    Vec3 turned(const Vec3& p) const {
        const float c = std::cos(turned_rad_), s = std::sin(turned_rad_);
        return {c * p.x - s * p.y, s * p.x + c * p.y, p.z};
    }

 private:
    float turned_rad_;
    Scene scene_;
};

}  // namespace

TEST_CASE("of a window drawn on a wall the areas are exact and rays hit the window") {
    for (const float turned_rad : {0.0F, 0.3F, 2.0F}) {
        for (const float off_m : {0.0F, 1e-4F, -1e-4F, 4e-4F, -4e-4F}) {
            for (const bool many : {false, true}) {
                CAPTURE(turned_rad, off_m, many);
                Room room(turned_rad);
                room.add_wall().add({.off_m = off_m});
                // Too many triangles for the search without a hierarchy.
                for (int i = 0; many && i < 30; ++i)
                    room.add({kWood, 0, 0, 1, 1, 20 + static_cast<float>(i)});
                const RayScene rays(room.scene());
                RandomStream random(1);
                int hits = 0;
                for (int i = 0; i < 500; ++i) {
                    const float x = 4.7F * random.uniform();
                    const float z = 2.8F * random.uniform();
                    if (std::min(std::abs(x - 1), std::abs(x - 3)) < 0.01F) continue;
                    if (std::min(std::abs(z - 1), std::abs(z - 2)) < 0.01F) continue;
                    const bool window = x > 1 && x < 3 && z > 1 && z < 2;
                    hits += window ? 1 : 0;
                    for (const float side : {1.0F, -1.0F})
                        CHECK(room.material_at(rays, x, z, side) == (window ? kGlass : kWall));
                }
                CHECK(hits > 40);
                const std::vector<double> areas_m2 = room.areas_m2();
                // Rounding of single precision.
                CHECK(areas_m2[kWall] == Approx(92).epsilon(1e-5));
                CHECK(areas_m2[kGlass] == Approx(2).epsilon(1e-5));
            }
        }
    }
}

TEST_CASE("a room with a window drawn on a wall has the energy of one with a hole for it") {
    const auto energy = [](Room& room) {
        Scene& scene = room.scene();
        scene.simulation.rays = 4000;
        Propagation propagation(scene, scene.simulation);
        for (int f = 0; f < 20; ++f) propagation.step(test::static_input(scene));
        return propagation.response(0).total(4);
    };
    Room drawn, hole, bare;
    drawn.add_wall().add({});
    hole.add_wall_with_hole().add({});
    bare.add_wall();
    const double right = energy(hole);
    // The noise of 80000 rays is below 1 %.
    CHECK(energy(drawn) == Approx(right).epsilon(0.03));
    CHECK(energy(bare) > 1.2 * right);
}

TEST_CASE("overlapping windows, windows over the edge of a wall and double ones") {
    Room nested;
    nested.add_wall().add({}).add({.material = kWood, .x = 2, .width = 1.5F});
    std::vector<double> areas_m2 = nested.areas_m2();
    CHECK(areas_m2[kWall] == Approx(91.5).epsilon(1e-5));
    CHECK(areas_m2[kGlass] == Approx(1).epsilon(1e-5));
    CHECK(areas_m2[kWood] == Approx(1.5).epsilon(1e-5));
    const RayScene rays(nested.scene());
    CHECK(nested.material_at(rays, 2.5F, 1.5F, 1) == kWood);
    CHECK(nested.material_at(rays, 1.5F, 1.4F, 1) == kGlass);

    Room over;
    over.add_wall().add({.x = 4});
    areas_m2 = over.areas_m2();
    CHECK(areas_m2[kWall] == Approx(93).epsilon(1e-5));
    // Four standard deviations: half of 340 samples.
    CHECK(areas_m2[kGlass] == Approx(1).epsilon(0.11));

    for (const std::uint32_t other : {kGlass, kWood}) {
        Room twice;
        twice.add_wall().add({}).add({.material = other});
        areas_m2 = twice.areas_m2();
        CHECK(areas_m2[kWall] == Approx(92).epsilon(1e-5));
        CHECK(areas_m2[kGlass] == Approx(2).epsilon(0.05));
        CHECK((areas_m2.size() <= kWood || areas_m2[kWood] == 0));
    }
}

TEST_CASE("a third face of the first one's material is heard on the second") {
    Room room;
    room.add_wall().add({}).add(
        {.material = kWall, .x = 1.5F, .z = 1.2F, .width = 1, .height = 0.5F});
    const RayScene rays(room.scene());
    CHECK(room.material_at(rays, 2.1F, 1.5F, 1) == kWall);
    CHECK(room.material_at(rays, 1.2F, 1.5F, 1) == kGlass);
    const std::vector<double> areas_m2 = room.areas_m2();
    CHECK(areas_m2[kWall] == Approx(92.5).epsilon(1e-5));
    CHECK(areas_m2[kGlass] == Approx(1.5).epsilon(1e-5));
}

TEST_CASE("a window drawn on an opaque wall transmits, and an opaque door on a thin wall blocks") {
    Room room;
    Scene& scene = room.scene();
    scene.materials[kGlass].sound_reduction_db = Bands::filled(5);
    room.add_wall().add({.off_m = 1e-4F});
    RayScene rays(scene);
    const std::uint32_t window = rays.coplanar_faces().overlaps()[0].heard;
    CHECK_FALSE(rays.is_backed(Vec3(2.1F, 1e-4F, 1.4F), window));
    scene.materials[kWall].sound_reduction_db = Bands::filled(20);
    scene.materials[kGlass].sound_reduction_db.reset();
    const RayScene thin(scene);
    CHECK(room.material_at(thin, 2.1F, 1.4F, -1) == kGlass);
}

TEST_CASE("the border of a window drawn on a wall does not diffract") {
    Room room, drawn;
    room.add_wall();
    drawn.add_wall().add({});
    const RayScene rays(room.scene());
    const RayScene with_window(drawn.scene());
    CHECK(SceneEdges(with_window).count() == SceneEdges(rays).count());
}

TEST_CASE("neighbours, layers of equal size and faces of one kind do not overlap") {
    Room hole, layers, kind;
    hole.add_wall_with_hole().add({});
    // The corners of files are rounded to millimetres.
    hole.add({.material = kWood, .x = 2.999F, .width = 1, .height = 1.001F});
    const RayScene rays(hole.scene());
    CHECK_FALSE(rays.coplanar_faces().overlaps().empty());  // on the wall beside
    for (const CoplanarFaces::Overlap& overlap : rays.coplanar_faces().overlaps())
        CHECK(rays.surface(overlap.covered).material != kGlass);
    layers.add_wall().add({kGlass, 0, 0, 5, 3});
    CHECK(RayScene(layers.scene()).coplanar_faces().overlaps().empty());
    Object& box = kind.scene().objects[0];
    for (const Vec3& v : {Vec3(1, 1, 0), Vec3(2, 1, 0), Vec3(1, 2, 0)}) box.vertices.push_back(v);
    const auto first = static_cast<std::uint32_t>(box.vertices.size() - 3);
    box.triangles.push_back({first, first + 1, first + 2});
    box.triangle_materials.push_back(kWall);
    CHECK(RayScene(kind.scene()).coplanar_faces().overlaps().empty());
}

TEST_CASE("of layers of equal size in front of a wall those on the open side are heard") {
    for (const float turned_rad : {0.0F, 0.3F}) {
        for (const float glass_m : {0.0F, 4e-4F, -4e-4F}) {
            for (const bool glass_first : {true, false}) {
                CAPTURE(turned_rad, glass_m, glass_first);
                Room room(turned_rad);
                const Rectangle glass{.off_m = glass_m};
                const Rectangle curtain{.material = kWood, .off_m = 8e-4F};
                room.add_wall().add(glass_first ? glass : curtain);
                room.add(glass_first ? curtain : glass);
                const RayScene rays(room.scene());
                const std::uint32_t behind = glass_m > 0 ? kWall : kGlass;
                RandomStream random(1);
                for (int i = 0; i < 100; ++i) {
                    const float x = 1.01F + 1.98F * random.uniform();
                    const float z = 1.01F + 0.98F * random.uniform();
                    CHECK(room.material_at(rays, x, z, 1) == kWood);
                    CHECK(room.material_at(rays, x, z, -1) == behind);
                }
                const std::vector<double> areas_m2 = room.areas_m2();
                // Some samples at the rims are reached, where layers are open.
                CHECK(areas_m2[kWall] == Approx(92).margin(0.2));
                CHECK(areas_m2[kGlass] < 0.1);
                CHECK(areas_m2[kWood] == Approx(2).margin(0.1));
            }
        }
    }
}

TEST_CASE("a picture on a layer of a wall is heard") {
    Room room;
    room.add_wall().add({kWood, 0, 0, 5, 3, 8e-4F}).add({.off_m = 8e-4F});
    const RayScene rays(room.scene());
    CHECK(room.material_at(rays, 2.1F, 1.4F, 1) == kGlass);
    CHECK(room.material_at(rays, 3.5F, 1.4F, 1) == kWood);
    CHECK(room.material_at(rays, 2.1F, 1.4F, -1) == kWall);
}

TEST_CASE("a carpet of many faces is heard on a floor of two") {
    Room room;
    Object carpet;
    constexpr std::uint32_t kSide = 75;
    for (std::uint32_t j = 0; j <= kSide; ++j)
        for (std::uint32_t i = 0; i <= kSide; ++i)
            carpet.vertices.emplace_back(1 + 3 * static_cast<float>(i) / kSide,
                                         1 + 2 * static_cast<float>(j) / kSide, 0);
    for (std::uint32_t j = 0; j < kSide; ++j) {
        for (std::uint32_t i = 0; i < kSide; ++i) {
            const std::uint32_t at = j * (kSide + 1) + i;
            carpet.triangles.push_back({at, at + 1, at + kSide + 2});
            carpet.triangles.push_back({at, at + kSide + 2, at + kSide + 1});
        }
    }
    carpet.triangle_materials.assign(carpet.triangles.size(), kGlass);
    room.add_wall().scene().objects.push_back(carpet);
    CHECK_FALSE(RayScene(room.scene()).coplanar_faces().not_searched());
    const std::vector<double> areas_m2 = room.areas_m2();
    CHECK(areas_m2[kWall] == Approx(88).epsilon(1e-4));
    CHECK(areas_m2[kGlass] == Approx(6).epsilon(1e-4));
}

TEST_CASE("a heap of overlapping faces is given up in bounded time") {
    Room heap;
    Object object;
    for (std::uint32_t i = 0; i < 20000; ++i) {
        const float size = 1 + 1e-5F * static_cast<float>(i);
        for (const Vec3& v : {Vec3(0), Vec3(size, 0, 0), Vec3(0, size, 0)})
            object.vertices.push_back(v);
        object.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        object.triangle_materials.push_back(i % 2 == 0 ? kGlass : kWood);
    }
    heap.scene().objects.push_back(object);
    const RayScene rays(heap.scene());
    CHECK(rays.coplanar_faces().overlaps().empty());
    CHECK(rays.surface(rays.coplanar_faces().not_searched().value()).material == kWall);
}
