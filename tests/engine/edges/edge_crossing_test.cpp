#include "engine/edges/edge_crossing.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "engine/base/sampling.h"

namespace edge_crossing_test {

using aula::DiffractionEdge;
using aula::EdgeCrossing;

namespace {

/// The edge of a half plane along z.
DiffractionEdge edge_of(double length_m) {
    return {.axis = {0, 0, 1},
            .first_face = {1, 0, 0},
            .length_m = length_m,
            .open_angle_rad = 2 * std::numbers::pi};
}

EdgeCrossing over(const DiffractionEdge& edge, const glm::dvec3& source,
                  const glm::dvec3& listener) {
    const auto path = EdgeCrossing::over(edge, source, listener, edge.coordinates(source),
                                         edge.coordinates(listener));
    REQUIRE(path);
    return *path;
}

}  // namespace

TEST_CASE("the path over an edge is the shortest, with the same length from both ends") {
    aula::RandomStream random(3);
    const auto point = [&] {
        const auto coordinate = [&] { return 6 * double{random.uniform()} - 3; };
        return glm::dvec3(coordinate(), coordinate(), coordinate());
    };
    int beyond_ends = 0;
    for (int i = 0; i < 200; ++i) {
        const DiffractionEdge edge = edge_of(1.5);
        const glm::dvec3 source = point();
        const glm::dvec3 listener = point();
        const EdgeCrossing path = over(edge, source, listener);
        double least_m = 1e9;
        for (int k = 0; k <= 1000; ++k) {
            const glm::dvec3 at = edge.point(1.5e-3 * k);
            least_m = std::min(least_m, glm::distance(source, at) + glm::distance(at, listener));
        }
        CHECK(path.length_m <= least_m + 1e-12);
        CHECK(path.length_m == Approx(least_m).margin(1e-4));  // 1000 points per edge
        CHECK(path.detour_m ==
              Approx(path.length_m - glm::distance(source, listener)).margin(1e-12));
        CHECK(over(edge, listener, source).length_m == Approx(path.length_m).epsilon(1e-12));
        beyond_ends += path.apex_m != path.along_m ? 1 : 0;
    }
    CHECK(beyond_ends > 20);
    CHECK(beyond_ends < 180);
}

TEST_CASE("a straight line is beside an edge within its tolerance, and between its ends alone") {
    const DiffractionEdge edge = edge_of(2);
    const auto is_beside = [&](double past_m, double along_m) {
        return over(edge, {past_m, -3, along_m}, {past_m, 5, along_m}).is_at_boundary();
    };
    const double tolerance_m = EdgeCrossing::kBeside_m;
    for (const double sign : {-1.0, 1.0}) {
        CHECK(is_beside(0.9 * sign * tolerance_m, 1));
        CHECK_FALSE(is_beside(1.1 * sign * tolerance_m, 1));
        CHECK_FALSE(is_beside(0.9 * sign * tolerance_m, 2.1));
        CHECK_FALSE(is_beside(0.9 * sign * tolerance_m, -0.1));
    }
}

TEST_CASE("there is no path over an edge between two points of its line") {
    const DiffractionEdge edge = edge_of(2);
    const glm::dvec3 source{0, 0, -1};
    const glm::dvec3 listener{0, 0, 4};
    CHECK_FALSE(EdgeCrossing::over(edge, source, listener, edge.coordinates(source),
                                   edge.coordinates(listener)));
}

}  // namespace edge_crossing_test
