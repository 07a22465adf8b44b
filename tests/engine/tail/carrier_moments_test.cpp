#include "engine/tail/carrier_moments.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using aula::CarrierMoments;

TEST_CASE("the moments of a carrier are its sums, for any number of samples") {
    for (const std::size_t count : {1U, 15U, 16U, 100U, 1024U}) {
        CAPTURE(count);
        std::vector<std::int16_t> carrier(count), other(count);
        CarrierMoments expected;
        for (std::size_t j = 0; j < count; ++j) {
            const auto angle = 1 + 0.7 * static_cast<double>(j);
            carrier[j] = static_cast<std::int16_t>(30000 * std::sin(angle));
            other[j] = static_cast<std::int16_t>(30000 * std::sin(angle + 1));
            const auto x = static_cast<double>(carrier[j]);
            const double power = x * x;
            const double t = 0.25 + 0.001 * static_cast<double>(j);
            expected.zeroth += power;
            expected.first += power * t;
            expected.second += power * t * t;
            expected.product += x * static_cast<double>(other[j]);
        }
        CarrierMoments sums;
        sums.add(carrier, other.data(), 0.25F, 0.001F);
        CHECK(sums.zeroth == Approx(expected.zeroth).epsilon(1e-5));
        CHECK(sums.first == Approx(expected.first).epsilon(1e-5));
        CHECK(sums.second == Approx(expected.second).epsilon(1e-5));
        CHECK(sums.product == Approx(expected.product).margin(1e-5 * expected.zeroth));
        // Parts add up.
        CarrierMoments parts;
        const std::size_t half = count / 2;
        parts.add(std::span<const std::int16_t>(carrier).first(half), other.data(), 0.25F, 0.001F);
        parts.add(std::span<const std::int16_t>(carrier).subspan(half), other.data() + half,
                  0.25F + 0.001F * static_cast<float>(half), 0.001F);
        CHECK(parts.second == Approx(expected.second).epsilon(1e-5));
    }
}
