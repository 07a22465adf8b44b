#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace aula::test {

using Direction = std::array<float, 3>;

/// Uniformly distributed directions: a Fibonacci lattice.
inline std::vector<Direction> uniform_directions(std::size_t count) {
    std::vector<Direction> directions;
    for (std::size_t i = 0; i < count; ++i) {
        const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(count);
        const double azimuth = std::numbers::pi * (3 - std::sqrt(5.0)) * static_cast<double>(i);
        const double radius = std::sqrt(1 - z * z);
        directions.push_back({static_cast<float>(radius * std::cos(azimuth)),
                              static_cast<float>(radius * std::sin(azimuth)),
                              static_cast<float>(z)});
    }
    return directions;
}

}  // namespace aula::test
