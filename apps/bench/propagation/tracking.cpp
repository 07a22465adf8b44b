#include "apps/bench/propagation/tracking.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numeric>
#include <thread>

#include "apps/bench/base/statistics.h"
#include "apps/bench/propagation/reference.h"
#include "aula/engine/propagation.h"
#include "aula/exception.h"
#include "engine/base/sampling.h"

namespace aula::bench {

namespace {

/// The reference traces until its standard error is this share of the least error measured.
constexpr double kReferenceShare = 0.5;
constexpr std::uint64_t kReferenceRound = 1 << 17;

/// Positions of source and listener in the frames of a walk.
struct Walk {
    const char* mover;
    std::vector<FrameInput> frames;
    std::vector<std::size_t> measured;  ///< frames that are compared with the reference

    bool source_at_rest() const { return at_rest(&FrameInput::sources); }
    bool listener_at_rest() const { return at_rest(&FrameInput::listeners); }

 private:
    bool at_rest(std::vector<Vec3> FrameInput::*positions) const {
        return std::all_of(frames.begin(), frames.end(), [&](const FrameInput& frame) {
            return frame.*positions == frames.front().*positions;
        });
    }
};

std::vector<Walk> walks_of(const Subject& subject, const Settings& settings) {
    const Source& source = subject.scene.sources[0];
    const Listener& listener = subject.scene.listener;
    if (!source.path && !listener.path) {
        throw InputError(subject.name, "/listener",
                         "has no path; expected a listener or source with a path");
    }
    const Trajectory& listener_path = listener.path ? *listener.path : *source.path;
    const Trajectory& source_path = source.path ? *source.path : *listener.path;
    const bool one_path = !source.path || !listener.path;
    const double duration_s = std::min(
        settings.longest_walk_s, std::max(listener_path.duration_s(), source_path.duration_s()));
    const double rate_hz = double{subject.scene.simulation.frame_rate_hz};
    const auto window = static_cast<std::size_t>(subject.scene.simulation.window_frames());
    const auto count = std::max(window + static_cast<std::size_t>(settings.positions),
                                static_cast<std::size_t>(duration_s * rate_hz));
    // An end at rest is at its first position, or at the other end's if the moving end uses its
    // path.
    const Vec3 listener_rest = listener.pose_at(0).position;
    const Vec3 source_rest = source.position_at(0);

    std::vector<Walk> walks{{"listener", {}, {}}, {"source", {}, {}}, {"both", {}, {}}};
    for (std::size_t k = 0; k < count; ++k) {
        const double time_s = static_cast<double>(k) / rate_hz;
        const Vec3 on_listener_path = listener_path.at(time_s).position;
        const Vec3 on_source_path = source_path.at(time_s).position;
        const Vec3 back = source_path.at(static_cast<double>(count - 1 - k) / rate_hz).position;
        walks[0].frames.push_back(
            {time_s, {listener.path ? source_rest : listener_rest}, {on_listener_path}});
        walks[1].frames.push_back(
            {time_s, {on_source_path}, {source.path ? listener_rest : source_rest}});
        walks[2].frames.push_back({time_s, {one_path ? back : on_source_path}, {on_listener_path}});
    }
    const auto positions = static_cast<std::size_t>(settings.positions);
    for (Walk& walk : walks) {
        for (std::size_t i = 0; i < positions; ++i) {
            // Evenly spaced after the first window, both ends included.
            const std::size_t last = count - 1;
            walk.measured.push_back(
                positions == 1 ? last : window + (last - window) * i / (positions - 1));
        }
    }
    return walks;
}

/// The responses of an estimator in the measured frames.
struct Published {
    std::vector<std::vector<std::vector<double>>> energy;  // [repetition][position][bin]
    double frame_s = 0;
    double frame_cpu_s = 0;
};

/// The scene with the paths of a walk: the engine prepares the positions on them.
Scene scene_of(const Subject& subject, const Walk& walk) {
    Scene scene = subject.scene;
    Trajectory listener_path;
    Trajectory source_path;
    for (const FrameInput& frame : walk.frames) {
        listener_path.points.push_back({frame.time_s, {frame.listeners[0]}});
        source_path.points.push_back({frame.time_s, {frame.sources[0]}});
    }
    scene.listener.path = listener_path;
    scene.sources[0].path = source_path;
    return scene;
}

/// Walks for `frames` frames, as often as is asked, each time with a seed of its own.
Published follow(const Subject& subject, const Walk& walk, Estimator estimator, int rays,
                 std::size_t frames, int repetitions, const Settings& settings) {
    settings.progress(std::string("tracking: ") + walk.mover + ", " + estimator_name(estimator) +
                      ", " + std::to_string(rays) + " rays");
    const Simulation simulation = subject.comparable_simulation(estimator, rays);
    Propagation propagation(scene_of(subject, walk), simulation);
    const double rate_hz = double{subject.scene.simulation.frame_rate_hz};
    const auto rest = static_cast<int>(std::lround(settings.rest_s * rate_hz));
    Published published;
    const double all_frames = static_cast<double>(frames) * repetitions;
    for (int repetition = 0; repetition < repetitions; ++repetition) {
        propagation.restart(derive_seed(simulation.seed, repetition));
        for (int k = 0; k < rest; ++k) propagation.step(walk.frames[0]);
        std::vector<std::vector<double>>& energy = published.energy.emplace_back();
        const auto began = std::chrono::steady_clock::now();
        const double cpu_began_s = cpu_time_s();
        for (std::size_t k = 0; k < frames; ++k) {
            propagation.step(walk.frames[k]);
            if (std::find(walk.measured.begin(), walk.measured.end(), k) != walk.measured.end())
                energy.push_back(estimated_energy(propagation.response(0)));
        }
        published.frame_cpu_s += (cpu_time_s() - cpu_began_s) / all_frames;
        published.frame_s +=
            std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count() /
            all_frames;
    }
    return published;
}

/// Rays from one end of a walk, and the positions of the other end that they serve.
struct Bundle {
    double time_s = 0;
    Vec3 emitter{0};
    std::vector<Vec3> receivers;

    friend bool operator==(const Bundle&, const Bundle&) = default;
};

/// By reciprocity one bundle from an end at rest serves the whole walk, in the order of its
/// positions, unless the scene moves. Otherwise each position has its own bundle.
std::vector<Bundle> bundles_of(const Subject& subject, const Walk& walk) {
    const bool scene_moves =
        std::any_of(subject.scene.objects.begin(), subject.scene.objects.end(),
                    [](const Object& object) { return object.path.has_value(); });
    std::vector<Bundle> bundles;
    for (const std::size_t k : walk.measured) {
        const FrameInput& frame = walk.frames[k];
        const bool from_listener = !walk.source_at_rest() && walk.listener_at_rest();
        const Vec3 emitter = from_listener ? frame.listeners[0] : frame.sources[0];
        const Vec3 receiver = from_listener ? frame.sources[0] : frame.listeners[0];
        if (!bundles.empty() && !scene_moves && bundles.back().emitter == emitter) {
            bundles.back().receivers.push_back(receiver);
        } else {
            bundles.push_back({scene_moves ? frame.time_s : 0, emitter, {receiver}});
        }
    }
    return bundles;
}

/// The reference response at every measured position of a walk.
class WalkReference {
 public:
    WalkReference(const Subject& subject, std::vector<Bundle> bundles, std::size_t bin_count)
        : bundles_(std::move(bundles)) {
        for (const Bundle& bundle : bundles_) {
            for (std::size_t r = 0; r < bundle.receivers.size(); ++r) {
                receivers_.push_back({tracers_.size(), r});
            }
            tracers_.push_back(std::make_unique<Reference>(subject.scene, subject.scene.simulation,
                                                           bundle.time_s, bundle.emitter,
                                                           bundle.receivers, bin_count));
        }
    }

    const std::vector<Bundle>& bundles() const { return bundles_; }

    /// Traces at least `rays` more, over all tracers.
    void trace(std::uint64_t rays, WorkerPool& workers) {
        for (auto& tracer : tracers_) tracer->trace(rays / tracers_.size(), workers);
    }

    /// Sum over all tracers.
    double rays() const {
        double sum = 0;
        for (const auto& tracer : tracers_) sum += static_cast<double>(tracer->rays());
        return sum;
    }

    std::vector<double> response(std::size_t position) const {
        const auto [tracer, receiver] = receivers_[position];
        return tracers_[tracer]->response(receiver);
    }

    /// Relative standard error, rms over positions and measured bins.
    double error() const {
        double squares = 0;
        for (std::size_t i = 0; i < receivers_.size(); ++i) {
            const auto [tracer, receiver] = receivers_[i];
            const BinRange bins = bins_from_peak(response(i));
            squares += std::pow(tracers_[tracer]->relative_error(receiver, bins), 2);
        }
        return std::sqrt(squares / static_cast<double>(receivers_.size()));
    }

    /// Relative standard error of the energy in the measured bins, mean over positions.
    double energy_error() const {
        std::vector<double> ratios;  // [estimate] to the mean of the estimates
        for (const auto [tracer, receiver] : receivers_) {
            const BinRange bins = bins_from_peak(tracers_[tracer]->response(receiver));
            const std::vector<double> energies = tracers_[tracer]->estimates(receiver, bins);
            const double scale = mean(energies) * static_cast<double>(receivers_.size());
            ratios.resize(energies.size(), 0);
            for (std::size_t i = 0; i < energies.size(); ++i) ratios[i] += energies[i] / scale;
        }
        return standard_error(ratios);
    }

 private:
    struct ReceiverIndex {
        std::size_t tracer;
        std::size_t receiver;
    };
    std::vector<Bundle> bundles_;
    std::vector<std::unique_ptr<Reference>> tracers_;  ///< of each bundle
    std::vector<ReceiverIndex> receivers_;             ///< of each position
};

struct Deviation {
    double error = 0;  ///< without that of the reference
    double energy_ratio = 0;
    double energy_ratio_error = 0;  ///< standard error, of the repetitions and the reference
};

Deviation deviation_of(const Published& published, const WalkReference& reference) {
    double squares = 0;
    std::size_t bins_counted = 0;
    const auto repetitions = static_cast<double>(published.energy.size());
    const std::size_t positions = published.energy.front().size();
    std::vector<double> ratios(published.energy.size(), 0);
    for (std::size_t i = 0; i < positions; ++i) {
        const std::vector<double> wanted = reference.response(i);
        const BinRange bins = bins_from_peak(wanted);
        bins_counted += bins.count();
        const double total =
            std::accumulate(wanted.begin() + static_cast<std::ptrdiff_t>(bins.first),
                            wanted.begin() + static_cast<std::ptrdiff_t>(bins.end), 0.0);
        for (std::size_t walk = 0; walk < ratios.size(); ++walk) {
            const std::vector<double>& energy = published.energy[walk][i];
            squares += squared_relative_error(energy, wanted, bins) / repetitions;
            for (std::size_t b = bins.first; b < bins.end; ++b)
                ratios[walk] += energy[b] / (total * static_cast<double>(positions));
        }
    }
    return {without_reference_error(std::sqrt(squares / static_cast<double>(bins_counted)),
                                    reference.error()),
            mean(ratios), std::hypot(standard_error(ratios), reference.energy_error())};
}

std::vector<Row> measure_walk(const Subject& subject, const Walk& walk, const Settings& settings,
                              std::unique_ptr<WalkReference>& reference, WorkerPool& workers) {
    const int scene_rays = subject.scene.simulation.ray_count();
    const std::size_t all = walk.frames.size();
    const auto cost_frames =
        std::min(all, 2 * static_cast<std::size_t>(subject.scene.simulation.window_frames()));

    struct Run {
        const char* basis;
        Estimator estimator;
        int rays;
        Published published;
    };
    std::vector<Run> runs;
    for (const Estimator estimator : settings.estimators) {
        runs.push_back(
            {"rays", estimator, scene_rays,
             follow(subject, walk, estimator, scene_rays, all, settings.walks, settings)});
    }
    // The cost is measured over the first frames, equally for all.
    const auto frame_cpu_s = [&](Estimator estimator, int rays) {
        return follow(subject, walk, estimator, rays, cost_frames, 1, settings).frame_cpu_s;
    };
    if (settings.estimators != std::vector{Estimator::patch}) {
        add_runs_at_equal_cpu_time(
            runs, frame_cpu_s(Estimator::patch, scene_rays), frame_cpu_s, [&](Run& r) {
                r.published =
                    follow(subject, walk, r.estimator, r.rays, all, settings.walks, settings);
            });
    }

    // Converge the reference to the error of the best of them; that of the previous walk is reused
    // if its rays are the same.
    std::vector<Bundle> bundles = bundles_of(subject, walk);
    if (!reference || reference->bundles() != bundles) {
        reference = std::make_unique<WalkReference>(
            subject, std::move(bundles), runs.front().published.energy.front().front().size());
    }
    const auto min_error = [&] {
        double min = deviation_of(runs.front().published, *reference).error;
        for (const Run& r : runs) {
            min = std::min(min, deviation_of(r.published, *reference).error);
        }
        return min;
    };
    const ReferenceLimit limit(settings);
    while (reference->rays() == 0 ||
           (!has_converged(reference->error(), kReferenceShare, min_error()) &&
            !limit.reached(reference->rays()))) {
        settings.progress(std::string("tracking: ") + walk.mover + ", reference, " +
                          std::to_string(static_cast<std::int64_t>(reference->rays())) + " rays");
        reference->trace(kReferenceRound, workers);
    }

    std::vector<Row> rows;
    std::vector<double> pt_error;
    for (const Run& r : runs) {
        const Deviation deviation = deviation_of(r.published, *reference);
        // Plain path tracing comes first on each basis, if at all.
        if (r.estimator == Estimator::pt) pt_error.push_back(deviation.error);
        Row row;
        row.figures = {
            {"bench", "tracking"},
            {"scene", subject.name},
            {"basis", r.basis},
            {"mover", walk.mover},
            {"estimator", estimator_name(r.estimator)},
            {"rays", std::int64_t{r.rays}},
            {"order", std::int64_t{subject.scene.simulation.order}},
            {"tau_s", double{subject.scene.simulation.response_time_s}},
            {"positions", std::int64_t{settings.positions}},
            {"walks", std::int64_t{settings.walks}},
            {"rest_s", settings.rest_s},
            {"frame_ms", r.published.frame_s * 1000},
            {"frame_cpu_ms", r.published.frame_cpu_s * 1000},
            {"tracking_error", deviation.error},
            {"error_to_pt", pt_error.empty() ? Value{} : Value{deviation.error / pt_error.back()}},
            {"energy_ratio", deviation.energy_ratio},
            {"energy_ratio_error",
             settings.walks > 1 ? Value{deviation.energy_ratio_error} : Value{}},
            {"reference_rays", static_cast<std::int64_t>(reference->rays())},
            {"reference_error", reference->error()}};
        rows.push_back(row);
    }
    return rows;
}

}  // namespace

std::vector<Row> measure_tracking(const Subject& subject, const Settings& settings) {
    WorkerPool workers(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
    std::unique_ptr<WalkReference> reference;
    std::vector<Row> rows;
    for (const Walk& walk : walks_of(subject, settings)) {
        const std::vector<Row> more = measure_walk(subject, walk, settings, reference, workers);
        rows.insert(rows.end(), more.begin(), more.end());
    }
    return rows;
}

const std::vector<Column>& tracking_columns() {
    static const std::vector<Column> columns = columns_of(
        {"basis", "mover", "estimator", "rays", "frame_ms", "frame_cpu_ms", "tracking_error",
         "error_to_pt", "energy_ratio", "energy_ratio_error", "reference_error"});
    return columns;
}

}  // namespace aula::bench
