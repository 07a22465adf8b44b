#include "apps/bench/noise.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "apps/bench/reference.h"
#include "apps/bench/statistics.h"
#include "engine/propagation.h"
#include "engine/sampling.h"

namespace aula::bench {

namespace {

/// The reference goes on until the mean ratio's standard error from it is below this.
constexpr double kReferenceError = 0.002;
constexpr std::uint64_t kReferenceRound = 1 << 17;

/// Restarts that the cost of a frame is taken from when rays are matched to CPU time.
constexpr int kCostRestarts = 4;

/// What an estimator published after each restart.
struct Restarts {
    std::vector<std::vector<double>> energy;   // [restart][bin]
    std::vector<std::vector<Vec3>> direction;  // [restart][group]
    double frame_s = 0;
    double frame_cpu_s = 0;
    double memory_bytes = 0;
    std::size_t cache_entries = 0;
};

Restarts run(const Subject& subject, Estimator estimator, int rays, int restarts,
             const Settings& settings) {
    const Simulation simulation = subject.simulation(estimator, rays);
    Propagation propagation(subject.scene, simulation);
    const FrameInput input{
        0, {subject.scene.sources[0].position_at(0)}, {subject.scene.listener.pose_at(0).position}};
    const int frames = estimator == Estimator::pt ? 1 : subject.frames;
    Restarts result;
    for (int i = 0; i < restarts; ++i) {
        settings.progress(std::string("noise: ") + estimator_name(estimator) + ", " +
                          std::to_string(rays) + " rays, restart " + std::to_string(i + 1));
        propagation.restart(derive_seed(simulation.seed, i));
        const auto began = std::chrono::steady_clock::now();
        const double cpu_began_s = cpu_time_s();
        for (int frame = 0; frame < frames; ++frame) propagation.step(input);
        result.frame_cpu_s += (cpu_time_s() - cpu_began_s) / frames / restarts;
        result.frame_s +=
            std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count() /
            frames / restarts;
        result.memory_bytes = std::max(result.memory_bytes,
                                       static_cast<double>(propagation.statistics().memory_bytes));
        result.cache_entries =
            std::max(result.cache_entries, propagation.statistics().cache_entries);
        result.energy.push_back(estimated_energy(propagation.response(0)));
        result.direction.push_back(estimated_direction(propagation.response(0)));
    }
    return result;
}

/// Relative standard error of the mean ratio that comes from the reference.
double ratio_error(const Reference& reference, BinRange bins) {
    double squares = 0;
    int groups = 0;
    for (std::size_t b = bins.first; b + kGroupBins <= bins.end; b += kGroupBins, ++groups) {
        const Reference::Estimate group = reference.energy(0, {b, b + kGroupBins});
        squares += std::pow(group.standard_error / group.mean, 2);
    }
    return groups > 0 ? std::sqrt(squares) / groups : 0;
}

/// Standard error of the mean ratio that comes from the estimator.
double ratio_error(const Restarts& restarts, const std::vector<double>& reference, BinRange bins) {
    std::vector<double> ratios;
    double mean = 0;
    const auto n = static_cast<double>(restarts.energy.size());
    for (const std::vector<double>& energy : restarts.energy) {
        ratios.push_back(energy_ratio({energy}, reference, bins));
        mean += ratios.back() / n;
    }
    double squares = 0;
    for (const double ratio : ratios) squares += (ratio - mean) * (ratio - mean);
    return std::sqrt(squares / (n - 1) / n);
}

}  // namespace

std::vector<Row> measure_noise(const Subject& subject, const Settings& settings) {
    const Vec3 listener = subject.scene.listener.pose_at(0).position;
    const int scene_rays = subject.scene.simulation.rays;

    // Run every estimator at equal rays, then at equal CPU time.
    struct Run {
        const char* basis;
        Estimator estimator;
        int rays;
        Restarts restarts;
    };
    std::vector<Run> runs;
    double budget_s = 0;
    for (const Estimator estimator : settings.estimators) {
        runs.push_back({"rays", estimator, scene_rays,
                        run(subject, estimator, scene_rays, settings.restarts, settings)});
        if (estimator == Estimator::patch) budget_s = runs.back().restarts.frame_cpu_s;
    }
    if (budget_s == 0) {
        budget_s = run(subject, Estimator::patch, scene_rays, kCostRestarts, settings).frame_cpu_s;
    }
    for (std::size_t i = 0; i < settings.estimators.size(); ++i) {
        runs.push_back(runs[i]);
        Run& r = runs.back();
        r.basis = "cpu";
        if (r.estimator == Estimator::patch) continue;
        r.rays = rays_for_cpu_time(budget_s, r.rays, [&](int rays) {
            return run(subject, r.estimator, rays, kCostRestarts, settings).frame_cpu_s;
        });
        r.restarts = run(subject, r.estimator, r.rays, settings.restarts, settings);
    }

    // Converge the reference.
    const std::size_t bin_count = runs.front().restarts.energy.front().size();
    const BinRange bins = late_bins(bin_count);
    Reference reference(subject.scene, subject.scene.simulation, 0,
                        subject.scene.sources[0].position_at(0), {listener}, bin_count);
    WorkerPool workers(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
    do {
        settings.progress("noise: reference, " + std::to_string(reference.rays()) + " rays");
        reference.trace(kReferenceRound, workers);
    } while (ratio_error(reference, bins) > kReferenceError &&
             static_cast<double>(reference.rays()) < settings.reference_rays);
    const std::vector<double> wanted = reference.response(0);

    std::vector<Row> rows;
    std::vector<double> pt_noise;
    for (const Run& r : runs) {
        const double noise = relative_deviation(r.restarts.energy, bins);
        // Plain path tracing comes first on each basis, if at all.
        if (r.estimator == Estimator::pt) pt_noise.push_back(noise);
        const Simulation& s = subject.scene.simulation;
        Row row;
        row.figures = {{"bench", "noise"},
                       {"scene", subject.name},
                       {"basis", r.basis},
                       {"estimator", estimator_name(r.estimator)},
                       {"rays", std::int64_t{r.rays}},
                       {"order", std::int64_t{s.order}},
                       {"tau_s", double{s.response_time_s}},
                       {"frames", std::int64_t{r.estimator == Estimator::pt ? 1 : subject.frames}},
                       {"position", std::array<double, 3>{double{listener.x}, double{listener.y},
                                                          double{listener.z}}},
                       {"frame_ms", r.restarts.frame_s * 1000},
                       {"frame_cpu_ms", r.restarts.frame_cpu_s * 1000},
                       {"noise", noise},
                       {"noise_to_pt", pt_noise.empty() ? Value{} : Value{noise / pt_noise.back()}},
                       {"direction_noise_deg", direction_deviation_deg(r.restarts.direction, bins)},
                       {"energy_ratio", energy_ratio(r.restarts.energy, wanted, bins)},
                       {"energy_ratio_error", std::hypot(ratio_error(reference, bins),
                                                         ratio_error(r.restarts, wanted, bins))},
                       {"memory_mb", r.restarts.memory_bytes / 1e6},
                       {"cache_entries", static_cast<std::int64_t>(r.restarts.cache_entries)},
                       {"patch_size_m", double{s.patch_size_m}},
                       {"restarts", std::int64_t{settings.restarts}},
                       {"reference_rays", static_cast<std::int64_t>(reference.rays())},
                       {"reference_error", ratio_error(reference, bins)}};
        rows.push_back(row);
    }
    return rows;
}

const std::vector<Column>& noise_columns() {
    static const std::vector<Column> columns{{"basis", "basis", 0},
                                             {"estimator", "estimator", 0},
                                             {"rays", "rays", 0},
                                             {"frames", "frames", 0},
                                             {"frame_ms", "frame ms", 2},
                                             {"frame_cpu_ms", "CPU ms", 2},
                                             {"noise", "noise", 4},
                                             {"noise_to_pt", "/ pt", 3},
                                             {"direction_noise_deg", "direction deg", 2},
                                             {"energy_ratio", "energy ratio", 4},
                                             {"energy_ratio_error", "+-", 4},
                                             {"cache_entries", "entries", 0},
                                             {"memory_mb", "memory MB", 1},
                                             {"reference_error", "reference +-", 4}};
    return columns;
}

}  // namespace aula::bench
