#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

/// Vectors in head axes: x front, y left, z up. Of length 1 but for distinct_directions().
using Directions = std::vector<std::array<float, 3>>;

/// The indices of positions, in their order, without those whose direction is also given at a
/// larger distance, or earlier at the same one. No position is the origin.
std::vector<std::size_t> distinct_directions(const Directions& positions);

/// Up to four measured directions and their weights, whose sum is 1.
struct InterpolationWeights {
    static constexpr std::size_t kMost = 4;

    std::size_t count = 0;
    std::array<std::size_t, kMost> index{};
    std::array<float, kMost> weight{};
};

/// The weights of measured directions for a unit direction. There are at least four directions.
InterpolationWeights interpolation_weights(
    const Directions& directions, const std::array<float, 3>& direction) noexcept AULA_NONBLOCKING;

/// The quadrature weight of each direction: the share of the sphere nearest to it (its Voronoi
/// cell). Their sum is 1.
std::vector<double> quadrature_weights(const Directions& directions);

/// A direction without a measurement near it, and the shares of measured ones in its responses.
struct ClosingDirection {
    std::array<float, 3> direction{};
    std::vector<std::pair<std::size_t, double>> shares;  ///< index, weight; sum 1
};

/// Directions that close the gaps of a measured set, such as that below the lowest measured
/// elevation. A set that covers the sphere has none. `weights` are the quadrature weights.
///
/// Interaural differences depend mainly on the angle to the axis through the ears: they are nearly
/// constant on a cone around it, the cone of confusion. The responses of a closing direction are
/// those at the ends of the gap on its cone, weighted linearly by the angles to them.
std::vector<ClosingDirection> closing_directions(const Directions& directions,
                                                 const std::vector<double>& weights);

}  // namespace aula
