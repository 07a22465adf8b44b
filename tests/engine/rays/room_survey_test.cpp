#include "engine/rays/room_survey.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

#include "tests/support/rooms.h"

namespace {

using namespace aula;

/// Objects of one material, a source and a listener.
Scene scene_of(std::vector<Object> objects) {
    Scene scene = test::grey_room(test::box(Vec3(1)), 0.1F, 1, Vec3(0), Vec3(0));
    scene.objects = std::move(objects);
    return scene;
}

Object quad(const std::array<Vec3, 4>& corners) {
    Object object;
    object.vertices.assign(corners.begin(), corners.end());
    object.triangles = {{0, 1, 2}, {0, 2, 3}};
    object.triangle_materials.assign(2, 0);
    return object;
}

std::size_t escaped(const Scene& scene, const Vec3& from, int paths) {
    std::size_t count = 0;
    trace_random_walks(RayScene(scene), {&from, 1}, {.paths = paths, .bounces = 32, .seed = 3},
                       [&](float, const Ray&, const Hit& hit) { count += hit.any() ? 0 : 1; });
    return count;
}

bool joined(const Scene& scene, const Vec3& listener, const Vec3& source) {
    return connected(RayScene(scene), {&listener, 1}, {&source, 1}, 1)[0] != 0;
}

/// A box from the origin with walls of `parts` x `parts` rectangles, except those for which
/// `missing` is true.
Object walls(const Vec3& size, const std::function<bool(int wall, int part)>& missing,
             int parts = 10) {
    Object object;
    for (int wall = 0; wall < 6; ++wall) {
        const int axis = wall / 2;
        const auto corner = [&](int u, int v) {
            Vec3 p(0);
            p[axis] = wall % 2 == 0 ? 0 : size[axis];
            p[(axis + 1) % 3] =
                size[(axis + 1) % 3] * static_cast<float>(u) / static_cast<float>(parts);
            p[(axis + 2) % 3] =
                size[(axis + 2) % 3] * static_cast<float>(v) / static_cast<float>(parts);
            object.vertices.push_back(p);
        };
        for (int part = 0; part < parts * parts; ++part) {
            if (missing(wall, part)) continue;
            const auto first = static_cast<std::uint32_t>(object.vertices.size());
            const int u = part / parts;
            const int v = part % parts;
            corner(u, v);
            corner(u + 1, v);
            corner(u + 1, v + 1);
            corner(u, v + 1);
            // Every other one faces outwards.
            object.triangles.push_back({first, first + 1, first + 2});
            object.triangles.push_back({first, first + 3, first + 2});
        }
    }
    object.triangle_materials.assign(object.triangles.size(), 0);
    return object;
}

RoomGeometry measured(const Scene& scene, const Vec3& inside) {
    return measure_room(RayScene(scene), {&inside, 1}, 1);
}

}  // namespace

TEST_CASE("a random walk leaves no room where its surfaces cross at acute angles") {
    // A tent of 10 degrees: the roof intersects the floor, whose other side is outdoors.
    std::vector<Object> tent{
        quad({Vec3(-1, 0, 0), Vec3(12, 0, 0), Vec3(12, 5, 0), Vec3(-1, 5, 0)}),
        quad({Vec3(-1, 0, -0.17F), Vec3(12, 0, 2.1F), Vec3(12, 5, 2.1F), Vec3(-1, 5, -0.17F)}),
        quad({Vec3(10, 0, -1), Vec3(10, 5, -1), Vec3(10, 5, 3), Vec3(10, 0, 3)}),
        quad({Vec3(-1, 0, -1), Vec3(12, 0, -1), Vec3(12, 0, 3), Vec3(-1, 0, 3)}),
        quad({Vec3(-1, 5, -1), Vec3(12, 5, -1), Vec3(12, 5, 3), Vec3(-1, 5, 3)})};
    CHECK(escaped(scene_of(tent), {8, 2, 0.5F}, 20000) == 0);
    // Companion: a slit of 1 cm is found.
    for (Vec3& vertex : tent[2].vertices) vertex.z = std::max(vertex.z, 0.01F);
    CHECK(escaped(scene_of(tent), {8, 2, 0.5F}, 20000) > 0);
}

TEST_CASE("a walk that passes more than three moving objects per segment ends") {
    const auto ends = [](int moving) {
        std::vector<Object> boxes{test::box(Vec3(20))};
        for (int i = 1; i <= moving; ++i) {
            const auto size = static_cast<float>(2 * i);
            boxes.push_back(test::box(Vec3(size), 0, Vec3(10 - size / 2)));
            boxes.back().path =
                Trajectory{{{0, {Vec3(0), 0, 0, 0}}, {1, {Vec3(0, 0, 1), 0, 0, 0}}}, false};
        }
        const Vec3 middle(10);
        int count = 0;
        trace_random_walks(RayScene(scene_of(boxes)), {&middle, 1},
                           {.paths = 64, .bounces = 1, .seed = 3},
                           [&](float, const Ray&, const Hit& hit) { count += hit.any() ? 1 : 0; });
        return count;
    };
    CHECK(ends(3) == 64);
    CHECK(ends(4) == 0);
}

TEST_CASE("a walk that passes a wall starts beyond it and moves away from it") {
    // Two rooms that share a thin wall at x = 4, or are 0.3 m apart; both transmit.
    const Vec3 size(4, 3, 2.5F);
    for (const float apart_m : {0.0F, 0.3F}) {
        std::vector<Object> rooms{test::box(size), test::box(size, 0, Vec3(4 + apart_m, 0, 0))};
        Scene scene = scene_of(rooms);
        for (Material& material : scene.materials) {
            material.sound_reduction_db = Bands::filled(10);
        }
        const RayScene rays(scene);
        const Vec3 inside(1, 1, 1);
        int passed = 0;
        int from_wall_to_itself = 0;
        trace_random_walks(
            rays, {&inside, 1},
            {.paths = 2000,
             .bounces = 8,
             .seed = 3,
             .through_moving = false,
             .through_walls = true},
            [&](int order, const Ray& ray, const Hit& hit) {
                const bool in_wall = ray.origin.x > 4 && ray.origin.x < 4 + apart_m;
                CHECK_FALSE(in_wall);
                if (order == 0) return;
                // Segments that start on the second room's side of the wall.
                const bool starts_at = std::abs(ray.origin.x - 4 - apart_m) < 0.005F;
                if (!starts_at || ray.origin.x < 4 + apart_m) return;
                ++passed;
                const bool ends_at =
                    hit.any() && std::abs(rays.point(hit, ray.direction).x - 4 - apart_m) < 0.005F;
                from_wall_to_itself += ends_at ? 1 : 0;
            });
        CAPTURE(apart_m);
        CHECK(passed > 100);
        // A segment that starts on another wall within 5 mm of this one may end there.
        CHECK(from_wall_to_itself < 0.01 * passed);
    }
}

TEST_CASE("sound reaches a source through an opening, not through a wall") {
    const Vec3 here(2, 1.5F, 1.2F);
    const Vec3 there(7, 2.5F, 1.7F);
    std::vector<Object> rooms{test::box(Vec3(5, 4, 3)), test::box(Vec3(4, 4, 3), 0, Vec3(5, 0, 0))};
    CHECK_FALSE(joined(scene_of(rooms), here, there));
    CHECK(joined(scene_of(rooms), here, Vec3(4, 3, 2)));
    CHECK_FALSE(joined(scene_of(rooms), here, Vec3(20, 2, 1)));
    // Companion: without half of the wall between them, in both rooms.
    const auto open_wall = [](Object& room, std::ptrdiff_t triangles) {
        const auto in_wall = [&](const auto& t) {
            return room.vertices[t[0]].x == 5 && room.vertices[t[1]].x == 5 &&
                   room.vertices[t[2]].x == 5;
        };
        const auto first = std::find_if(room.triangles.begin(), room.triangles.end(), in_wall);
        room.triangles.erase(first, first + triangles);
        room.triangle_materials.resize(room.triangles.size());
    };
    open_wall(rooms[0], 1);
    open_wall(rooms[1], 2);
    CHECK(joined(scene_of(rooms), here, there));
    // A shut door is opaque although it can move.
    rooms.push_back(quad({Vec3(5, 0, 0), Vec3(5, 4, 0), Vec3(5, 4, 3), Vec3(5, 0, 3)}));
    rooms.back().path =
        Trajectory{{{0, {Vec3(0), 0, 0, 0}}, {1, {Vec3(0, 0, 10), 0, 0, 0}}}, false};
    CHECK_FALSE(joined(scene_of(rooms), here, there));
    const Scene scene = scene_of(rooms);
    RayScene rays(scene);
    rays.move(1);
    CHECK(connected(rays, {&here, 1}, {&there, 1}, 1)[0] != 0);
}

TEST_CASE("walls that stand on one face of a floor separate the rooms on it") {
    const Vec3 here(2, 1.5F, 1.2F);
    const Vec3 there(7, 2.5F, 1.7F);
    const auto wall = [](float from_y, float to_y) {
        return quad({Vec3(5, from_y, 0), Vec3(5, to_y, 0), Vec3(5, to_y, 3), Vec3(5, from_y, 3)});
    };
    const Object room = test::box(Vec3(9, 4, 3));
    CHECK_FALSE(joined(scene_of({room, wall(0, 4)}), here, there));
    CHECK(joined(scene_of({room, wall(0, 4)}), here, Vec3(4, 3, 2)));
    // Companion: a gap beside the wall.
    CHECK(joined(scene_of({room, wall(0, 3.9F)}), here, there));
    // A box that stands on the floor encloses a source.
    const Object box = test::box(Vec3(1), 0, Vec3(6.5F, 2, 1e-4F));
    CHECK_FALSE(joined(scene_of({room, box}), here, {7, 2.5F, 0.5F}));
    CHECK(joined(scene_of({room, box}), here, {6, 2.5F, 0.5F}));
}

TEST_CASE("in free field sound reaches every source that is not hidden") {
    CHECK(joined(scene_of({}), Vec3(0), Vec3(100, 0, 0)));
    const Object screen = quad({Vec3(5, -9, -9), Vec3(5, 9, -9), Vec3(5, 9, 9), Vec3(5, -9, 9)});
    CHECK_FALSE(joined(scene_of({screen}), Vec3(0), Vec3(10, 0, 0)));
}

TEST_CASE("volume and surface of a room are found for any representation of its faces") {
    constexpr double kVolume_m3 = 40 * 20 * 12;
    constexpr double kSurface_m2 = 2 * (40 * 20 + 40 * 12 + 20 * 12);
    const Vec3 size(40, 20, 12);
    const Vec3 inside(20, 10, 1.5F);
    // Statistical: lengths vary by 0.6 of their mean, 65536 of them give it to 0.25 %; four of
    // these.
    constexpr double kError = 0.01;
    SECTION("faces that point either way") {
        const RoomGeometry room =
            measured(scene_of({walls(size, [](int, int) { return false; })}), inside);
        CHECK(*room.volume_m3 == Approx(kVolume_m3).epsilon(kError));
        CHECK(room.surface_m2 == Approx(kSurface_m2).epsilon(1e-5));
        CHECK(room.open_share == 0);
    }
    SECTION("each face twice") {
        const Object once = walls(size, [](int, int) { return false; });
        const RoomGeometry room = measured(scene_of({once, once}), inside);
        CHECK(*room.volume_m3 == Approx(kVolume_m3).epsilon(kError));
        CHECK(room.surface_m2 == Approx(kSurface_m2).epsilon(kError));
    }
    SECTION("in millimetres") {
        const RoomGeometry room = measured(
            scene_of({walls(size * 1000.0F, [](int, int) { return false; })}), inside * 1000.0F);
        CHECK(*room.volume_m3 == Approx(kVolume_m3 * 1e9).epsilon(kError));
    }
    SECTION("a closed block inside, whichever way it faces") {
        const Object block = test::box(Vec3(6, 5, 4), 0, Vec3(5, 5, 1));
        const RoomGeometry room =
            measured(scene_of({walls(size, [](int, int) { return false; }), block}), inside);
        CHECK(*room.volume_m3 == Approx(kVolume_m3 - 120).epsilon(kError));
        CHECK(room.surface_m2 == Approx(kSurface_m2 + 148).epsilon(kError));
    }
    SECTION("one face of twenty missing") {
        const RoomGeometry room =
            measured(scene_of({walls(size, [](int, int part) { return part % 20 == 7; })}), inside);
        // Escaping rays have other lengths: within the open share.
        CHECK(*room.volume_m3 == Approx(kVolume_m3).epsilon(0.05));
        CHECK(room.open_share == Approx(0.05).margin(0.01));
    }
    SECTION("without a ceiling there is no result") {
        const RoomGeometry room =
            measured(scene_of({walls(size, [](int wall, int) { return wall == 5; })}), inside);
        CHECK_FALSE(room.volume_m3);
    }
}

TEST_CASE("volume and surface of a room do not depend on the size of its triangles") {
    // Up to 400,000 triangles, of which random walks reach a part only. Every sample of the surface
    // counts; the mean free path is known to 0.25 %.
    for (const int parts : {1, 32, 180}) {
        const RoomGeometry room =
            measured(scene_of({walls(
                         Vec3(6, 5, 3), [](int, int) { return false; }, parts)}),
                     {2, 2, 1.5F});
        CAPTURE(parts);
        CHECK(room.surface_m2 == Approx(126).epsilon(0.001));
        CHECK(*room.volume_m3 == Approx(90).epsilon(0.01));
    }
}

TEST_CASE("the gap in a double wall does not belong to a room") {
    // Floor and ceiling extend to the outer walls, 0.2 m behind the inner ones.
    const Vec3 size(6, 5, 3);
    const Object outer = test::box(size);
    std::vector<Object> faces{outer};
    for (const float x : {0.2F, 5.8F}) {
        faces.push_back(quad({Vec3(x, 0, 0), Vec3(x, 5, 0), Vec3(x, 5, 3), Vec3(x, 0, 3)}));
    }
    const RoomGeometry room = measured(scene_of(faces), {2, 2, 1.5F});
    // Of 16384 samples 79 % lie in the room, a share known to 0.4 %. The mean free path adds 0.25
    // %.
    CHECK(room.surface_m2 == Approx(2 * (5.6 * 5 + 5.6 * 3 + 5 * 3)).epsilon(0.02));
    CHECK(*room.volume_m3 == Approx(5.6 * 5 * 3).epsilon(0.03));
}

TEST_CASE("a narrow corridor with open ends has the right volume and mean free path") {
    // 30 x 1.5 x 2.9 m.
    const RoomGeometry room =
        measured(scene_of({walls(Vec3(30, 1.5F, 2.9F), [](int wall, int) { return wall < 2; })}),
                 {15, 0.7F, 1.5F});
    CHECK(*room.volume_m3 == Approx(130.5).epsilon(0.04));
    CHECK(room.field.mean_free_path_m ==
          Approx(4 * 130.5 / (2 * 30 * 4.4 + 2 * 4.35)).epsilon(0.04));
}

TEST_CASE("Sabine's and Eyring's times follow from the mean free path") {
    Scene scene = scene_of({test::box(Vec3(10, 8, 4))});
    scene.medium.air_absorption = false;
    const RoomSurvey field = measured(scene, {3, 3, 1.5F}).field;
    const double c = double{scene.medium.speed_of_sound_m_s()};
    // V = 320, S = 304, a = 0.1 in every band; the mean free path within 1 %.
    const Bands sabine_s = sabine_time_s(field, scene.medium);
    const Bands eyring_s = reverberation_time_s(field, scene.medium);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        CAPTURE(b);
        CHECK(double{sabine_s[b]} == Approx(24 * std::log(10.0) * 320 / (c * 30.4)).epsilon(0.01));
        CHECK(double{eyring_s[b]} ==
              Approx(24 * std::log(10.0) * 320 / (c * 304 * -std::log(0.9))).epsilon(0.01));
    }
}

TEST_CASE("a position in the notch of an L-shaped room is outside") {
    const Scene scene = scene_of({test::l_shaped_room()});
    const std::array<Vec3, 4> positions{Vec3(1, 1, 1.5F), Vec3(5, 5, 1.5F), Vec3(5, 1, 1.5F),
                                        Vec3(3.2F, 3.2F, 1.5F)};
    CHECK(outside_room(RayScene(scene), positions, 1) == std::vector<char>{0, 1, 0, 1});
    // Companion: if all positions are outside, the room is unknown.
    CHECK(outside_room(RayScene(scene), std::span(positions).subspan(3), 1) ==
          std::vector<char>{0});
}

TEST_CASE("escaping energy counts as absorbed, and a position near a hole is still inside") {
    // A box without its ceiling.
    Object walls = test::box(Vec3(5, 4, 3));
    std::erase_if(walls.triangles, [&](const auto& triangle) {
        return std::all_of(triangle.begin(), triangle.end(),
                           [&](std::uint32_t v) { return walls.vertices[v].z > 2.9F; });
    });
    walls.triangle_materials.assign(walls.triangles.size(), 0);
    const Vec3 middle(2.5F, 2, 1);
    const Vec3 high(2.5F, 2, 2.8F);
    const RayScene rays(test::grey_room(walls, 0.1F, 1, middle, high));
    const double escaped = escape_per_reflection(rays, {&middle, 1}, 1);
    CHECK(escaped > 0.1);
    // Both trace 10,000 segments: 2 % of the share, four standard errors.
    CHECK(double{survey_room(rays, {&middle, 1}, 2).mean_absorption[0]} ==
          Approx(escaped + 0.1 * (1 - escaped)).epsilon(0.05));
    const std::array<Vec3, 3> positions{middle, high, Vec3(2.5F, 2, 8)};
    CHECK(outside_room(rays, positions, 1) == std::vector<char>{0, 0, 1});
}

TEST_CASE("Reverberation times contain the absorption of air in every band") {
    RoomSurvey field;
    field.mean_free_path_m = 20;
    field.mean_absorption = Bands::filled(0.02F);
    Medium medium;
    const double c = double{medium.speed_of_sound_m_s()};
    const Bands air = medium.attenuation_per_m();
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double sabine = double{air[b]} + 0.02 / 20;
        const double eyring = double{air[b]} - std::log(0.98) / 20;
        CAPTURE(b);
        CHECK(double{sabine_time_s(field, medium)[b]} ==
              Approx(6 * std::log(10.0) / (c * sabine)).epsilon(1e-6));
        CHECK(double{reverberation_time_s(field, medium)[b]} ==
              Approx(6 * std::log(10.0) / (c * eyring)).epsilon(1e-6));
    }
    // Companion: at 8 kHz air absorbs more than the walls.
    CHECK(double{air[7]} > 0.02 / 20);
}
