#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/scene/scene.h"

namespace aula::bench {

/// The command line's say over a scene's settings, and how much to measure.
struct Settings {
    std::vector<Estimator> estimators{Estimator::pt, Estimator::dpc_published, Estimator::dpc,
                                      Estimator::patch};
    std::optional<int> rays;
    std::optional<int> order;
    std::optional<float> response_time_s;
    std::optional<float> patch_size_m;
    std::optional<float> response_length_s;
    std::optional<std::uint64_t> seed;
    std::optional<int> threads;
    std::optional<int> frames;             ///< published after; the window F where absent
    std::optional<std::size_t> triangles;  ///< surfaces are divided into so many or more
    int restarts = 64;                     ///< of each estimator, at least 2
    int positions = 8;                     ///< of a walk, at least 1
    double rest_s = 0;                     ///< tracking: all stand so long before the walk
    int sources = 32;                      ///< sources: so many beside one
    double reference_rays = 64e6;  ///< no more of them, though the reference has not converged
    std::function<void(const std::string&)> progress;  ///< what is going on, in a few words
};

/// A scene as it is measured: named, its settings overridden, its first source alone.
struct Subject {
    std::string name;
    Scene scene;
    int frames = 1;   ///< until a response is published; `pt`: one
    int threads = 1;  ///< of the propagation

    /// Throws Error if the scene has no source.
    Subject(std::string scene_name, const Scene& given, const Settings& settings);

    /// The scene's settings with another estimator and number of rays.
    Simulation simulation(Estimator estimator, int rays) const;

    /// One line: what all rows have in common.
    std::string description() const;
};

/// CPU time of this process so far, all threads, in s.
double cpu_time_s();

/// The number of rays with which a frame costs `budget_s` of CPU time, found by measuring:
/// `frame_cpu_s(rays)`. Starts from `rays`.
int rays_for_cpu_time(double budget_s, int rays, const std::function<double(int)>& frame_cpu_s);

/// Adds to the runs of all estimators at equal rays as many at equal CPU time, `patch`'s: a run has
/// its basis, estimator and rays. `frame_cpu_s(estimator, rays)` measures a frame, `measure(run)`
/// takes its results anew.
template <typename Run, typename FrameCost, typename Measure>
void add_runs_at_equal_cpu_time(std::vector<Run>& runs, double budget_s,
                                const FrameCost& frame_cpu_s, const Measure& measure) {
    const std::vector<Run> at_equal_rays = runs;
    for (Run run : at_equal_rays) {
        run.basis = "cpu";
        if (run.estimator != Estimator::patch) {
            run.rays = rays_for_cpu_time(
                budget_s, run.rays, [&](int rays) { return frame_cpu_s(run.estimator, rays); });
            measure(run);
        }
        runs.push_back(std::move(run));
    }
}

}  // namespace aula::bench
