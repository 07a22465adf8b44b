#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "aula/engine/vec3.h"

namespace aula {

/// Finite volumes of the air of a room: cells, the faces between them and the walls that they
/// touch. With the matrices of Galerkin's method, sum over the faces of a cell of
/// conductance * (p_cell - p_other) = k^2 volume p_cell. Positions are in the axes of the grid.
struct WaveGrid {
    /// A face between two cells, seen from one of them.
    struct Link {
        std::uint32_t cell = 0;   ///< on the other side
        float conductance_m = 0;  ///< open area over the distance of the centres
        std::uint8_t axis = 0;
    };

    /// A part of a wall that a cell touches. The pressure at the wall is that of the cell plus
    /// `beyond` times the difference to the cell `inner`, on the side away from the wall.
    struct WallPiece {
        std::uint32_t cell = 0;
        std::uint32_t inner = 0;
        float beyond = 0;
        std::uint32_t material = 0;  ///< of the scene, or kOpening
        float area_m2 = 0;
    };

    /// The material of an opening to the world outside.
    static constexpr std::uint32_t kOpening = std::numeric_limits<std::uint32_t>::max();

    /// The neighbours on the lower and the higher side of each axis; the cell itself at a wall.
    using Neighbours = std::array<std::uint32_t, 6>;

    std::vector<float> volume_m3;           ///< [cell]
    std::vector<Vec3> centre_m;             ///< [cell]
    std::vector<Vec3> size_m;               ///< [cell]
    std::vector<char> is_whole;             ///< [cell] true: no wall cuts through it
    std::vector<std::uint32_t> first_link;  ///< [cell], and the number of links
    std::vector<Link> links;                ///< of each cell
    std::vector<Neighbours> across;         ///< [cell]
    std::vector<WallPiece> walls;           ///< sorted by cell

    std::size_t cells() const { return volume_m3.size(); }
    double total_volume_m3() const;
    double wall_m2() const;
};

}  // namespace aula
