#include "engine/edges/knife_edges.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "engine/base/sampling.h"

namespace knife_edges_test {

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

/// The integral over the heights above all edges by Simpson's rule in many nodes. Where the
/// integrand grows it loses digits: the difference between two numbers of nodes tells.
std::complex<double> direct_integral(const std::vector<KnifeEdge>& edges, double length_m, double k,
                                     std::size_t intervals) {
    constexpr std::complex<double> kI(0, 1);
    const std::complex<double> turned = std::polar(1.0, -kPi / 4);
    std::vector<std::complex<double>> heights{0};
    std::vector<std::complex<double>> field{1};
    double at_m = 0;
    const auto arrive = [&](double to_m, const std::complex<double>& height) {
        const std::complex<double> per_m2 = kI * k / (2 * (to_m - at_m));
        std::complex<double> sum = 0;
        for (std::size_t i = 0; i < field.size(); ++i) {
            sum += field[i] * std::exp(-per_m2 * (height - heights[i]) * (height - heights[i]));
        }
        return sum * std::sqrt(per_m2 / kPi);
    };
    for (const KnifeEdge& edge : edges) {
        const double width_m = std::sqrt(edge.at_m * (length_m - edge.at_m) / (length_m * k));
        const double step_m = (8 * width_m + 2 * edge.clearance_m) / static_cast<double>(intervals);
        std::vector<std::complex<double>> next_heights;
        std::vector<std::complex<double>> next;
        for (std::size_t i = 0; i <= intervals; ++i) {
            const bool is_end = i == 0 || i == intervals;
            const double weight = is_end ? 1 : i % 2 == 1 ? 4 : 2;
            const std::complex<double> height =
                -edge.clearance_m + turned * (static_cast<double>(i) * step_m);
            next_heights.push_back(height);
            next.push_back(arrive(edge.at_m, height) * turned * (weight * step_m / 3) *
                           std::exp(-kI * k * edge.turn_rad * height));
        }
        heights = next_heights;
        field = next;
        at_m = edge.at_m;
    }
    return arrive(length_m, 0) / std::sqrt(kI * k / (2 * kPi * length_m));
}

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

TEST_CASE("over high and low edges in any order the field is that of the integral in many nodes") {
    // Edges 0.12 to 1.3 m apart, within 3 cm of the path or 0.1 to 0.5 m below it, the first one at
    // the path. 0.02 is 0.35 dB of the field of an edge at the path.
    constexpr double kLength_m = 8;
    aula::RandomStream random(4);
    const auto uniform = [&] { return double{random.uniform()}; };
    int compared = 0;
    double largest = 0;
    double largest_of_single = 0;  // companion: the product of the fields over single edges
    for (int row = 0; row < 24; ++row) {
        std::vector<KnifeEdge> edges;
        double at_m = 1;
        const double low_m = 0.1 + 0.4 * uniform();
        for (int i = 0; i < 2 + row % 4; ++i) {
            at_m += 0.12 + 1.2 * uniform() * uniform();
            const double clearance_m = (i == 0 || uniform() < 0.5 ? 0 : low_m) + 0.03 * uniform();
            edges.push_back({.at_m = at_m, .clearance_m = clearance_m});
        }
        const ComplexBands ratio = knife_edges(edges, kLength_m, kIntegral);
        ComplexBands product;
        product.fill(1);
        for (const KnifeEdge& edge : edges) {
            const ComplexBands single = knife_edges({&edge, 1}, kLength_m, kIntegral);
            for (std::size_t b = 0; b < kBandCount; ++b) product[b] *= single[b];
        }
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double k = kIntegral.wave_number_per_m(b);
            const std::complex<double> want = direct_integral(edges, kLength_m, k, 200);
            const std::complex<double> other = direct_integral(edges, kLength_m, k, 160);
            if (!(std::abs(want - other) < 1e-4) || std::abs(want) > 1.5) continue;
            ++compared;
            largest = std::max(largest, std::abs(ratio[b] - want));
            largest_of_single = std::max(largest_of_single, std::abs(product[b] - want));
        }
    }
    CHECK(compared > 100);
    CHECK(largest < 0.02);
    CHECK(largest_of_single > 0.1);
}

TEST_CASE("the field over low edges in front of and behind a higher one is the integral's") {
    // The integrand decays along the heights below a low edge, the faster the steeper the slope to
    // the edges beside it: here 3.3 and 2.6 m per metre.
    constexpr double kLength_m = 23.7;
    constexpr std::size_t kBand = 3;
    const std::vector<KnifeEdge> edges{{.at_m = 6.926, .turn_rad = 0.0121},
                                       {.at_m = 7.111, .clearance_m = 0.8365},
                                       {.at_m = 7.301, .clearance_m = 0.3337},
                                       {.at_m = 7.531, .clearance_m = 0.8994}};
    const double k = kIntegral.wave_number_per_m(kBand);
    const std::complex<double> want = direct_integral(edges, kLength_m, k, 600);
    REQUIRE(std::abs(want - direct_integral(edges, kLength_m, k, 500)) < 1e-4);
    // The same from the other end.
    std::vector<KnifeEdge> reversed(edges.rbegin(), edges.rend());
    for (KnifeEdge& edge : reversed) edge.at_m = kLength_m - edge.at_m;
    // As above, 0.02 is 0.35 dB of the field of an edge at the path.
    for (const auto& order : {edges, reversed}) {
        CHECK(std::abs(knife_edges(order, kLength_m, kIntegral)[kBand] - want) < 0.02);
    }
}

TEST_CASE("of two low edges of very different heights the lower one counts as far away") {
    // Both are below the first edge; above the lower one the integrand would grow by e^20.
    constexpr double kLength_m = 8;
    constexpr std::size_t kBand = 5;
    const std::vector<KnifeEdge> edges{{.at_m = 1, .clearance_m = 0.009},
                                       {.at_m = 1.379, .clearance_m = 0.516},
                                       {.at_m = 1.487, .clearance_m = 0.149},
                                       {.at_m = 1.602, .clearance_m = 0.66}};
    const double k = kIntegral.wave_number_per_m(kBand);
    const std::complex<double> want = direct_integral(edges, kLength_m, k, 300);
    REQUIRE(std::abs(want - direct_integral(edges, kLength_m, k, 250)) < 1e-4);
    // 1.5 dB of the field of an edge at the path.
    CHECK(std::abs(knife_edges(edges, kLength_m, kIntegral)[kBand] - want) < 0.1);
}

TEST_CASE("of edges that are too close to be told apart the higher one counts") {
    const KnifeEdge high{.at_m = 5, .turn_rad = 0, .clearance_m = 0.1};
    const KnifeEdge low{.at_m = 5.001, .turn_rad = 0, .clearance_m = 0.5};
    const ComplexBands alone = knife_edges({&high, 1}, 10, kIntegral);
    const std::vector<KnifeEdge> both{high, low};
    const ComplexBands joined = knife_edges(both, 10, kIntegral);
    for (std::size_t b = 0; b < kBandCount; ++b) {
        // The joined edge is 0.5 mm from the higher one.
        CHECK(std::abs(joined[b] - alone[b]) < 1e-4);
    }
}

}  // namespace knife_edges_test
