#include "engine/base/sampling.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <set>
#include <vector>

#include "engine/base/air_attenuation.h"

using namespace aula;

TEST_CASE("scrambled Sobol points fill every elementary interval once") {
    // The first 2^6 points of a (0, 2)-sequence: one in each 2^-a x 2^-(6-a) box, exactly.
    const ScrambledSobol sobol(7);
    for (int a = 0; a <= 6; ++a) {
        std::set<std::pair<int, int>> boxes;
        for (std::uint32_t i = 0; i < 64; ++i) {
            const auto [x, y] = sobol.point(i);
            boxes.emplace(static_cast<int>(x * static_cast<float>(1 << a)),
                          static_cast<int>(y * static_cast<float>(1 << (6 - a))));
        }
        CHECK(boxes.size() == 64);
    }
}

TEST_CASE("different seeds give different Sobol points") {
    CHECK(ScrambledSobol(1).point(0) != ScrambledSobol(2).point(0));
}

TEST_CASE("uniform and Lambert directions have the moments of their densities") {
    RandomStream random(3);
    constexpr int kCount = 200000;
    const Vec3 normal = glm::normalize(Vec3(1, 2, -2));
    double lambert_cosine = 0;
    double lambert_square = 0;
    double uniform_square = 0;
    Vec3 uniform_mean(0);
    for (int i = 0; i < kCount; ++i) {
        const float cosine = glm::dot(lambert_direction(normal, random.uniform_2d()), normal);
        REQUIRE(cosine >= -1e-6F);
        lambert_cosine += double{cosine} / kCount;
        lambert_square += double{cosine * cosine} / kCount;
        const Vec3 u = uniform_direction(random.uniform_2d());
        uniform_mean += u / float{kCount};
        uniform_square += double{u.z * u.z} / kCount;
    }
    // Standard errors are below 0.3 / sqrt(2e5) = 7e-4; four of them.
    CHECK(lambert_cosine == Approx(2.0 / 3).margin(0.003));
    CHECK(lambert_square == Approx(1.0 / 2).margin(0.003));
    CHECK(uniform_square == Approx(1.0 / 3).margin(0.003));
    CHECK(glm::length(uniform_mean) < 0.006F);
}

TEST_CASE("transmission is exp(-m length)") {
    for (float x = 0; x < 60; x += 0.037F) {
        Bands m;
        for (std::size_t b = 0; b < kBandCount; ++b) m[b] = 0.1F * static_cast<float>(b);
        const Bands t = transmission(m, x);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            // 2e-7 for the polynomial, and half an ulp of an exponent of up to 60.
            CHECK(t[b] == Approx(std::exp(-double{m[b]} * double{x})).epsilon(5e-6));
        }
    }
    CHECK(transmission(Bands{}, 100) == Bands::filled(1));
}
