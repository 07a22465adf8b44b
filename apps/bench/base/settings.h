#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aula/engine/scene.h"

namespace aula::bench {

/// Overrides of a scene's settings, and the extent of measurements.
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
    std::optional<int> frames;             ///< before a response is read; absent: the window F
    std::optional<std::size_t> triangles;  ///< surfaces are divided into at least as many
    int restarts = 64;                     ///< of each estimator, at least 2
    int positions = 8;                     ///< measured on a walk, at least 1
    double longest_walk_s = 10;            ///< tracking: duration of a walk, at most
    int walks = 4;                         ///< tracking: repetitions with seeds of their own
    double rest_s = 0;                     ///< tracking: rest of both ends before the walk
    double frame_ms = 10;                  ///< rest: CPU time of a frame
    int sources = 16;                      ///< of the command sources, compared with one
    double reference_rays = 64e6;          ///< at most, even if the reference has not converged
    double reference_s = 120;              ///< CPU time of a reference, at most
    std::function<void(const std::string&)> progress;  ///< receives the present step in a few words
};

/// A scene to be measured: with a name, overridden settings and its first source only.
struct Subject {
    std::string name;
    std::vector<Source> sources;  ///< all of the scene's
    Scene scene;
    int frames = 1;   ///< before a response is read; `pt`: one
    int threads = 1;  ///< of the propagation

    /// Throws InputError if the scene has no source.
    Subject(std::string scene_name, const Scene& given, const Settings& settings);

    /// The scene's settings with another estimator and number of rays.
    Simulation simulation(Estimator estimator, int rays) const;

    /// The same without diffraction and transmission, which the reference does not compute.
    Simulation comparable_simulation(Estimator estimator, int rays) const;

    /// The settings that all rows share, in one line.
    std::string description() const;
};

/// CPU time of this process so far, all threads, in s.
double cpu_time_s();

/// The number of rays whose frame costs `budget_s` of CPU time, searched from `rays` on by
/// measuring `frame_cpu_s(rays)`.
int rays_for_cpu_time(double budget_s, int rays, const std::function<double(int)>& frame_cpu_s);

/// Appends to the runs at equal rays the same runs at the CPU time of `patch`. A run has basis,
/// estimator and rays. `frame_cpu_s(estimator, rays)` measures a frame, `measure(run)` a whole run.
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
