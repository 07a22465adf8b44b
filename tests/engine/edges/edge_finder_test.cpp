#include "engine/edges/edge_finder.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>
#include <numeric>
#include <vector>

#include "engine/base/sampling.h"
#include "tests/support/rooms.h"

using aula::DiffractionEdge;
using aula::Object;
using aula::RayScene;
using aula::Scene;
using aula::Vec3;

namespace {

constexpr double kDegree = std::numbers::pi / 180;

std::vector<DiffractionEdge> edges_of(const Object& object) {
    Scene scene;
    scene.materials.resize(1);
    scene.objects = {object};
    const RayScene rays(scene);
    std::vector<std::uint32_t> triangles(rays.triangle_count());
    std::iota(triangles.begin(), triangles.end(), 0U);
    return aula::find_edges(rays, triangles);
}

void add_triangle(Object& object, const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto first = static_cast<std::uint32_t>(object.vertices.size());
    object.vertices.insert(object.vertices.end(), {a, b, c});
    object.triangles.push_back({first, first + 1, first + 2});
    object.triangle_materials.push_back(0);
}

void add_quad(Object& object, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    add_triangle(object, a, b, c);
    add_triangle(object, a, c, d);
}

void add(Object& object, const Object& other) {
    for (const auto& t : other.triangles)
        add_triangle(object, other.vertices[t[0]], other.vertices[t[1]], other.vertices[t[2]]);
}

/// A wall in the plane x = 0, 4 m wide and 3 m high, with a door of 0.9 x 2 m from the floor.
Object wall_with_door() {
    Object wall;
    add_quad(wall, {0, 0, 0}, {0, 1, 0}, {0, 1, 3}, {0, 0, 3});
    add_quad(wall, {0, 1.9F, 0}, {0, 4, 0}, {0, 4, 3}, {0, 1.9F, 3});
    add_quad(wall, {0, 1, 2}, {0, 1.9F, 2}, {0, 1.9F, 3}, {0, 1, 3});
    return wall;
}

/// The mantle of a column with `sides` sides about the z axis.
Object column(int sides, float radius_m, float height_m) {
    Object object;
    const auto at = [&](int i, float z) {
        const float turn = 2 * std::numbers::pi_v<float> * static_cast<float>(i % sides) /
                           static_cast<float>(sides);
        return Vec3(radius_m * std::cos(turn), radius_m * std::sin(turn), z);
    };
    for (int i = 0; i < sides; ++i)
        add_quad(object, at(i, 0), at(i + 1, 0), at(i + 1, height_m), at(i, height_m));
    return object;
}

double length_m(const std::vector<DiffractionEdge>& edges) {
    return std::accumulate(
        edges.begin(), edges.end(), 0.0,
        [](double sum, const DiffractionEdge& edge) { return sum + edge.length_m; });
}

std::size_t count_of(const std::vector<DiffractionEdge>& edges, double open_degrees) {
    return static_cast<std::size_t>(
        std::count_if(edges.begin(), edges.end(), [&](const DiffractionEdge& edge) {
            return std::abs(edge.open_angle_rad - open_degrees * kDegree) < 0.1 * kDegree;
        }));
}

/// The ends of an edge and its angle, whatever its direction.
bool is_same(const DiffractionEdge& a, const DiffractionEdge& b, double within_m,
             double within_degrees) {
    const auto end = [](const DiffractionEdge& e) { return e.point(e.length_m); };
    const bool along =
        glm::distance(a.start, b.start) < within_m && glm::distance(end(a), end(b)) < within_m;
    const bool against =
        glm::distance(a.start, end(b)) < within_m && glm::distance(end(a), b.start) < within_m;
    const auto middle = [](const DiffractionEdge& e) { return e.direction(e.open_angle_rad / 2); };
    return (along || against) &&
           std::abs(a.open_angle_rad - b.open_angle_rad) < within_degrees * kDegree &&
           glm::distance(middle(a), middle(b)) < 0.02;
}

bool are_same(const std::vector<DiffractionEdge>& a, const std::vector<DiffractionEdge>& b,
              double within_m = 1e-4, double within_degrees = 0.1) {
    return a.size() == b.size() && std::all_of(a.begin(), a.end(), [&](const auto& edge) {
               return std::any_of(b.begin(), b.end(), [&](const auto& other) {
                   return is_same(edge, other, within_m, within_degrees);
               });
           });
}

/// A concave room with a door in a free wall and a table: edges of several kinds.
Object furnished() {
    Object object = aula::test::l_shaped_room();
    Object door = wall_with_door();
    for (Vec3& v : door.vertices) v += Vec3(1.5F, 0.5F, 0);
    add(object, door);
    add(object, aula::test::box({0.8F, 1.2F, 0.05F}, 0, {4, 1, 0.7F}));
    return object;
}

Object shuffled(const Object& object, std::uint64_t seed) {
    aula::RandomStream random(seed);
    Object out;
    std::vector<std::array<Vec3, 3>> triangles;
    for (const auto& t : object.triangles)
        triangles.push_back({object.vertices[t[0]], object.vertices[t[1]], object.vertices[t[2]]});
    for (std::size_t i = triangles.size(); i > 1; --i)
        std::swap(triangles[i - 1], triangles[random.bits() % i]);
    for (auto& t : triangles) {
        std::rotate(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(random.bits() % 3), t.end());
        if (random.bits() % 2 == 0) std::swap(t[0], t[1]);
        add_triangle(out, t[0], t[1], t[2]);
    }
    return out;
}

/// Each triangle divided at a random point of one side: T-junctions with all neighbours.
Object split(const Object& object, std::uint64_t seed) {
    aula::RandomStream random(seed);
    Object out;
    for (const auto& t : object.triangles) {
        const std::size_t k = random.bits() % 3;
        const Vec3 a = object.vertices[t[k]];
        const Vec3 b = object.vertices[t[(k + 1) % 3]];
        const Vec3 c = object.vertices[t[(k + 2) % 3]];
        const Vec3 cut = a + (0.2F + 0.6F * random.uniform()) * (b - a);
        add_triangle(out, a, cut, c);
        add_triangle(out, cut, b, c);
    }
    return out;
}

}  // namespace

TEST_CASE("a convex room has no edges inside, and the wedges of its outside are its twelve edges") {
    const auto edges = edges_of(aula::test::box({5, 4, 3}));
    CHECK(edges.size() == 12);
    CHECK(count_of(edges, 270) == 12);
    CHECK(length_m(edges) == Approx(4 * 12).margin(1e-4));
}

TEST_CASE("a free wall has four edges of 360 degrees, with a door eight") {
    CHECK(count_of(edges_of(aula::test::square(1)), 360) == 4);
    const auto edges = edges_of(wall_with_door());
    // Left, right, top; the lower edge in two parts; the jambs and the lintel.
    CHECK(edges.size() == 8);
    CHECK(count_of(edges, 360) == 8);
    CHECK(length_m(edges) == Approx(3 + 3 + 4 + 1 + 2.1 + 2 + 2 + 0.9).margin(1e-4));
}

TEST_CASE("the open side of a wedge is outside a box, and its coordinates are right") {
    const auto edges = edges_of(aula::test::box({1, 1, 1}));
    const glm::dvec3 middle(0.5);
    for (const DiffractionEdge& edge : edges) {
        const glm::dvec3 out = edge.point(0.5) - middle;
        CHECK(glm::dot(edge.direction(edge.open_angle_rad / 2), glm::normalize(out)) ==
              Approx(1).margin(1e-5));
        CHECK(edge.coordinates(middle).angle_rad > edge.open_angle_rad);
        const aula::WedgePoint p = edge.coordinates(edge.point(0.3) + 2.0 * edge.direction(1.1));
        CHECK(p.radius_m == Approx(2));
        CHECK(p.angle_rad == Approx(1.1));
        CHECK(p.along_m == Approx(0.3));
    }
}

TEST_CASE("a column of 32 sides has 32 edges of 191.25 degrees and its free ends") {
    const auto edges = edges_of(column(32, 0.3F, 3));
    CHECK(count_of(edges, 180 + 360.0 / 32) == 32);
    // Ends of 5.9 cm are too short.
    CHECK(edges.size() == 32);
    // Bends of 0.9 degrees are flat: only the rims are left.
    for (const DiffractionEdge& edge : edges_of(column(400, 3, 3)))
        CHECK(std::abs(edge.axis.z) < 0.1);
}

TEST_CASE("edges of small bends at narrow faces divide a curved surface") {
    const auto curved = [](const Object& object) {
        const auto edges = edges_of(object);
        return std::count_if(edges.begin(), edges.end(),
                             [](const DiffractionEdge& edge) { return edge.is_curved; });
    };
    CHECK(curved(column(32, 0.3F, 3)) == 32);
    CHECK(curved(column(8, 0.3F, 3)) == 8);
    CHECK(curved(column(7, 0.3F, 3)) == 0);  // bends of 51 degrees
    CHECK(curved(column(32, 20, 3)) == 0);   // faces of 3.9 m
    CHECK(curved(aula::test::box({1, 1, 1})) == 0);
}

TEST_CASE("the same edges are found in any order of the triangles and of their corners") {
    const auto edges = edges_of(furnished());
    REQUIRE(edges.size() > 20);
    for (const std::uint64_t seed : {1U, 2U, 3U})
        CHECK(are_same(edges_of(shuffled(furnished(), seed)), edges));
    // The counter-check: one triangle less is seen.
    Object open = furnished();
    open.triangles.pop_back();
    open.triangle_materials.pop_back();
    CHECK_FALSE(are_same(edges_of(open), edges));
}

TEST_CASE("walls that are modelled twice, from both sides, are one wall") {
    const auto edges = edges_of(furnished());
    Object twice = furnished();
    add(twice, shuffled(furnished(), 5));
    CHECK(are_same(edges_of(twice), edges));
    // Both sides divided differently.
    Object both = furnished();
    add(both, split(furnished(), 6));
    CHECK(are_same(edges_of(both), edges));
    // Half a millimetre apart; two centimetres apart the wall has two faces.
    const auto doubled = [](float thickness_m) {
        Object wall = wall_with_door();
        Object back = wall_with_door();
        for (Vec3& v : back.vertices) v.x += thickness_m;
        add(wall, back);
        return edges_of(wall);
    };
    CHECK(are_same(doubled(5e-4F), edges_of(wall_with_door()), 1e-3));
    CHECK(doubled(0.02F).size() == 16);
}

TEST_CASE("triangles that are divided at T-junctions have the same edges") {
    const auto edges = edges_of(furnished());
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        const Object once = split(furnished(), seed);
        CHECK(are_same(edges_of(once), edges));
        CHECK(are_same(edges_of(split(once, seed + 10)), edges));
    }
}

TEST_CASE("cracks below half a millimetre are closed, of a centimetre they are not") {
    const auto edges = edges_of(furnished());
    const auto cracked = [](float crack_m) {
        aula::RandomStream random(4);
        Object soup = split(furnished(), 1);
        for (Vec3& v : soup.vertices) {
            const Vec3 direction = aula::uniform_direction(random.uniform_2d());
            v += crack_m * random.uniform() * direction;
        }
        return edges_of(soup);
    };
    // 0.6 mm across the faces of 5 cm of the table are 0.7 degrees.
    CHECK(are_same(cracked(3e-4F), edges, 2e-3, 1));
    CHECK_FALSE(are_same(cracked(0.02F), edges, 0.04, 1));
}

TEST_CASE("a side close to three lines that are apart joins all of them") {
    // Four walls about an axis, three of them 0.8 mm off it and 1.4 mm from each other. Together
    // they leave no sector above 180 degrees; without any of the three, one would be above.
    constexpr double kOff_m = 8e-4;
    aula::RandomStream random(11);
    for (int trial = 0; trial < 40; ++trial) {
        const Vec3 x = aula::uniform_direction(random.uniform_2d());
        const Vec3 y = glm::normalize(glm::cross(x, aula::uniform_direction(random.uniform_2d())));
        const glm::dmat3 turn(x, y, glm::cross(x, y));
        const glm::dvec3 shift = 0.3F * aula::uniform_direction(random.uniform_2d());
        Object walls;
        const auto add_wall = [&](double degrees, double off_m, double half_m) {
            const glm::dvec3 out(std::cos(degrees * kDegree), std::sin(degrees * kDegree), 0);
            const auto corner = [&](double from_axis_m, double z) {
                return Vec3(shift + turn * (from_axis_m * out + glm::dvec3(0, 0, z)));
            };
            add_quad(walls, corner(off_m, -half_m), corner(1, -half_m), corner(1, half_m),
                     corner(off_m, half_m));
        };
        for (int i = 0; i < 3; ++i) add_wall(120.0 * i, kOff_m, 1.5 + 0.02 * ((i + trial) % 3));
        add_wall(60, 0, 0.5);
        CAPTURE(trial);
        CHECK(edges_of(walls).size() == 4 * 3);
    }
}

TEST_CASE("a wall that stands on a floor, or a step in it, leaves only its free edges") {
    // The floor is divided along the foot of the wall, but not at its ends.
    Object object;
    add_quad(object, {-5, -5, 0}, {0, -5, 0}, {0, 5, 0}, {-5, 5, 0});
    add_quad(object, {0, -5, 0}, {5, -5, 0}, {5, 5, 0}, {0, 5, 0});
    add_quad(object, {0, -1, 0}, {0, 1, 0}, {0, 1, 2}, {0, -1, 2});
    const auto edges = edges_of(object);
    CHECK(edges.size() == 4 + 3);
    CHECK(length_m(edges) == Approx(40 + 2 + 2 + 2).margin(1e-4));
}

TEST_CASE("a thin box has the edges of its faces down to its thickness") {
    const auto door = edges_of(aula::test::box({0.9F, 0.04F, 2}));
    CHECK(door.size() == 8);  // the edges of 4 cm are too short
    CHECK(count_of(door, 270) == 8);
    const auto sheet = edges_of(aula::test::box({0.9F, 5e-4F, 2}));
    CHECK(sheet.size() == 4);
    CHECK(count_of(sheet, 360) == 4);
}

TEST_CASE("an object below 0.3 m has no edges, and short edges are dropped") {
    CHECK(edges_of(aula::test::box({0.15F, 0.15F, 0.15F})).empty());
    CHECK(edges_of(aula::test::box({0.5F, 0.09F, 0.5F})).size() == 8);
    CHECK(edges_of(aula::test::box({0.5F, 0.11F, 0.5F})).size() == 12);
}

TEST_CASE("among many objects the short edges are dropped, those of furniture are not") {
    // Boxes of 0.3 x 0.2 x 0.15 m, each with four edges of each length.
    const auto edges_of_boxes = [](int boxes) {
        Object object;
        for (int i = 0; i < boxes; ++i) {
            const Vec3 place(static_cast<float>(i % 30), static_cast<float>(i / 30), 0);
            add(object, aula::test::box({0.3F, 0.2F, 0.15F}, 0, place));
        }
        return edges_of(object);
    };
    const auto longer_than = [](const std::vector<DiffractionEdge>& edges, double length_m) {
        return std::count_if(edges.begin(), edges.end(),
                             [&](const DiffractionEdge& e) { return e.length_m > length_m; });
    };
    // As many as a frame may test for their detour: all lengths of a hundred boxes, the longest
    // ones of three hundred.
    CHECK(edges_of_boxes(100).size() == 1200);
    const auto many = edges_of_boxes(300);
    CHECK(many.size() == 2000);
    CHECK(longer_than(many, 0.25) == 1200);
    CHECK(longer_than(many, 0.17) == 2000);
    // However many they are, shelves and legs of chairs diffract.
    const auto crowd = edges_of_boxes(600);
    CHECK(crowd.size() == 2400);
    CHECK(longer_than(crowd, 0.25) == 2400);
}

TEST_CASE("an edge that a mesh divides into sides of 8 mm is one edge") {
    // A free wall of 1 m, the upper edge of which is the base of a fan.
    Object wall;
    constexpr int kSides = 125;
    const auto upper = [](int i) {
        return Vec3(static_cast<float>(i) / static_cast<float>(kSides), 0, 1);
    };
    for (int i = 0; i < kSides; ++i) add_triangle(wall, {0.5F, 0, 0}, upper(i), upper(i + 1));
    const auto edges = edges_of(wall);
    CHECK(edges.size() == 3);
    CHECK(length_m(edges) == Approx(1 + 2 * std::hypot(0.5, 1.0)).margin(1e-3));
}

TEST_CASE("edges follow any rigid motion of the soup") {
    aula::RandomStream random(9);
    const auto edges = edges_of(furnished());
    for (int trial = 0; trial < 20; ++trial) {
        const Vec3 a = aula::uniform_direction(random.uniform_2d());
        const Vec3 b = glm::normalize(glm::cross(a, aula::uniform_direction(random.uniform_2d())));
        const glm::mat3 turn(a, b, glm::cross(a, b));
        const Vec3 shift = 30.0F * aula::uniform_direction(random.uniform_2d());
        Object moved = split(furnished(), 1);
        for (Vec3& v : moved.vertices) v = turn * v + shift;
        std::vector<DiffractionEdge> expected = edges;
        const glm::dmat3 turn_d(turn);
        for (DiffractionEdge& edge : expected) {
            edge.start = turn_d * edge.start + glm::dvec3(shift);
            edge.axis = turn_d * edge.axis;
            edge.first_face = turn_d * edge.first_face;
        }
        CHECK(are_same(edges_of(moved), expected, 1e-3));  // floats of 30 m
    }
}

TEST_CASE("a short side within the tolerance of a long edge lies on it, in any direction") {
    // A free wall with a fin across the middle of its upper edge. The fin's side of 5 cm crosses
    // the edge at up to 2 degrees; its ends are 0.9 mm beside it.
    for (int step = 0; step < 50; ++step) {
        const float c = 0.002F * static_cast<float>(step);
        const Vec3 along(c, 0, std::sqrt(1 - c * c));
        const Vec3 across(-along.z, 0, along.x);
        for (const float beside_m : {9e-4F, -9e-4F}) {
            CAPTURE(c, beside_m);
            Object object;
            add_quad(object, Vec3(0), along, along - across, -across);
            add_triangle(object, 0.475F * along + beside_m * across,
                         0.525F * along - beside_m * across, 0.5F * along + Vec3(0, 0.2F, 0));
            const auto edges = edges_of(object);
            // The wedge of the fin, which is too short, divides the edge.
            CHECK(std::count_if(edges.begin(), edges.end(), [](const DiffractionEdge& edge) {
                      return std::abs(edge.length_m - 0.475) < 1e-3;
                  }) == 2);
        }
    }
}

TEST_CASE("an edge ends where either of its faces turns") {
    // A face in the plane y = 0, and on either side another at 90 degrees to it, then at 60.
    for (const float side : {1.0F, -1.0F}) {
        Object object;
        const Vec3 turned(0.5F, side * std::sqrt(0.75F), 0);
        const Vec3 up(0, 0, 1);
        add_quad(object, {0, 0, 0}, {1, 0, 0}, {1, 0, 2}, {0, 0, 2});
        add_quad(object, {0, 0, 0}, {0, side, 0}, {0, side, 1}, up);
        add_quad(object, up, up + turned, 2.0F * up + turned, 2.0F * up);
        const auto edges = edges_of(object);
        CHECK(count_of(edges, 270) == 1);
        CHECK(count_of(edges, 300) == 1);
    }
}

TEST_CASE("degenerate triangles and empty soups have no edges") {
    CHECK(edges_of(Object{}).empty());
    Object object;
    add_triangle(object, {0, 0, 0}, {5, 0, 0}, {9, 0, 0});
    add_triangle(object, {0, 0, 0}, {0, 0, 0}, {9, 0, 0});
    CHECK(edges_of(object).empty());
}

TEST_CASE("a triangle that is thinner than the tolerance has no edges, however short one side is") {
    const auto needle = [](float thickness_m) {
        Object object;
        add_triangle(object, {0, 0, 0}, {2, 0, 0}, {0.3F, thickness_m, 0});
        return edges_of(object);
    };
    CHECK(needle(9e-4F).empty());
    // One of 2 cm is a face whose three sides are free.
    CHECK(count_of(needle(0.02F), 360) == 3);
}
