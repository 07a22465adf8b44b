#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/base/worker_pool.h"
#include "engine/rays/ray_scene.h"
#include "engine/waves/mode_values.h"
#include "engine/waves/room_grid.h"
#include "engine/waves/room_modes.h"
#include "engine/waves/wall_damping.h"
#include "engine/waves/wave_response.h"

namespace aula {

/// How far the modes of a room are computed.
struct WaveLimits {
    /// About that number at most. A choice: the time grows with its third power, and is 0.2 to 0.5
    /// s in the rooms of `aula-bench waves`.
    double modes = 180;
    /// At most. A choice: so many modes end there in a room of 10 m3.
    double highest_hz = 500;
    /// No modes if they end below it: the lowest frequency that is heard.
    double lowest_hz = 20;
    /// At most that multiple of each octave's Schroeder frequency, half an octave above the
    /// crossover (docs/modes.md), which thus lies at Schroeder's frequency.
    double schroeder = 1.5;
    /// Multiple of the cells along an axis that suffice.
    double cells = 1;
    /// Within the bounds of the room. A choice: 0.1 GB while it is cut.
    double most_cells = 1 << 17;
    /// Share of openings in the surface, above which there are no modes. A choice: a door of 2 m2
    /// in a room of 40 m2 of surface.
    double most_open = 0.05;
};

/// Why places have no modes.
enum class RoomFault {
    none,
    no_air,  ///< they are in a solid, or in a space without extent
    open,    ///< more of the surface than WaveLimits::most_open
};

/// The sound field of a room at low frequencies: its modes, damped by its walls. The room is the
/// air that is connected with given places, with all objects at their present positions. Immutable.
class RoomWaves {
 public:
    /// Empty if the room has a fault, or if its modes end below WaveLimits::lowest_hz: it is flat
    /// or large, or absorbs much; or after a request to stop, which takes some tenths of a second.
    /// The room as it was `before` a small change, if it is given, halves the time. The same bytes
    /// for any number of threads.
    static std::optional<RoomWaves> find(const std::shared_ptr<const RayScene>& scene,
                                         std::span<const Vec3> places, double speed_of_sound_m_s,
                                         const WaveLimits& limits, WorkerPool& pool,
                                         const RoomWaves* before = nullptr,
                                         const std::stop_token& stop = {});

    /// Of the room of the places, by a coarse grid.
    static RoomFault fault(const std::shared_ptr<const RayScene>& scene,
                           std::span<const Vec3> places, const WaveLimits& limits);

    const RoomGrid& grid() const { return grid_; }
    const RoomModes& modes() const { return modes_; }
    std::span<const OctavePoles> poles() const { return poles_; }
    double volume_m3() const { return grid_.cells().total_volume_m3(); }
    /// Of the mean absorption at 500 Hz and 1 kHz, by Eyring.
    double schroeder_frequency_hz() const { return schroeder_frequency_hz_; }
    double highest_hz() const { return hz_of(modes_.highest_wave_number); }
    double wave_number_of(double hz) const;
    double hz_of(double wave_number) const;
    std::size_t memory_bytes() const;

    /// Elapsed time of the parts, s.
    struct Times {
        double grid_s = 0;
        double modes_s = 0;
        double poles_s = 0;
    };
    const Times& times() const { return times_; }

    /// Empty at places outside the air of the room.
    std::optional<WaveResponse> response(const Vec3& source, const Vec3& receiver) const;

    /// The modes at a place; empty outside the air of the room.
    std::optional<ModeValues> modes_at(const Vec3& place) const;

    /// The amplitudes of the modes with a source of amplitude 1 at 1 m in free field, at a
    /// frequency up to highest_hz(): the pressure at a place is the sum of their products with its
    /// modes. Empty outside the air of the room.
    std::vector<std::complex<double>> amplitudes(const Vec3& source, double hz) const;

 private:
    RoomWaves(RoomGrid grid, double speed_of_sound_m_s)
        : grid_(std::move(grid)), speed_of_sound_m_s_(speed_of_sound_m_s) {}

    RoomGrid grid_;
    RoomModes modes_;
    std::vector<OctavePoles> poles_;
    double speed_of_sound_m_s_;
    double schroeder_frequency_hz_ = 0;
    Times times_;
};

}  // namespace aula
