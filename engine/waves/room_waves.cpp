#include "engine/waves/room_waves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "engine/base/stopwatch.h"
#include "engine/rays/room_survey.h"
#include "engine/waves/wall_damping.h"

namespace aula {

namespace {

/// Cells along the mean extent of the grid that measures volume and surface of the room: 2744
/// cells, a tenth to a third of those of the modes. An error of the volume by 1 % changes the
/// number of modes by as much.
constexpr float kMeasuringCells = 14;

/// The volumes of two rooms, the smaller over the larger, from which one's modes serve the search
/// for the other's. A room of half the volume, beyond a door, needs more passes than no modes.
constexpr double kNearVolume = 0.9;

/// The octaves 500 Hz and 1 kHz, whose reverberation gives Schroeder's frequency.
constexpr std::array<std::size_t, 2> kMiddleOctaves{3, 4};

/// Mean absorptions for Eyring's formula, which has no reverberation time for 0 and 1. With them
/// Schroeder's frequency is above and below all limits.
constexpr double kLeastAbsorption = 1e-4;
constexpr double kMostAbsorption = 0.99;  // as in the open

/// 24 ln(10) / c, of Sabine's formula, at 343 m/s.
constexpr double kSabine_s_per_m = 0.161;

/// Schroeder's frequency with Eyring's reverberation time, of the mean absorption in some octaves.
double schroeder_of(const WaveGrid& grid, const RayScene& scene,
                    std::span<const std::size_t> bands) {
    double absorbed_m2 = 0;
    for (const WaveGrid::WallPiece& piece : grid.walls) {
        for (const std::size_t band : bands) {
            const double alpha = piece.material == WaveGrid::kOpening
                                     ? 1
                                     : double{scene.material(piece.material).absorption[band]};
            absorbed_m2 += alpha * double{piece.area_m2} / static_cast<double>(bands.size());
        }
    }
    const double surface_m2 = grid.wall_m2();
    const double mean = std::clamp(absorbed_m2 / surface_m2, kLeastAbsorption, kMostAbsorption);
    const double time_s =
        kSabine_s_per_m * grid.total_volume_m3() / (surface_m2 * -std::log1p(-mean));
    return schroeder_frequency_hz(time_s, grid.total_volume_m3());
}

/// The frequency up to which each octave lies below a multiple of its own Schroeder frequency.
double limit_of_octaves_hz(const WaveGrid& grid, const RayScene& scene, double multiple) {
    double limit_hz = 0;
    for (std::size_t band = 0; band < kBandCount; ++band) {
        const double end_hz = double{kBandCentres_hz[band]} * std::numbers::sqrt2;
        const double of_band_hz =
            multiple * schroeder_of(grid, scene, std::array<std::size_t, 1>{band});
        limit_hz = std::max(limit_hz, std::min(of_band_hz, end_hz));
        if (of_band_hz < end_hz) break;
    }
    return limit_hz;
}

double open_share(const WaveGrid& grid) {
    double open_m2 = 0;
    for (const WaveGrid::WallPiece& piece : grid.walls) {
        if (piece.material == WaveGrid::kOpening) open_m2 += double{piece.area_m2};
    }
    return open_m2 / std::max(grid.wall_m2(), std::numeric_limits<double>::min());
}

/// A room, and a coarse grid of it.
struct Survey {
    Survey(const std::shared_ptr<const RayScene>& scene, std::span<const Vec3> places)
        : reached(room_extent(*scene, places)) {
        Bounds bounds;
        bounds.add(reached);
        const Vec3 extent = bounds.max - bounds.min;
        mean_m = static_cast<float>(std::cbrt(double{extent.x * extent.y * extent.z}));
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
                                         const WaveLimits& limits, WorkerPool& pool,
                                         const RoomWaves* before, const std::stop_token& stop) {
    Stopwatch watch;
    Survey survey(scene, places);
    if (survey.fault(limits.most_open) != RoomFault::none) return {};
    const WaveGrid& measured = survey.grid->cells();
    const double schroeder_hz = schroeder_of(measured, *scene, kMiddleOctaves);
    const double highest_hz =
        std::min(limits.highest_hz, limit_of_octaves_hz(measured, *scene, limits.schroeder));
    const double smallest_m = double{survey.mean_m} / std::cbrt(limits.most_cells);
    const double wave_number =
        std::min({weyl_wave_number(limits.modes, measured.total_volume_m3(), measured.wall_m2()),
                  2 * std::numbers::pi * highest_hz / speed_of_sound_m_s,
                  wave_number_of_cell(smallest_m * limits.cells)});
    if (wave_number * speed_of_sound_m_s < 2 * std::numbers::pi * limits.lowest_hz) return {};
    survey.grid.reset();
    RoomWaves waves(
        RoomGrid(scene, survey.reached, places,
                 static_cast<float>(cell_for_wave_number_m(wave_number) / limits.cells)),
        speed_of_sound_m_s);
    const WaveGrid& cells = waves.grid_.cells();
    if (cells.cells() == 0 || open_share(cells) > limits.most_open) return {};
    if (stop.stop_requested()) return {};
    waves.schroeder_frequency_hz_ = schroeder_hz;
    waves.times_.grid_s = watch.lap_s();
    std::vector<std::optional<std::uint32_t>> known;
    std::optional<NearModes> near;
    const auto is_near = [&](double a, double b) {
        return std::min(a, b) > kNearVolume * std::max(a, b);
    };
    if (before != nullptr && is_near(before->volume_m3(), waves.volume_m3())) {
        known = waves.grid_.cells_of(before->grid_);
        near.emplace(NearModes{before->modes_.shapes, known});
    }
    waves.modes_ = find_room_modes(cells, wave_number, pool, near, stop);
    // In a room of a few centimetres a single cell has the constant pressure alone.
    if (stop.stop_requested() || waves.highest_hz() < limits.lowest_hz) return {};
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
    const std::optional<ModeValues> from = modes_at(source);
    const std::optional<ModeValues> to = modes_at(receiver);
    if (!from || !to) return {};
    return wave_response(modes_, poles_, *from, *to);
}

std::optional<ModeValues> RoomWaves::modes_at(const Vec3& place) const {
    return aula::modes_at(grid_, modes_, place);
}

std::vector<std::complex<double>> RoomWaves::amplitudes(const Vec3& source, double hz) const {
    const std::optional<ModeValues> from = modes_at(source);
    if (!from) return {};
    const double wave_number = wave_number_of(hz);
    const std::complex<double> s(0, wave_number);
    std::vector<std::complex<double>> sum(modes_.count());
    for (const OctavePoles& octaves : poles_) {
        const double share = octave_share(octaves.begin, octaves.end, wave_number);
        if (share == 0) continue;
        for (const DampedPole& pole : octaves.poles) {
            std::complex<double> sent = 0;
            for (std::size_t m = 0; m < sum.size(); ++m) sent += pole.shape[m] * from->pressure[m];
            sent *= 4 * std::numbers::pi * share;
            const std::complex<double> upper = sent / (s - pole.pole);
            const std::complex<double> lower =
                pole.pole.imag() == 0 ? 0.0 : std::conj(sent) / (s - std::conj(pole.pole));
            for (std::size_t m = 0; m < sum.size(); ++m)
                sum[m] += pole.shape[m] * upper + std::conj(pole.shape[m]) * lower;
        }
    }
    return sum;
}

}  // namespace aula
