#include "engine/edges/diffraction_edge.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

using aula::DiffractionEdge;
using aula::WedgePoint;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRounding = 1e-12;  // some operations on numbers of the order of 1

/// An edge along y from (1, 2, 3), with its first face towards +z: angle 90 degrees is towards +x.
DiffractionEdge edge_of(double open_angle_rad) {
    DiffractionEdge edge;
    edge.start = {1, 2, 3};
    edge.axis = {0, 1, 0};
    edge.first_face = {0, 0, 1};
    edge.length_m = 4;
    edge.open_angle_rad = open_angle_rad;
    return edge;
}

}  // namespace

TEST_CASE("angles are measured about the axis of an edge by the right-hand rule") {
    const DiffractionEdge edge = edge_of(1.5 * kPi);
    CHECK(glm::distance(edge.direction(0), {0, 0, 1}) < kRounding);
    CHECK(glm::distance(edge.direction(kPi / 2), {1, 0, 0}) < kRounding);
    CHECK(glm::distance(edge.direction(kPi), {0, 0, -1}) < kRounding);
    CHECK(glm::distance(edge.point(1.5), {1, 3.5, 3}) < kRounding);
    CHECK(edge.bend_rad() == Approx(kPi / 2));
}

TEST_CASE("a point of given coordinates has these coordinates") {
    const DiffractionEdge edge = edge_of(2 * kPi);
    for (const double angle_rad : {0.3, 1.7, 3.5, 4.2, 6.1}) {
        const WedgePoint at = edge.coordinates(edge.point(-0.5) + 2.5 * edge.direction(angle_rad));
        CHECK(at.radius_m == Approx(2.5).epsilon(kRounding));
        CHECK(at.angle_rad == Approx(angle_rad).epsilon(kRounding));
        CHECK(at.along_m == Approx(-0.5).epsilon(kRounding));
    }
}

TEST_CASE("a point in the plane of a screen is on the given side of it") {
    // For the edges at both ends of a screen, whose normals point to opposite sides.
    constexpr double kWidth_m = 1;
    const DiffractionEdge low = edge_of(2 * kPi);
    DiffractionEdge high = low;
    high.start += kWidth_m * low.first_face;
    high.first_face = -low.first_face;
    REQUIRE(low.is_free());
    for (const double beside_m : {-2.0, 0.5, 3.0}) {
        for (const double side : {DiffractionEdge::kSourceSide, DiffractionEdge::kListenerSide}) {
            for (const double off_m : {0.0, 9e-6, -9e-6}) {
                const glm::dvec3 point =
                    low.point(1) + beside_m * low.first_face + off_m * low.direction(kPi / 2);
                CAPTURE(beside_m, side, off_m);
                for (const DiffractionEdge& edge : {low, high}) {
                    const WedgePoint at = edge.coordinates(point, side);
                    const double x_m = at.radius_m * edge.direction(at.angle_rad).x;
                    CHECK(x_m == Approx(1e-5 * side).epsilon(1e-4));
                }
            }
        }
    }
    // Off the plane, near the edge and at a wedge the side is that of the point.
    const auto angle = [](const DiffractionEdge& edge, double radius_m, double angle_rad) {
        return edge.coordinates(edge.point(1) + radius_m * edge.direction(angle_rad), -1).angle_rad;
    };
    CHECK(angle(low, 1, 2e-5) == Approx(2e-5));
    CHECK(angle(low, 9e-4, 1e-3) == Approx(1e-3));
    CHECK(angle(edge_of(1.5 * kPi), 1, 1e-6) == Approx(1e-6));
}

TEST_CASE("a curved surface is nearest to the straight line between the normals of its faces") {
    // Surfaces that turn by 0.4: the normals are at pi / 2 and pi / 2 + 0.4.
    const DiffractionEdge edge = edge_of(kPi + 0.4);
    for (const double turn_rad : {-0.3, 0.0, 0.3}) {
        const auto is_nearest = [&](double middle_rad) {
            const double half_rad = (kPi + turn_rad) / 2;
            return edge.is_nearest({2, middle_rad - half_rad, 0}, {2, middle_rad + half_rad, 1});
        };
        CHECK_FALSE(is_nearest(kPi / 2 - 0.01));
        CHECK(is_nearest(kPi / 2 + 0.01));
        CHECK(is_nearest(kPi / 2 + 0.39));
        CHECK_FALSE(is_nearest(kPi / 2 + 0.41));
    }
}

TEST_CASE("an edge whose faces are one bounds a screen and its extension") {
    const DiffractionEdge screen = edge_of(2 * kPi);
    const auto at = [](const DiffractionEdge& edge, double angle_rad) {
        return edge.point(7) + 2.0 * edge.direction(angle_rad);
    };
    CHECK(screen.is_in_screen(at(screen, 0.01)));
    CHECK(screen.is_in_screen(at(screen, -0.01)));
    CHECK_FALSE(screen.is_in_screen(at(screen, 0.02)));  // one degree is 0.0175
    CHECK_FALSE(screen.is_in_screen(at(screen, -0.02)));
    CHECK_FALSE(screen.is_in_screen(at(screen, kPi)));
    const DiffractionEdge wedge = edge_of(2 * kPi - 0.02);
    CHECK_FALSE(wedge.is_free());
    CHECK_FALSE(wedge.is_in_screen(at(wedge, 0)));
}
