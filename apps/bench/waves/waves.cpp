#include "apps/bench/waves/waves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "apps/bench/propagation/source_positions.h"
#include "apps/room/waves/frame_waves.h"
#include "apps/room/waves/wave_join.h"
#include "apps/room/waves/wave_synthesis.h"
#include "aula/engine/impulse_response.h"
#include "aula/engine/propagation.h"
#include "aula/measurement.h"
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
                     direct_field(distance_m, {0, wave_number})[0]);
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

/// Why a scene has no modes.
std::string fault_of(const Scene& scene, std::span<const Vec3> places) {
    switch (RoomWaves::fault(std::make_shared<const RayScene>(scene), places, WaveLimits{})) {
        case RoomFault::open:
            return "open, no modes";
        case RoomFault::no_air:
            return "no air, no modes";
        case RoomFault::none:
            break;
    }
    return "low, no modes";
}

/// Time in ms that modes add to a response of the scene's first source.
double frame_ms(const Scene& scene, const WaveJoin& join, std::span<const Vec3> receivers) {
    constexpr double kRate_hz = 48000;
    const Propagation propagation(scene, scene.simulation);
    const EnergyResponse& rays = propagation.response(0);
    ImpulseResponseBuilder builder(make_noise_carriers(kRate_hz, 1), scene.medium,
                                   propagation.response_length_s(), scene.sources[0].name, 1);
    WaveSynthesis synthesis(kRate_hz, builder.length_samples());
    ImpulseResponse response;
    const auto build = [&](const std::optional<PairWaves>& modes) {
        synthesis.build(
            builder, rays, modes, [](const SoundPath&) { return 0.0; }, response);
    };
    const auto time_of = [&](bool with_modes) {
        Stopwatch watch;
        for (const Vec3& receiver : receivers) {
            std::optional<PairWaves> modes;
            if (with_modes) modes = join.pair(scene.sources[0].position_at(0), receiver, rays);
            build(modes);
        }
        return 1000 * watch.lap_s() / static_cast<double>(receivers.size());
    };
    time_of(true);  // allocates
    return time_of(true) - time_of(false);
}

/// The longest time in s that modes take to follow the objects that move, at intervals of 0.15 s
/// for 10 s; empty if none does.
std::optional<double> moved_s(Scene scene, int threads) {
    constexpr double kInterval_s = 0.15;
    constexpr int kIntervals = 66;
    if (std::none_of(scene.objects.begin(), scene.objects.end(),
                     [](const Object& object) { return object.moves(); }))
        return {};
    scene.simulation.threads = threads;
    const std::array<Vec3, 1> source{scene.sources[0].position_at(0)};
    FrameWaves waves(scene, WavesReady::at_once);
    waves.begin_frame(0, source, {});
    double longest_s = 0;
    for (int i = 1; i < kIntervals; ++i) {
        Stopwatch watch;
        waves.begin_frame(i * kInterval_s, source, {});
        longest_s = std::max(longest_s, watch.lap_s());
    }
    return longest_s;
}

/// The level of the modes over that of rays, mean of the energies at the receivers, in the highest
/// octave that modes fill; empty if there is none.
std::optional<double> over_rays_db(const Scene& scene, const WaveJoin& join,
                                   std::span<const Vec3> receivers) {
    MeasurementOptions options;
    options.frames = 16;
    options.parameters = false;
    std::vector<Pose> poses(receivers.size());
    for (std::size_t r = 0; r < poses.size(); ++r) poses[r].position = receivers[r];
    Scene of_rays = scene;
    of_rays.simulation.waves_hz = 0;
    const auto measured = measure(of_rays, std::span(scene.sources).first(1), poses, options);
    std::optional<std::size_t> band;
    double of_modes = 0;
    double of_all = 0;
    for (std::size_t r = 0; measured && r < poses.size(); ++r) {
        const EnergyResponse& rays = measured->responses[r];
        const auto modes = join.pair(scene.sources[0].position_at(0), receivers[r], rays);
        if (!modes) continue;
        const WaveEnergy energy = modes->energy(rays.bins);
        for (std::size_t b = 0; b < kBandCount && !band; ++b) {
            // Less than a tenth remains of the rays.
            if (energy.rays[b] < 0.1F && !(b + 1 < kBandCount && energy.rays[b + 1] < 0.1F))
                band = b;
        }
        if (!band) return {};
        EnergyResponse joined = rays;
        energy.join(joined);
        of_modes += joined.total(*band);
        of_all += rays.total(*band);
    }
    if (!(of_all > 0)) return {};
    return 10 * std::log10(of_modes / of_all);
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
        row.figures.emplace_back("field", fault_of(scene, places));
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

    const WaveJoin join(scene);

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
         {"moved_s", number(moved_s(scene, subject.threads))},
         {"pair_ms", pair_ms},
         {"frame_ms", frame_ms(scene, join, receivers)},
         {"over_rays_db", number(over_rays_db(scene, join, receivers))},
         {"difference_db", number(finer ? largest_difference_db(*waves, *finer, receivers, source)
                                        : std::optional<double>())}});
    return {row};
}

const std::vector<Column>& waves_columns() {
    static const std::vector<Column> columns =
        columns_of({"field", "volume_m3", "schroeder_hz", "highest_hz", "cells", "modes",
                    "expected_modes", "memory_mb", "grid_s", "modes_s", "poles_s", "moved_s",
                    "pair_ms", "frame_ms", "over_rays_db", "difference_db"});
    return columns;
}

}  // namespace aula::bench
