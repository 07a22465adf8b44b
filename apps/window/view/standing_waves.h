#pragma once

#include <vector>

#include "apps/room/waves/wave_join.h"
#include "apps/window/view/map_cells.h"
#include "aula/engine/scene.h"
#include "engine/waves/mode_values.h"

namespace aula {

/// The standing waves of a room at a height, for the picture: levels of the field of a source that
/// plays one frequency. Immutable.
class StandingWaves {
 public:
    /// Finds the modes of the rooms of the scene's sources at the time 0; takes seconds. Within
    /// `bounds`.
    StandingWaves(const Scene& scene, const Bounds& bounds, double height_m);

    double height_m() const { return height_m_; }
    /// The highest frequency; 0: no modes.
    double highest_hz() const;
    /// Why sources have no modes.
    const std::vector<std::string>& warnings() const { return join_.warnings(); }

    /// The levels of the pressure in dB re that at 10 m in free field, as the strength G; cells
    /// beyond the air of the room are omitted. Empty for a source in no room with modes.
    MapCells cells(const Vec3& source, double hz) const;

 private:
    struct Point {
        const RoomWaves* room;
        MapCells::Cell cell;
        std::vector<double> pressure;  ///< [mode]
    };

    double height_m_;
    WaveJoin join_;
    std::vector<Point> points_;
};

}  // namespace aula
