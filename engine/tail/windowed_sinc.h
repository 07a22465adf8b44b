#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>

namespace aula {

/// Weight of the sample at a distance of x samples in an interpolation with `taps` samples:
/// sin(pi x) / (pi x) with Kaiser's window of the parameter `shape`.
inline double windowed_sinc(double x, std::size_t taps, double shape) {
    const auto bessel_i0 = [](double y) {
        double term = 1;
        double sum = 1;
        for (int k = 1; term > 1e-12 * sum; ++k) {
            term *= y * y / (4.0 * k * k);
            sum += term;
        }
        return sum;
    };
    const double width = 2 * x / static_cast<double>(taps);
    if (std::abs(width) >= 1) return 0;
    const double angle = std::numbers::pi * x;
    return (angle == 0 ? 1 : std::sin(angle) / angle) *
           bessel_i0(shape * std::sqrt(1 - width * width)) / bessel_i0(shape);
}

}  // namespace aula
