#include "engine/edges/edge_passage.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "engine/base/tolerances.h"
#include "tests/engine/edges/obstacles.h"

namespace edge_passage_test {

using aula::DiffractionEdge;
using aula::EdgePassage;
using aula::Object;
using aula::Vec3;
using aula::WedgePoint;
using aula::test::kFar_m;
using aula::test::Place;

namespace {

constexpr double kPi = std::numbers::pi;

/// A vertical screen in the plane x = 0 from y = `low_m` to y = `high_m`.
Object screen(float low_m, float high_m) {
    constexpr float kHalf_m = 2;
    Object object;
    object.vertices = {
        {0, low_m, -kHalf_m}, {0, high_m, -kHalf_m}, {0, high_m, kHalf_m}, {0, low_m, kHalf_m}};
    object.triangles = {{0, 1, 2}, {0, 2, 3}};
    object.triangle_materials = {0, 0};
    return object;
}

/// The passage from one side of a screen's edge at y = 0 to the other, half-way along the edge.
EdgePassage over(const DiffractionEdge& edge) {
    return {edge, edge.length_m / 2, kPi / 2, 1.5 * kPi};
}

}  // namespace

TEST_CASE("a passage leads around its edge from the angle of arrival to that of departure") {
    const Place place({screen(-2, 0)});
    const DiffractionEdge& edge = *place.edge_at(0, 0);
    const EdgePassage passage(edge, 1, 1.0, 5.0);
    for (const double share : {0.0, 0.25, 1.0}) {
        const WedgePoint at = edge.coordinates(glm::dvec3(passage.point(share, 0.5)));
        // Points are single-precision numbers.
        CHECK(at.radius_m == Approx(0.5).epsilon(1e-6));
        CHECK(at.angle_rad == Approx(1 + 4 * share).epsilon(1e-6));
        CHECK(at.along_m == Approx(1).epsilon(1e-6));
    }
}

TEST_CASE("points of a passage are seen along the faces and the ends of its edge") {
    const Place place({screen(-2, 0)});
    const DiffractionEdge& edge = *place.edge_at(0, 0);
    for (const bool is_low : {true, false}) {
        const EdgePassage passage(edge, is_low ? -1 : edge.length_m + 1, 0.0, edge.open_angle_rad);
        for (const double share : {0.0, 1.0}) {
            const Vec3 point = passage.point(share);
            const WedgePoint at = edge.coordinates(glm::dvec3(point));
            // Not behind faces that begin at the ends, within the tolerance of a mesh.
            CHECK(std::min(at.along_m, edge.length_m - at.along_m) > 2 * aula::tolerances::kSame_m);
            // Not in the rounding of the face: the ray along its surface ends in front of it.
            const float side = share == 0 ? 1 : -1;
            const Vec3 normal(edge.direction(kPi / 2));
            const Vec3 on_face =
                Vec3(edge.point(at.along_m) + edge.first_face) + side * 2e-4F * normal;
            CHECK(place.rays.visible(on_face, point));
        }
    }
    // A short edge: off its ends by a quarter of its length.
    DiffractionEdge shorter = edge;
    shorter.length_m = 0.02;
    const EdgePassage passage(shorter, 0, 1, 5);
    CHECK(edge.coordinates(glm::dvec3(passage.point(0, 1))).along_m == Approx(0.005).epsilon(1e-3));
}

TEST_CASE("the opening of an edge is the free width beside it relative to 5 cm") {
    const Place alone({screen(-2, 0)});
    CHECK(over(*alone.edge_at(0, 0)).opening(alone.rays, 1) == 1);
    for (const double width_m : {0.002, 0.01, 0.03, 0.049}) {
        const Place slot({screen(-2, 0), screen(static_cast<float>(width_m), 2)});
        CAPTURE(width_m);
        // The short rays of a passage are chords: the second one, of share 0.37 to 0.69, passes
        // the plane of the screen at the cosine of half its angle times the radius.
        const double half_rad = 0.5 * (0.69 - 0.37) * kPi;
        const double across_rad = 0.5 * (0.69 + 0.37) * kPi - kPi / 2;
        const double per_radius = std::cos(half_rad) / std::cos(across_rad);
        CHECK(over(*slot.edge_at(0, 0)).opening(slot.rays, 1) ==
              Approx(std::min(1.0, width_m / per_radius / EdgePassage::kNarrow_m))
                  .margin(1.0 / 256 + 1e-3));
    }
    const Place wide({screen(-2, 0), screen(0.06F, 2)});
    CHECK(over(*wide.edge_at(0, 0)).opening(wide.rays, 1) == 1);
}

TEST_CASE("a width that is free up to an end of the path counts as wide") {
    const Place slot({screen(-2, 0), screen(0.02F, 2)});
    const EdgePassage passage = over(*slot.edge_at(0, 0));
    CHECK(passage.opening(slot.rays, 0.01) == 1);
    CHECK(passage.opening(slot.rays, 0.03) < 0.5);
}

TEST_CASE("a plate anywhere around an edge blocks its passage") {
    const Place open({screen(-2, 0)});
    const EdgePassage passage = over(*open.edge_at(0, 0));
    REQUIRE(passage.is_free(open.rays, 0.5));
    for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
        CAPTURE(share);
        const Vec3 near = passage.point(share, 0.2);
        const Vec3 far = passage.point(share, 0.8);
        const Vec3 along(0, 0, 0.3F);
        Object plate;
        plate.vertices = {near - along, far - along, far + along, near + along};
        plate.triangles = {{0, 1, 2}, {0, 2, 3}};
        plate.triangle_materials = {0, 0};
        const Place blocked({screen(-2, 0), plate});
        CHECK_FALSE(over(*blocked.edge_at(0, 0)).is_free(blocked.rays, 0.5));
    }
}

TEST_CASE("a leaf that joins the edge of a wall at any angle blocks its passage") {
    const Place open({screen(-2, 0)});
    const EdgePassage passage = over(*open.edge_at(0, 0));
    REQUIRE(passage.is_free(open.rays));
    for (int i = 1; i < 200; ++i) {
        const double share = i / 200.0;
        CAPTURE(share);
        const Vec3 far = passage.point(share, 1);
        Object leaf;
        leaf.vertices = {
            {0, 0, -kFar_m}, {far.x, far.y, -kFar_m}, {far.x, far.y, kFar_m}, {0, 0, kFar_m}};
        leaf.triangles = {{0, 1, 2}, {0, 2, 3}};
        leaf.triangle_materials = {0, 0};
        leaf.movable = true;
        const Place shut({screen(-2, 0), leaf});
        CHECK_FALSE(over(*shut.edge_at(0, 0)).is_free(shut.rays));
    }
}

TEST_CASE("a face that closes the open angle of an edge blocks its passage") {
    // The leaf of a shut door in the plane of its wall, with a gap below the radius of a passage.
    Object leaf = screen(1e-4F, 2);
    leaf.movable = true;
    const Place shut({screen(-2, 0), leaf});
    const DiffractionEdge& edge = *shut.edge_at(0, 0);
    CHECK_FALSE(over(edge).is_free(shut.rays));
    CHECK(over(edge).opening(shut.rays, 1) == 0);
    // On one side of the leaf nothing is between the points.
    CHECK(EdgePassage(edge, edge.length_m / 2, kPi / 4, kPi * 0.7).is_free(shut.rays));
}

}  // namespace edge_passage_test
