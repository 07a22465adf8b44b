#include "engine/edges/edge_field.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "tests/engine/edges/obstacles.h"

using aula::ComplexBands;
using aula::DiffractionEdge;
using aula::kBandCount;
using aula::WedgeIntegral;
using aula::WedgePoint;
using aula::test::kFar_m;
using aula::test::Place;
using aula::test::prism;

TEST_CASE("the field of an edge has no step where a reflection appears, however near the shadow") {
    const WedgeIntegral integral(343.2);
    const Place place({prism({{-kFar_m, -kFar_m}, {0, -kFar_m}, {0, 0}, {-kFar_m, 0}})});
    const DiffractionEdge& edge = *place.edge_at(0, 0);
    const double middle_m = edge.length_m / 2;
    constexpr double kPi = std::numbers::pi;
    constexpr double kBeside_rad = 1e-5;
    for (const double source_rad : {0.05, 0.25, 1.0}) {
        const WedgePoint source{3, source_rad, middle_m};
        const auto receiver = [&](double angle_rad) { return WedgePoint{1, angle_rad, middle_m}; };
        const auto field = [&](double angle_rad) {
            return edge_field(integral, place.rays, edge, source, receiver(angle_rad), {});
        };
        // The reflection at the first face.
        const double reflection_rad = kPi - source_rad;
        const ComplexBands below = field(reflection_rad - kBeside_rad);
        const ComplexBands above = field(reflection_rad + kBeside_rad);
        const ComplexBands exact_below =
            integral.field(edge.wedge(), source, receiver(reflection_rad - kBeside_rad)).total();
        const ComplexBands exact_above =
            integral.field(edge.wedge(), source, receiver(reflection_rad + kBeside_rad)).total();
        // At the boundary of the shadow all terms count.
        const double shadow_rad = kPi + source_rad;
        const ComplexBands lit = field(shadow_rad - kBeside_rad);
        const ComplexBands exact_lit =
            integral.field(edge.wedge(), source, receiver(shadow_rad - kBeside_rad)).total();
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CAPTURE(source_rad, b);
            CHECK(std::abs(above[b] - below[b]) < 0.002);
            CHECK(std::abs(exact_above[b] - exact_below[b]) ==
                  Approx(0.25).epsilon(0.01));  // 1 / R
            CHECK(std::abs(lit[b] - exact_lit[b]) < 0.002);
        }
    }
}
