#include "apps/bench/waves/waves.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "apps/bench/propagation/source_positions.h"
#include "engine/base/stopwatch.h"
#include "engine/waves/room_waves.h"

namespace aula::bench {

namespace {

constexpr int kReceivers = 8;

/// Of levels; single modes are about 1 Hz wide.
constexpr double kStep_hz = 0.1;

/// Where the octave of 63 Hz begins.
constexpr double kLowest_hz = 63 / std::numbers::sqrt2;

double energy(const WaveResponse& response, double wave_number) {
    const double distance_m{glm::length(response.from_source)};
    return std::norm(response.reverberant(wave_number)[0] +
                     direct_field(distance_m, wave_number)[0]);
}

/// The largest difference of the octave levels of two fields at the receivers, dB; empty if no
/// octave lies within the modes.
std::optional<double> largest_difference_db(const RoomWaves& waves, const RoomWaves& finer,
                                            const std::vector<Vec3>& receivers,
                                            const Vec3& source) {
    std::optional<double> largest;
    const double highest_hz = std::min(waves.highest_hz(), finer.highest_hz());
    for (const Vec3& receiver : receivers) {
        const std::optional<WaveResponse> response = waves.response(source, receiver);
        const std::optional<WaveResponse> other = finer.response(source, receiver);
        if (!response || !other) continue;
        for (double begin = kLowest_hz; 2 * begin < highest_hz; begin *= 2) {
            double sum = 0;
            double fine_sum = 0;
            for (double hz = begin; hz < 2 * begin; hz += kStep_hz) {
                sum += energy(*response, waves.wave_number_of(hz));
                fine_sum += energy(*other, waves.wave_number_of(hz));
            }
            largest = std::max(largest.value_or(0), std::abs(10 * std::log10(sum / fine_sum)));
        }
    }
    return largest;
}

Value number(std::optional<double> value) { return value ? Value(*value) : Value(); }

}  // namespace

std::vector<Row> measure_waves(const Subject& subject, const Settings& settings) {
    const Scene& scene = subject.scene;
    const Vec3 source = scene.sources[0].position_at(0);
    const std::vector<Vec3> places{source, scene.listener.pose_at(0).position};
    const double speed_m_s{scene.medium.speed_of_sound_m_s()};
    const auto rays = std::make_shared<const RayScene>(scene);
    WorkerPool pool(subject.threads);
    settings.progress("waves: modes");
    const std::optional<RoomWaves> waves =
        RoomWaves::find(rays, places, speed_m_s, WaveLimits{}, pool);
    Row row;
    row.figures = {{"bench", "waves"}, {"scene", subject.name}};
    if (!waves) {
        row.figures.emplace_back("field", "open, no modes");
        return {row};
    }
    settings.progress("waves: a finer grid");
    WaveLimits fine;
    fine.cells = 1.5;
    const std::optional<RoomWaves> finer = RoomWaves::find(rays, places, speed_m_s, fine, pool);
    std::vector<Vec3> receivers = source_positions(scene, kReceivers + 1);
    receivers.erase(receivers.begin());
    Stopwatch watch;
    for (const Vec3& receiver : receivers) waves->response(source, receiver);
    const double pair_ms = 1000 * watch.lap_s() / kReceivers;

    constexpr double kBytesInMb = 1e6;
    row.figures.insert(
        row.figures.end(),
        {{"field", "modes"},
         {"volume_m3", waves->volume_m3()},
         {"schroeder_hz", waves->schroeder_frequency_hz()},
         {"highest_hz", waves->highest_hz()},
         {"cells", static_cast<std::int64_t>(waves->grid().cells().cells())},
         {"modes", static_cast<std::int64_t>(waves->modes().count())},
         {"expected_modes", waves->modes().expected_count},
         {"memory_mb", static_cast<double>(waves->memory_bytes()) / kBytesInMb},
         {"grid_s", waves->times().grid_s},
         {"modes_s", waves->times().modes_s},
         {"poles_s", waves->times().poles_s},
         {"pair_ms", pair_ms},
         {"difference_db", number(finer ? largest_difference_db(*waves, *finer, receivers, source)
                                        : std::optional<double>())}});
    return {row};
}

const std::vector<Column>& waves_columns() {
    static const std::vector<Column> columns = columns_of(
        {"field", "volume_m3", "schroeder_hz", "highest_hz", "cells", "modes", "expected_modes",
         "memory_mb", "grid_s", "modes_s", "poles_s", "pair_ms", "difference_db"});
    return columns;
}

}  // namespace aula::bench
