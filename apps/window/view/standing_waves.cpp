#include "apps/window/view/standing_waves.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>

namespace aula {

namespace {

/// Cells of a picture, so that it follows a slider, and their smallest size.
constexpr double kMostCells = 4000;
constexpr double kSmallest_m = 0.05;

/// The range of the colours below the loudest cell, dB.
constexpr double kWaveRange_db = 30;

/// The level of the amplitude 1 at 1 m re that at 10 m in free field, dB.
constexpr double kStrengthAt1m_db = 20;

/// Modes at all frequencies that there are.
Scene with_all_modes(Scene scene) {
    scene.simulation.waves_hz = Simulation::kHighestWaves_hz;
    return scene;
}

}  // namespace

StandingWaves::StandingWaves(const Scene& scene, const Bounds& bounds, double height_m)
    : height_m_(height_m), join_(with_all_modes(scene)) {
    if (join_.rooms().empty()) return;
    const Vec3 size = bounds.max - bounds.min;
    const double area_m2 = double{size.x} * double{size.y};
    const auto step = static_cast<float>(std::max(kSmallest_m, std::sqrt(area_m2 / kMostCells)));
    const auto columns = static_cast<int>(std::ceil(size.x / step));
    const auto rows = static_cast<int>(std::ceil(size.y / step));
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const glm::vec2 low(bounds.min.x + step * static_cast<float>(column),
                                bounds.min.y + step * static_cast<float>(row));
            const Vec3 centre(low.x + step / 2, low.y + step / 2, height_m);
            const RoomWaves* const room = join_.room_at(centre);
            if (room == nullptr) continue;
            if (const auto modes = room->modes_at(centre))
                points_.push_back({room, {low, low + step, std::nullopt}, modes->pressure});
        }
    }
}

double StandingWaves::highest_hz() const {
    double highest_hz = 0;
    for (const RoomWaves& room : join_.rooms())
        highest_hz = std::max(highest_hz, room.highest_hz());
    return highest_hz;
}

MapCells StandingWaves::cells(const Vec3& source, double hz) const {
    std::vector<MapCells::Cell> cells;
    ValueScale scale;
    const RoomWaves* const room = join_.room_at(source);
    if (room == nullptr) return {cells, scale, static_cast<float>(height_m_)};
    const std::vector<std::complex<double>> amplitudes =
        room->amplitudes(source, std::min(hz, room->highest_hz()));
    std::optional<double> loudest_db;
    for (const Point& point : points_) {
        if (point.room != room) continue;
        std::complex<double> pressure = 0;
        for (std::size_t m = 0; m < amplitudes.size(); ++m)
            pressure += amplitudes[m] * point.pressure[m];
        MapCells::Cell& cell = cells.emplace_back(point.cell);
        cell.value = 10 * std::log10(std::norm(pressure) + 1e-12) + kStrengthAt1m_db;
        loudest_db = std::max(loudest_db.value_or(*cell.value), *cell.value);
    }
    if (loudest_db) scale = {*loudest_db - kWaveRange_db, *loudest_db};
    return {cells, scale, static_cast<float>(height_m_)};
}

}  // namespace aula
