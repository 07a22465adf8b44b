#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace aula::test {

/// Level at a point of a rigid sphere of 8.75 cm for a point source at `distance_m` from its
/// centre, dB re the free field at the centre, by Duda and Martens 1998, eq. 1. `cosine` is that of
/// the angle between source and point.
inline double rigid_sphere_db(double distance_m, double cosine, double frequency_hz) {
    constexpr double kRadius_m = 0.0875;
    const double mu = 2 * std::numbers::pi * frequency_hz * kRadius_m / 343.2;
    const double rho = distance_m / kRadius_m;
    const auto hankel = [](unsigned m, double x) {
        return std::complex<double>(std::sph_bessel(m, x), std::sph_neumann(m, x));
    };
    // Terms fall as rho^-m, and beyond the order mu rho.
    const auto terms =
        static_cast<unsigned>(std::min(60.0 + 1.3 * mu, 1.1 * mu * rho + 20 + 20 / std::log(rho)));
    std::complex<double> sum = 0;
    for (unsigned m = 0; m < terms; ++m) {
        // h_m' = m / x h_m - h_(m + 1).
        const std::complex<double> slope = m / mu * hankel(m, mu) - hankel(m + 1, mu);
        sum += (2.0 * m + 1) * std::legendre(m, cosine) * hankel(m, mu * rho) / slope;
    }
    return 20 * std::log10(rho / mu * std::abs(sum));
}

}  // namespace aula::test
