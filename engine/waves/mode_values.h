#pragma once

#include <array>
#include <optional>
#include <vector>

#include "engine/waves/room_grid.h"
#include "engine/waves/room_modes.h"

namespace aula {

/// The modes at a place.
struct ModeValues {
    Vec3 place{0};                             ///< world coordinates
    std::vector<double> pressure;              ///< [mode]
    std::vector<std::array<double, 3>> slope;  ///< [mode] gradient in 1/m, world axes
};

/// The modes at a place in world coordinates, interpolated by polynomials of third degree between
/// cells, which walls mirror. Empty where there is no air of the grid.
std::optional<ModeValues> modes_at(const RoomGrid& grid, const RoomModes& modes, const Vec3& place);

}  // namespace aula
