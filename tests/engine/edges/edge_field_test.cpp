#include "engine/edges/edge_field.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "engine/base/air_attenuation.h"
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

TEST_CASE("the air takes as much energy from a bent path as from a straight one of its length") {
    aula::Bands attenuation_per_m;
    for (std::size_t b = 0; b < kBandCount; ++b)
        attenuation_per_m[b] = 0.001F * static_cast<float>(b);
    const aula::Bands straight = aula::transmission(attenuation_per_m, 30);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double pressure = aula::air_loss(30, attenuation_per_m, b);
        CHECK(pressure * pressure == Approx(straight[b]).epsilon(1e-5));  // single precision
    }
}

TEST_CASE("the more a curved surface turns a path, the quieter the path is") {
    const WedgeIntegral integral(343.2);
    const Place place({prism({{-kFar_m, -kFar_m}, {0, -kFar_m}, {0, 0}, {-kFar_m, 0}})});
    const DiffractionEdge& edge = *place.edge_at(0, 0);
    const WedgePoint end{3, 0, edge.length_m / 2};
    const auto field = [&](double turn_rad) {
        return curved_field(integral, place.rays, edge, turn_rad, end, end);
    };
    ComplexBands last = field(0);
    for (const double turn_rad : {0.1, 0.4, 1.2}) {
        const ComplexBands now = field(turn_rad);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            CAPTURE(turn_rad, b);
            CHECK(std::abs(now[b]) < std::abs(last[b]));
            // In the shadow the field is within 90 degrees of that of the source; where the
            // source is in sight, the field of an edge is opposed to it.
            const double phase = -integral.wave_number_per_m(b) * 6;
            CHECK((now[b] * std::polar(1.0, -phase)).real() > 0);
        }
        last = now;
    }
}

TEST_CASE("a point within a wedge has the angle of the face that is nearest to it") {
    const Place place({prism({{-kFar_m, -kFar_m}, {0, -kFar_m}, {0, 0}, {-kFar_m, 0}})});
    const DiffractionEdge& edge = *place.edge_at(0, 0);
    const auto angle_of = [&](double angle_rad) {
        return edge.open_angle_of(WedgePoint{1, angle_rad, 1});
    };
    CHECK(angle_of(1) == 1);
    CHECK(angle_of(edge.open_angle_rad + 0.1) == edge.open_angle_rad);
    CHECK(angle_of(2 * std::numbers::pi - 0.1) == 0);
}
