#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/base/worker_pool.h"
#include "engine/waves/mode_columns.h"
#include "engine/waves/wave_grid.h"

namespace aula {

/// The modes of a room with rigid walls up to a frequency.
struct RoomModes {
    /// [mode] squared wave numbers in 1/m2, ascending, corrected for the dispersion of the grid. 0
    /// for the constant pressure of a closed room.
    std::vector<double> wave_number2;
    /// [cell][mode] pressures; the integral of the square over the room is 1. More columns than
    /// modes, from which a search begins after the room has changed.
    ModeColumns shapes{0, 0};
    double highest_wave_number = 0;  ///< 1/m; all modes below it were found
    double expected_count = 0;       ///< their number by Weyl's law with the term of the walls
    int passes = 0;                  ///< of the iteration
    double error = 0;  ///< estimated largest relative error of a frequency by the iteration

    std::size_t count() const { return wave_number2.size(); }
};

/// Weyl's number of modes below a wave number in 1/m in a room of a volume and a surface.
double weyl_count(double wave_number, double volume_m3, double surface_m2);

/// The wave number in 1/m with that number of modes below it.
double weyl_wave_number(double count, double volume_m3, double surface_m2);

/// The largest cell for modes up to a wave number: 6.5 cells in a wavelength.
double cell_for_wave_number_m(double wave_number);

/// The wave number up to which cells of that size suffice.
double wave_number_of_cell(double cell_m);

/// Nearly the modes of a grid, [cell][column], from which a search may begin: pressures of a room
/// that differs little.
struct NearModes {
    const ModeColumns& shapes;
    std::span<const std::optional<std::uint32_t>> cells;  ///< [cell] where the shapes have it
};

/// Computes the modes up to a wave number by subspace iteration with Chebyshev's polynomials (Zhou
/// and Saad 2007) and Rayleigh-Ritz projection. Lanczos' method with sparse factors of the inverse
/// takes several times as long, and cannot begin from the modes of a room that has changed. The
/// same bytes for any number of threads. A request to stop ends it after the present pass, with
/// what has been found.
RoomModes find_room_modes(const WaveGrid& grid, double highest_wave_number, WorkerPool& pool,
                          const std::optional<NearModes>& near = {},
                          const std::stop_token& stop = {});

}  // namespace aula
