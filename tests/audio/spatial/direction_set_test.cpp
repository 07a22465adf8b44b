#include "audio/spatial/direction_set.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "audio/spatial/default_head.h"
#include "tests/audio/spatial/spherical_head.h"

using namespace aula;
using namespace aula::test;

namespace {

std::vector<ClosingDirection> closing(const Directions& directions) {
    return closing_directions(directions, quadrature_weights(directions));
}

Directions unit_vectors(Directions vectors) {
    for (Direction& v : vectors) {
        const float length = std::hypot(v[0], v[1], v[2]);
        for (float& x : v) x /= length;
    }
    return vectors;
}

double nearest_deg(const Directions& directions, const Direction& to) {
    double cosine = -1;
    for (const Direction& d : directions)
        cosine = std::max(cosine, double{d[0] * to[0] + d[1] * to[1] + d[2] * to[2]});
    return std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi;
}

}  // namespace

TEST_CASE("Sets that cover the sphere are left as they are") {
    const std::vector<std::pair<const char*, Directions>> sets{
        {"tetrahedron", unit_vectors({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}})},
        {"octahedron", {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}},
        {"cube", unit_vectors({{1, 1, 1},
                               {1, 1, -1},
                               {1, -1, 1},
                               {1, -1, -1},
                               {-1, 1, 1},
                               {-1, 1, -1},
                               {-1, -1, 1},
                               {-1, -1, -1}})},
        {"10 by 10 degrees", ring_directions(-90, 90, 10, 36)},
        {"15 by 15 degrees", ring_directions(-90, 90, 15, 24)},
        {"5 by 10 degrees", ring_directions(-90, 90, 10, 72)},
        {"20 even", uniform_directions(20)},
        {"100 even", uniform_directions(100)},
        {"1000 even", uniform_directions(1000)}};
    for (const auto& [name, directions] : sets) {
        CAPTURE(name);
        CHECK(closing(directions).empty());
    }
}

TEST_CASE("The gaps of a set are closed at steps of 5 degrees") {
    Directions kemar = default_head().positions;
    kemar = unit_vectors(kemar);
    const std::vector<std::pair<const char*, Directions>> sets{
        {"from -40 degrees", kemar},
        {"horizontal ring", ring_directions(0, 0, 1, 72)},
        {"ring of six", ring_directions(0, 0, 1, 6)},
        {"upper half", ring_directions(0, 90, 15, 24)},
        {"between 60 degrees", ring_directions(-60, 60, 10, 36)},
        {"without the poles", ring_directions(-85, 85, 5, 72)}};
    for (const auto& [name, directions] : sets) {
        CAPTURE(name);
        const std::vector<ClosingDirection> added = closing(directions);
        Directions all = directions;
        for (const ClosingDirection& d : added) {
            double sum = 0;
            for (const auto& [index, share] : d.shares) {
                CHECK(share >= 0);
                CHECK(index < directions.size());
                sum += share;
            }
            CHECK(sum == Approx(1).epsilon(1e-12));
            all.push_back(d.direction);
        }
        // A direction is closed if it is farther from the measured ones than the radius of a cap of
        // 2.8 times the median share of the sphere. The centre of a square of 5 degrees is 3.6 from
        // its corners.
        std::vector<double> shares = quadrature_weights(directions);
        std::sort(shares.begin(), shares.end());
        const double median = shares[shares.size() / 2];
        const double bound_deg =
            std::acos(std::max(-1.0, 1 - 5.6 * median)) * 180 / std::numbers::pi + 3.6;
        double farthest_deg = 0;
        for (const Direction& d : uniform_directions(2000))
            farthest_deg = std::max(farthest_deg, nearest_deg(all, d));
        CHECK(farthest_deg < bound_deg);
        // Companion: without them.
        CHECK(nearest_deg(directions, {0, 0, -1}) > bound_deg - 3.6);
    }
}

TEST_CASE("Directions whose cone of confusion was not measured are not added") {
    // A set of the median plane does not tell how the ears differ beside it.
    Directions median;
    for (int i = 0; i < 36; ++i) {
        const double angle = i * std::numbers::pi / 18;
        median.push_back(
            {static_cast<float>(std::cos(angle)), 0, static_cast<float>(std::sin(angle))});
    }
    // 36 even directions cover 33 degrees around each.
    for (const ClosingDirection& d : closing(median)) CHECK(std::abs(d.direction[1]) < 0.55F);
}

TEST_CASE("Of each direction the most distant position counts, and of equal ones the first") {
    const Directions once = uniform_directions(100);
    Directions positions;
    for (const float distance : {1.0F, 0.2F, 3.0F, 3.0F}) {
        for (const auto& d : once)
            positions.push_back({distance * d[0], distance * d[1], distance * d[2]});
    }
    const std::vector<std::size_t> kept = distinct_directions(positions);
    REQUIRE(kept.size() == 100);
    for (std::size_t k = 0; k < 100; ++k) CHECK(kept[k] == 200 + k);
    // A degree apart they differ.
    CHECK(distinct_directions(ring_directions(0, 0, 1, 360)).size() == 360);
    CHECK(distinct_directions(Directions(5, {0, 0, -1})).size() == 1);
}

TEST_CASE("Directions that coincide are no error") {
    for (const Direction& d : {Direction{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}) {
        for (const ClosingDirection& added : closing(Directions(5, d))) {
            for (const auto& [index, share] : added.shares) CHECK(std::isfinite(share));
        }
    }
}

TEST_CASE("Four directions of a ring count equally at its poles") {
    const Directions ring = ring_directions(0, 0, 1, 4);
    for (const float z : {1.0F, -1.0F}) {
        const InterpolationWeights weights = interpolation_weights(ring, {0, 0, z});
        for (std::size_t k = 0; k < 4; ++k) CHECK(weights.weight[k] == Approx(0.25).margin(1e-6));
    }
}
