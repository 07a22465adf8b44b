#include "engine/base/air_attenuation.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

using namespace aula;

TEST_CASE("the transmission of air is exp(-m l) in each band") {
    // Exponents from 0 to 69, the limit below which values are negligible.
    Bands attenuation_per_m;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        attenuation_per_m[b] = 1e-4F * std::pow(2.7F, static_cast<float>(b));
    }
    double largest_error = 0;
    for (float length_m = 0; length_m < 600; length_m += 0.37F) {
        const Bands share = transmission(attenuation_per_m, length_m);
        for (std::size_t b = 0; b < kBandCount; ++b) {
            const double exponent = double{attenuation_per_m[b]} * double{length_m};
            if (exponent > 69) continue;
            // The product is rounded in single precision before the exponential.
            const double bound = 2e-7 + 1.2e-7 * exponent;
            largest_error = std::max(largest_error,
                                     std::abs(double{share[b]} * std::exp(exponent) - 1) / bound);
        }
    }
    CHECK(largest_error < 1);
    CHECK(transmission(attenuation_per_m, 0)[0] == 1);
    CHECK(transmission(Bands::filled(1), 1e4F).max() < 1e-29F);
}
