#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// Receivers at equal distances along x and y, in a horizontal plane of a room or above a surface.
/// Cells are counted along x, then along y.
struct ReceiverGrid {
    float height_m = 0;   ///< z of the receivers; above a surface their mean
    std::string place;    ///< such as "height 1.2 m"
    float spacing_m = 0;  ///< distance of neighbours along x and y
    float x_m = 0;        ///< of the first column
    float y_m = 0;        ///< of the first row
    std::size_t columns = 0;
    std::size_t rows = 0;
    std::vector<Pose> receivers;     ///< in the room, by ascending cell, then by ascending z
    std::vector<std::size_t> cells;  ///< [receiver] column + columns * row
};

/// Distance in metres from the nearest surface that receivers of a grid keep.
inline constexpr float kGridClearance_m = 0.1F;

/// Largest number of pairs of a source and a receiver of a grid.
inline constexpr std::size_t kMaxGridPairs = 20'000;

/// The receivers of a grid that are in a room of the sources or the listener, which sound reaches
/// without passing walls, and at least kGridClearance_m from all surfaces. The grid is centred in
/// the bounds of the geometry. `rays` is the scene's at time 0. Throws InputError if the plane is
/// outside of the geometry, if no receiver is in the room, or if they are too many.
ReceiverGrid receiver_grid(const Scene& scene, const RayScene& rays, double height_m,
                           double spacing_m);

/// The receivers at `offset_m` above the faces of a material or an object, which need not be level:
/// raked seats, galleries. The way up to a receiver is free. A cell has a receiver for each such
/// face at its middle. All else is as for a plane. Throws InputError for an unknown `surface`, too.
ReceiverGrid surface_grid(const Scene& scene, const RayScene& rays, const std::string& surface,
                          double offset_m, double spacing_m);

}  // namespace aula
