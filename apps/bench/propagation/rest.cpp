#include "apps/bench/propagation/rest.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <thread>

#include "apps/bench/base/statistics.h"
#include "apps/bench/propagation/reference.h"
#include "aula/engine/propagation.h"

namespace aula::bench {

namespace {

constexpr double kRest_s = 10;

/// Frames that do not count in the cost of a frame: caches still grow.
constexpr int kFirstFrames = 15;

/// Frames of a trial of a number of rays. Of several trials the fastest counts, which other load
/// increases least.
constexpr int kTrialFrames = 2 * kFirstFrames;
constexpr int kTrials = 3;

/// The reference traces until its standard error is this share of the error measured.
constexpr double kRestReferenceShare = 0.3;
constexpr std::uint64_t kRestReferenceRound = 1 << 17;

struct AtRest {
    std::vector<double> energy;  ///< [bin] after the last frame
    double frame_cpu_s = 0;
};

AtRest rest(const Subject& subject, const FrameInput& input, int rays, int frames) {
    Propagation propagation(subject.scene, subject.comparable_simulation(Estimator::patch, rays));
    const int first = std::min(frames / 2, kFirstFrames);
    for (int k = 0; k < first; ++k) propagation.step(input);
    const int left = frames - first;
    const double began_s = cpu_time_s();
    for (int k = 0; k < left; ++k) propagation.step(input);
    return {estimated_energy(propagation.response(0)), (cpu_time_s() - began_s) / left};
}

double rms_error(const AtRest& at_rest, const std::vector<double>& reference, BinRange bins) {
    return std::sqrt(squared_relative_error(at_rest.energy, reference, bins) /
                     static_cast<double>(bins.count()));
}

}  // namespace

std::vector<Row> measure_rest(const Subject& subject, const Settings& settings) {
    const Simulation& simulation = subject.scene.simulation;
    const FrameInput input{
        0, {subject.scene.sources[0].position_at(0)}, {subject.scene.listener.pose_at(0).position}};
    const int rays =
        rays_for_cpu_time(settings.frame_ms / 1000, simulation.ray_count(), [&](int attempt) {
            settings.progress("rest: " + std::to_string(attempt) + " rays");
            double least_s = std::numeric_limits<double>::infinity();
            for (int k = 0; k < kTrials; ++k)
                least_s =
                    std::min(least_s, rest(subject, input, attempt, kTrialFrames).frame_cpu_s);
            return least_s;
        });
    const auto frames = static_cast<int>(std::lround(kRest_s * double{simulation.frame_rate_hz}));
    settings.progress("rest: 10 s with " + std::to_string(rays) + " rays");
    const AtRest at_rest = rest(subject, input, rays, frames);

    Reference reference(subject.scene, simulation, 0, input.sources[0], input.listeners,
                        at_rest.energy.size());
    WorkerPool workers(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
    const ReferenceLimit limit(settings);
    std::vector<double> wanted;
    BinRange bins;
    double error = 0;
    double reference_error = 0;
    do {
        settings.progress("rest: reference, " + std::to_string(reference.rays()) + " rays");
        reference.trace(kRestReferenceRound, workers);
        wanted = reference.response(0);
        bins = audible_bins(wanted);
        error = rms_error(at_rest, wanted, bins);
        reference_error = reference.relative_error(0, bins);
    } while (!has_converged(reference_error, kRestReferenceShare, error) &&
             !limit.reached(static_cast<double>(reference.rays())));

    Row row;
    row.figures = {{"bench", "rest"},
                   {"scene", subject.name},
                   {"basis", "cpu"},
                   {"estimator", estimator_name(Estimator::patch)},
                   {"rays", std::int64_t{rays}},
                   {"frames", std::int64_t{frames}},
                   {"frame_cpu_ms", at_rest.frame_cpu_s * 1000},
                   {"rest_error", without_reference_error(error, reference_error)},
                   {"energy_ratio", energy_ratio({at_rest.energy}, wanted, bins)},
                   {"reference_rays", static_cast<std::int64_t>(reference.rays())},
                   {"reference_error", reference_error}};
    return {row};
}

const std::vector<Column>& rest_columns() {
    static const std::vector<Column> columns =
        columns_of({"estimator", "rays", "frames", "frame_cpu_ms", "rest_error", "energy_ratio",
                    "reference_error"});
    return columns;
}

}  // namespace aula::bench
