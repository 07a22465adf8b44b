#include "engine/edges/knife_edges.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

using aula::ComplexBands;
using aula::kBandCount;
using aula::knife_edges;
using aula::KnifeEdge;
using aula::WedgeIntegral;

namespace {

constexpr double kPi = std::numbers::pi;
const WedgeIntegral kIntegral(343.2);

// The rule of 20 nodes in exact arithmetic; the integrand is analytic.
constexpr double kQuadrature = 1e-4;

}  // namespace

TEST_CASE("N knife edges at equal distances that a straight path touches leave 1 / (N + 1)") {
    for (const int count : {1, 2, 3, 5, 8, 12, 30}) {
        std::vector<KnifeEdge> edges;
        for (int i = 1; i <= count; ++i) edges.push_back({.at_m = 3.0 * i});
        for (const auto& ratio : knife_edges(edges, 3.0 * (count + 1), kIntegral)) {
            CHECK(std::abs(ratio * (count + 1.0) - 1.0) < kQuadrature);
            // The product of single edges.
            if (count > 1) CHECK(std::abs(ratio) > 1.2 * std::pow(0.5, count));
        }
    }
}

TEST_CASE("two knife edges that a straight path touches leave the share of a normal orthant") {
    // 1 / 4 + asin(rho) / (2 pi) with the correlation of a Brownian bridge at both edges.
    for (const double first_m : {0.5, 2.0, 4.0}) {
        constexpr double kSecond_m = 5;
        constexpr double kLength_m = 8;
        const double rho =
            std::sqrt(first_m * (kLength_m - kSecond_m) / (kSecond_m * (kLength_m - first_m)));
        const std::array edges{KnifeEdge{.at_m = first_m}, KnifeEdge{.at_m = kSecond_m}};
        for (const auto& ratio : knife_edges(edges, kLength_m, kIntegral))
            CHECK(std::abs(ratio - (0.25 + std::asin(rho) / (2 * kPi))) < kQuadrature);
    }
}

TEST_CASE("one knife edge has the field of a half plane without its faces") {
    // The error of the paraxial distance is turn^2 / 8 of it, and 1 / (4 k a) of the field.
    constexpr double kBefore_m = 3;
    constexpr double kAfter_m = 5;
    constexpr double kLength_m = kBefore_m + kAfter_m;
    for (const double turn_rad : {-0.3, -0.1, -0.02, 0.02, 0.1, 0.3}) {
        const double reduced_m = kBefore_m * kAfter_m / kLength_m;
        const KnifeEdge edge{.at_m = kBefore_m,
                             .turn_rad = std::max(0.0, turn_rad),
                             .clearance_m = std::max(0.0, -turn_rad) * reduced_m};
        const ComplexBands ratio = knife_edges({&edge, 1}, kLength_m, kIntegral);
        const ComplexBands incident =
            kIntegral.field({}, {kBefore_m, kPi / 2, 0}, {kAfter_m, 1.5 * kPi + turn_rad, 0})
                .incident;
        const double straight_m = std::sqrt(kBefore_m * kBefore_m + kAfter_m * kAfter_m +
                                            2 * kBefore_m * kAfter_m * std::cos(turn_rad));
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double k = kIntegral.wave_number_per_m(b);
            const double exact =
                turn_rad > 0
                    ? std::abs(incident[b]) * kLength_m
                    : std::abs(1.0 + incident[b] * straight_m * std::polar(1.0, k * straight_m));
            CAPTURE(turn_rad, b);
            CHECK(std::abs(ratio[b]) ==
                  Approx(exact).epsilon(turn_rad * turn_rad / 8 + 1 / (4 * k * kBefore_m)));
        }
    }
}

TEST_CASE("an edge far below a path changes nothing, however close the others are") {
    const std::vector<KnifeEdge> near{{.at_m = 2}, {.at_m = 4, .turn_rad = 0.02}, {.at_m = 5}};
    std::vector<KnifeEdge> all = near;
    all.insert(all.begin() + 1, {.at_m = 3, .clearance_m = 20});
    const ComplexBands with = knife_edges(all, 8, kIntegral);
    const ComplexBands without = knife_edges(near, 8, kIntegral);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        // Its field: 1 / (2 sqrt(pi detour)), the detour of 20^2 / 2 * (1 / 3 + 1 / 1) m in rad.
        const double detour_rad = kIntegral.wave_number_per_m(b) * 800 / 3;
        CHECK(std::abs(with[b] / without[b] - 1.0) < 1 / (2 * std::sqrt(kPi * detour_rad)) + 1e-6);
    }
}

TEST_CASE("the field of an edge below a path does not depend on one far below beside it") {
    const KnifeEdge edge{.at_m = 3, .clearance_m = 1};
    const std::array both{KnifeEdge{.at_m = 2, .clearance_m = 50}, edge};
    const ComplexBands with = knife_edges(both, 8, kIntegral);
    const ComplexBands without = knife_edges({&edge, 1}, 8, kIntegral);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        // The field of the other edge: its detour is 50^2 / 2 * (1 / 2 + 1 / 6) m.
        const double detour_rad = kIntegral.wave_number_per_m(b) * 2500 / 3;
        CAPTURE(b);
        CHECK(std::abs(with[b] / without[b] - 1.0) < 1 / (2 * std::sqrt(kPi * detour_rad)) + 1e-6);
    }
}
