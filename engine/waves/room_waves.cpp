#include "engine/waves/room_waves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/base/stopwatch.h"
#include "engine/rays/room_survey.h"
#include "engine/waves/wall_damping.h"

namespace aula {

namespace {

/// Cells along the mean extent of the grid that measures volume and surface of the room.
constexpr float kMeasuringCells = 14;

/// The octaves 500 Hz and 1 kHz, whose reverberation gives Schroeder's frequency.
constexpr std::array<std::size_t, 2> kMiddleOctaves{3, 4};

/// Schroeder's frequency with Eyring's reverberation time.
double schroeder_of(const WaveGrid& grid, const RayScene& scene) {
    double absorbed_m2 = 0;
    for (const WaveGrid::WallPiece& piece : grid.walls) {
        for (const std::size_t band : kMiddleOctaves) {
            const double alpha = piece.material == WaveGrid::kOpening
                                     ? 1
                                     : double{scene.material(piece.material).absorption[band]};
            absorbed_m2 += alpha * double{piece.area_m2} / kMiddleOctaves.size();
        }
    }
    const double surface_m2 = grid.wall_m2();
    const double mean = std::clamp(absorbed_m2 / surface_m2, 1e-4, 0.99);
    const double time_s = 0.161 * grid.total_volume_m3() / (surface_m2 * -std::log1p(-mean));
    return schroeder_frequency_hz(time_s, grid.total_volume_m3());
}

double open_share(const WaveGrid& grid) {
    double open_m2 = 0;
    for (const WaveGrid::WallPiece& piece : grid.walls) {
        if (piece.material == WaveGrid::kOpening) open_m2 += double{piece.area_m2};
    }
    return open_m2 / std::max(grid.wall_m2(), 1e-9);
}

/// A room, and a coarse grid of it.
struct Survey {
    Survey(const std::shared_ptr<const RayScene>& scene, std::span<const Vec3> places)
        : reached(room_extent(*scene, places)) {
        Bounds bounds;
        bounds.add(reached);
        const Vec3 extent = bounds.max - bounds.min;
        mean_m = std::cbrt(extent.x * extent.y * extent.z);
        if (mean_m > 0) grid.emplace(scene, reached, places, mean_m / kMeasuringCells);
    }

    RoomFault fault(double most_open) const {
        if (!grid || grid->cells().cells() == 0) return RoomFault::no_air;
        return open_share(grid->cells()) > most_open ? RoomFault::open : RoomFault::none;
    }

    std::vector<Vec3> reached;
    float mean_m = 0;
    std::optional<RoomGrid> grid;
};

}  // namespace

RoomFault RoomWaves::fault(const std::shared_ptr<const RayScene>& scene,
                           std::span<const Vec3> places, const WaveLimits& limits) {
    return Survey(scene, places).fault(limits.most_open);
}

std::optional<RoomWaves> RoomWaves::find(const std::shared_ptr<const RayScene>& scene,
                                         std::span<const Vec3> places, double speed_of_sound_m_s,
                                         const WaveLimits& limits, WorkerPool& pool) {
    Stopwatch watch;
    Survey survey(scene, places);
    if (survey.fault(limits.most_open) != RoomFault::none) return {};
    const WaveGrid& measured = survey.grid->cells();
    const double schroeder_hz = schroeder_of(measured, *scene);
    const double highest_hz = std::min(limits.highest_hz, limits.schroeder * schroeder_hz);
    const double smallest_m = double{survey.mean_m} / std::cbrt(limits.most_cells);
    const double wave_number =
        std::min({weyl_wave_number(limits.modes, measured.total_volume_m3(), measured.wall_m2()),
                  2 * std::numbers::pi * highest_hz / speed_of_sound_m_s,
                  wave_number_of_cell(smallest_m * limits.cells)});
    survey.grid.reset();
    RoomWaves waves(
        RoomGrid(scene, survey.reached, places,
                 static_cast<float>(cell_for_wave_number_m(wave_number) / limits.cells)),
        speed_of_sound_m_s);
    const WaveGrid& cells = waves.grid_.cells();
    if (cells.cells() == 0 || open_share(cells) > limits.most_open) return {};
    waves.schroeder_frequency_hz_ = schroeder_hz;
    waves.times_.grid_s = watch.lap_s();
    waves.modes_ = find_room_modes(cells, wave_number, pool);
    waves.times_.modes_s = watch.lap_s();
    waves.poles_ = room_poles(waves.modes_, WallDamping(cells, waves.modes_, pool), *scene,
                              speed_of_sound_m_s, pool);
    waves.times_.poles_s = watch.lap_s();
    return waves;
}

double RoomWaves::wave_number_of(double hz) const {
    return 2 * std::numbers::pi * hz / speed_of_sound_m_s_;
}

double RoomWaves::hz_of(double wave_number) const {
    return wave_number * speed_of_sound_m_s_ / (2 * std::numbers::pi);
}

std::size_t RoomWaves::memory_bytes() const {
    std::size_t bytes = grid_.memory_bytes();
    bytes += modes_.shapes.cells() * modes_.shapes.columns() * sizeof(float);
    for (const OctavePoles& octaves : poles_) {
        for (const DampedPole& pole : octaves.poles) {
            bytes += pole.shape.size() * sizeof pole.shape[0];
        }
    }
    return bytes;
}

std::optional<WaveResponse> RoomWaves::response(const Vec3& source, const Vec3& receiver) const {
    const std::optional<ModeValues> from = modes_at(grid_, modes_, source);
    const std::optional<ModeValues> to = modes_at(grid_, modes_, receiver);
    if (!from || !to) return {};
    return wave_response(modes_, poles_, *from, *to);
}

}  // namespace aula
