#include "engine/base/near_field.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "aula/engine/directivity.h"

using namespace aula;

TEST_CASE("A direction fades with the distance within 0.1 m and is continuous") {
    CHECK(near_direction(glm::dvec3(0)) == Vec3(0));
    CHECK(near_direction({0, -5, 0}) == Vec3(0, -1, 0));
    CHECK(near_direction({0, 0, 0.1}) == Vec3(0, 0, 1));
    CHECK(glm::length(near_direction({0.03, 0.04, 0})) == Approx(0.5).epsilon(1e-6));
    // Across a listener, in steps of 1 mm.
    for (double x = -0.2; x < 0.2; x += 1e-3) {
        const Vec3 step = near_direction({x + 1e-3, 0, 0}) - near_direction({x, 0, 0});
        CHECK(glm::length(step) < 0.0101F);  // 1 mm of 0.1 m
    }
}

TEST_CASE("A receiver at a source hears the mean of its directivity") {
    const Directivity cardioid = Directivity::first_order(0.5F);
    const Bands front = cardioid.factor(Vec3(1, 0, 0));
    const Bands half = cardioid.factor(Vec3(0.5F, 0, 0));
    for (std::size_t b = 0; b < kBandCount; ++b) {
        CHECK(cardioid.factor(Vec3(0))[b] == 1);
        CHECK(half[b] == Approx(0.5F + 0.5F * front[b]).epsilon(1e-6));
        // Companion: to the front it is 3, the ratio of the front to the mean.
        CHECK(front[b] == Approx(3));
    }
}
