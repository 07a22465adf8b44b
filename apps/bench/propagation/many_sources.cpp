#include "apps/bench/propagation/many_sources.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <thread>
#include <utility>

#include "apps/bench/base/statistics.h"
#include "apps/bench/propagation/reference.h"
#include "apps/bench/propagation/source_positions.h"
#include "aula/engine/propagation.h"
#include "aula/exception.h"
#include "engine/base/sampling.h"

namespace aula::bench {

namespace {

constexpr int kFrames = 120;
constexpr std::uint64_t kManyReferenceRound = 1 << 16;

/// Sources that walk are on circles, which are within the free space of source_positions().
constexpr double kWalkingSpeed_m_s = 1.5;
constexpr double kCircleRadius_m = 0.1;

enum class Walking { nothing, listener, all };

/// The position at a time of a source that walks around a place.
Vec3 on_circle(const Vec3& place, double time_s) {
    const double angle_rad = kWalkingSpeed_m_s * time_s / kCircleRadius_m;
    return place + Vec3(kCircleRadius_m * std::sin(angle_rad),
                        kCircleRadius_m * (1 - std::cos(angle_rad)), 0);
}

/// Cost of the frames of a number of sources, and their last responses.
struct Outcome {
    double frame_cpu_s = 0;
    std::vector<std::vector<double>> energy;  // [source][bin] after the last frame
    FrameInput last;
};

Outcome follow_sources(const Subject& subject, const std::vector<Vec3>& sources, Walking walking) {
    Scene scene = subject.scene;
    scene.sources.assign(sources.size(), scene.sources[0]);
    for (std::size_t s = 0; s < sources.size(); ++s) {
        scene.sources[s].position = sources[s];
        scene.sources[s].path.reset();
    }
    Propagation propagation(
        scene, subject.comparable_simulation(Estimator::patch, scene.simulation.ray_count()));
    FrameInput input{0, sources, {scene.listener.pose_at(0).position}};
    const double began_s = cpu_time_s();
    for (int f = 0; f < kFrames; ++f) {
        const double time_s = f / double{scene.simulation.frame_rate_hz};
        if (walking != Walking::nothing)
            input.listeners[0] = scene.listener.pose_at(time_s).position;
        for (std::size_t i = 0; walking == Walking::all && i < sources.size(); ++i)
            input.sources[i] = on_circle(sources[i], time_s);
        propagation.step(input);
    }
    Outcome outcome{(cpu_time_s() - began_s) / kFrames, {}, input};
    for (std::size_t s = 0; s < sources.size(); ++s) {
        outcome.energy.push_back(estimated_energy(propagation.response(s)));
    }
    return outcome;
}

/// Rms relative error over all sources. By reciprocity one reference, traced from the listener,
/// serves all of them.
double error_of(const Subject& subject, const Outcome& outcome, const Settings& settings) {
    const std::vector<Vec3>& sources = outcome.last.sources;
    Reference reference(subject.scene, subject.scene.simulation, 0, outcome.last.listeners[0],
                        sources, outcome.energy[0].size());
    WorkerPool workers(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
    const ReferenceLimit limit(settings);
    do {
        settings.progress("sources: reference, " + std::to_string(reference.rays()) + " rays");
        reference.trace(kManyReferenceRound, workers);
    } while (!limit.reached(static_cast<double>(reference.rays())));
    double squares = 0;
    double own_squares = 0;
    std::size_t count = 0;
    for (std::size_t s = 0; s < sources.size(); ++s) {
        const std::vector<double> wanted = reference.response(s);
        const BinRange bins = bins_from_peak(wanted);
        squares += squared_relative_error(outcome.energy[s], wanted, bins);
        own_squares +=
            std::pow(reference.relative_error(s, bins), 2) * static_cast<double>(bins.count());
        count += bins.count();
    }
    const auto bins = static_cast<double>(count);
    return without_reference_error(std::sqrt(squares / bins), std::sqrt(own_squares / bins));
}

}  // namespace

std::vector<Row> measure_many_sources(const Subject& subject, const Settings& settings) {
    if (!subject.scene.listener.path) {
        throw InputError(subject.name, "/listener", "has no path; expected a listener with a path");
    }
    std::vector<Row> rows;
    for (const auto& [walking, name] :
         {std::pair{Walking::nothing, "none"}, std::pair{Walking::listener, "listener"},
          std::pair{Walking::all, "all"}}) {
        double one_s = 0;
        for (const int count : {1, settings.sources}) {
            const std::vector<Vec3> sources = source_positions(subject.scene, count);
            settings.progress("sources: " + std::to_string(count));
            const Outcome outcome = follow_sources(subject, sources, walking);
            if (count == 1) one_s = outcome.frame_cpu_s;
            Row row;
            row.figures = {{"bench", "sources"},
                           {"scene", subject.name},
                           {"mover", name},
                           {"sources", static_cast<std::int64_t>(sources.size())},
                           {"rays", std::int64_t{subject.scene.simulation.ray_count()}},
                           {"frame_cpu_ms", outcome.frame_cpu_s * 1000},
                           {"cost_to_one", outcome.frame_cpu_s / one_s},
                           {"tracking_error", walking == Walking::nothing
                                                  ? Value{}
                                                  : Value{error_of(subject, outcome, settings)}}};
            rows.push_back(row);
        }
    }
    return rows;
}

const std::vector<Column>& many_sources_columns() {
    static const std::vector<Column> columns =
        columns_of({"mover", "sources", "rays", "frame_cpu_ms", "cost_to_one", "tracking_error"});
    return columns;
}

}  // namespace aula::bench
