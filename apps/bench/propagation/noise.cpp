#include "apps/bench/propagation/noise.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <thread>

#include "apps/bench/base/statistics.h"
#include "apps/bench/propagation/reference.h"
#include "aula/engine/propagation.h"
#include "engine/base/sampling.h"

namespace aula::bench {

namespace {

/// The reference traces until its share of the mean ratio's standard error is below this.
constexpr double kReferenceError = 0.002;
constexpr std::uint64_t kNoiseReferenceRound = 1 << 17;

/// Restarts that measure the cost of a frame when rays are matched to CPU time.
constexpr int kCostRestarts = 4;

/// The response of an estimator after each restart.
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
    const Simulation simulation = subject.comparable_simulation(estimator, rays);
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

/// Contribution of the reference to the relative standard error of the mean ratio.
double ratio_error(const Reference& reference, BinRange bins) {
    double squares = 0;
    int groups = 0;
    for (std::size_t b = bins.first; b + kGroupBins <= bins.end; b += kGroupBins, ++groups) {
        const Reference::Estimate group = reference.energy(0, {b, b + kGroupBins});
        squares += std::pow(group.standard_error / group.mean, 2);
    }
    return groups > 0 ? std::sqrt(squares) / groups : 0;
}

/// Contribution of the estimator to the standard error of the mean ratio.
double ratio_error(const Restarts& restarts, const std::vector<double>& reference, BinRange bins) {
    std::vector<double> ratios;
    for (const std::vector<double>& energy : restarts.energy)
        ratios.push_back(energy_ratio({energy}, reference, bins));
    return standard_error(ratios);
}

/// One estimator with one set of settings.
struct Run {
    const char* bench;
    const char* basis;
    Subject subject;
    Estimator estimator;
    int rays;
    Restarts restarts;
};

/// Traces until the reference is accurate enough.
void converge(Reference& reference, const Settings& settings) {
    WorkerPool workers(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
    const ReferenceLimit limit(settings);
    do {
        settings.progress("noise: reference, " + std::to_string(reference.rays()) + " rays");
        reference.trace(kNoiseReferenceRound, workers);
    } while (ratio_error(reference, audible_bins(reference.response(0))) > kReferenceError &&
             !limit.reached(static_cast<double>(reference.rays())));
}

/// A row for each run.
std::vector<Row> rows_of(const std::vector<Run>& runs, const Settings& settings) {
    const std::size_t bin_count = runs.front().restarts.energy.front().size();
    const Scene& scene = runs.front().subject.scene;
    // The same for every tau and lambda.
    Reference reference(scene, scene.simulation, 0, scene.sources[0].position_at(0),
                        {scene.listener.pose_at(0).position}, bin_count);
    converge(reference, settings);
    const std::vector<double> wanted = reference.response(0);
    const BinRange bins = audible_bins(wanted);

    std::vector<Row> rows;
    std::optional<double> pt_noise;
    for (const Run& r : runs) {
        const double noise = relative_deviation(r.restarts.energy, bins);
        // Plain path tracing comes first on each basis, if at all.
        if (r.estimator == Estimator::pt) pt_noise = noise;
        const Simulation& s = r.subject.scene.simulation;
        const Vec3 listener = r.subject.scene.listener.pose_at(0).position;
        const int frames = r.estimator == Estimator::pt ? 1 : r.subject.frames;
        Row row;
        row.figures = {{"bench", r.bench},
                       {"scene", r.subject.name},
                       {"basis", r.basis},
                       {"estimator", estimator_name(r.estimator)},
                       {"rays", std::int64_t{r.rays}},
                       {"order", std::int64_t{s.order}},
                       {"tau_s", double{s.response_time_s}},
                       {"frames", std::int64_t{frames}},
                       {"position", std::array<double, 3>{double{listener.x}, double{listener.y},
                                                          double{listener.z}}},
                       {"frame_ms", r.restarts.frame_s * 1000},
                       {"frame_cpu_ms", r.restarts.frame_cpu_s * 1000},
                       {"noise", noise},
                       {"noise_to_pt", pt_noise ? Value{noise / *pt_noise} : Value{}},
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

}  // namespace

std::vector<Row> measure_noise(const Subject& subject, const Settings& settings) {
    // Run every estimator at equal rays, then at equal CPU time.
    const int scene_rays = subject.scene.simulation.ray_count();
    std::vector<Run> runs;
    double budget_s = 0;
    for (const Estimator estimator : settings.estimators) {
        runs.push_back({"noise", "rays", subject, estimator, scene_rays,
                        run(subject, estimator, scene_rays, settings.restarts, settings)});
        if (estimator == Estimator::patch) budget_s = runs.back().restarts.frame_cpu_s;
    }
    if (budget_s == 0) {
        budget_s = run(subject, Estimator::patch, scene_rays, kCostRestarts, settings).frame_cpu_s;
    }
    add_runs_at_equal_cpu_time(
        runs, budget_s,
        [&](Estimator estimator, int rays) {
            return run(subject, estimator, rays, kCostRestarts, settings).frame_cpu_s;
        },
        [&](Run& r) {
            r.restarts = run(subject, r.estimator, r.rays, settings.restarts, settings);
        });
    return rows_of(runs, settings);
}

std::vector<Row> measure_sweep(const Subject& subject, const Settings& settings) {
    constexpr std::array<float, 5> kTaus_s{0.1F, 0.2F, 0.5F, 1.0F, 2.0F};
    constexpr std::array<float, 5> kSizes_m{0.125F, 0.25F, 0.5F, 1.0F, 2.0F};
    const int rays = subject.scene.simulation.ray_count();
    const auto run_at = [&](const Settings& changed, std::vector<Run>& runs) {
        const Subject at(subject.name, subject.scene, changed);
        for (const Estimator estimator : settings.estimators) {
            // Plain path tracing depends on neither tau nor lambda.
            if (estimator == Estimator::pt && !runs.empty()) {
                runs.push_back(runs.front());
                runs.back().subject = at;
                continue;
            }
            runs.push_back({"sweep", "rays", at, estimator, rays,
                            run(at, estimator, rays, settings.restarts, settings)});
        }
    };
    std::vector<Run> runs;
    for (const float tau_s : kTaus_s) {
        Settings changed = settings;
        changed.response_time_s = tau_s;
        run_at(changed, runs);
    }
    for (const float size_m : kSizes_m) {
        Settings changed = settings;
        changed.patch_size_m = size_m;
        run_at(changed, runs);
    }
    return rows_of(runs, settings);
}

const std::vector<Column>& noise_columns() {
    static const std::vector<Column> columns =
        columns_of({"basis", "estimator", "rays", "frames", "frame_ms", "frame_cpu_ms", "noise",
                    "noise_to_pt", "direction_noise_deg", "energy_ratio", "energy_ratio_error",
                    "cache_entries", "memory_mb", "reference_error"});
    return columns;
}

const std::vector<Column>& sweep_columns() {
    static const std::vector<Column> columns = columns_of(
        {"tau_s", "patch_size_m", "estimator", "frame_cpu_ms", "noise", "direction_noise_deg",
         "energy_ratio", "energy_ratio_error", "cache_entries", "memory_mb"});
    return columns;
}

}  // namespace aula::bench
