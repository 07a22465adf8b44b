#pragma once

#include <array>
#include <complex>
#include <vector>

#include "aula/engine/vec3.h"

namespace aula::test {

/// A box from the origin with a real specific admittance of each wall: those at 0 and at the far
/// end of each axis.
struct DampedBox {
    Vec3 size{1};
    std::array<std::array<double, 2>, 3> admittance{};
};

/// The exact transfer functions from a source, with amplitude 1 at 1 m in free field, to receivers,
/// [receiver][wave number in 1/m]: Green's function in closed form along x, a series of damped
/// modes along y and z up to `highest`. Receivers have another x than the source. Within 0.01 dB if
/// `highest` is three times the largest wave number.
std::vector<std::vector<std::complex<double>>> exact_box(const DampedBox& box, const Vec3& source,
                                                         const std::vector<Vec3>& receivers,
                                                         const std::vector<double>& wave_numbers,
                                                         double highest);

/// The exact pole, s = j k in 1/m, of the mode with these orders along the axes.
std::complex<double> exact_pole(const DampedBox& box, const std::array<int, 3>& order);

}  // namespace aula::test
