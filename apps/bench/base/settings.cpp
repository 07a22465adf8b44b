#include "apps/bench/base/settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "aula/exception.h"
#include "engine/base/worker_pool.h"

namespace aula::bench {

Subject::Subject(std::string scene_name, const Scene& given, const Settings& settings)
    : name(std::move(scene_name)), sources(given.sources), scene(given) {
    if (scene.sources.empty()) throw InputError(name, "/sources", "is empty; expected a source");
    scene.sources.resize(1);
    Simulation& s = scene.simulation;
    if (settings.rays) s.rays = settings.rays;
    s.order = settings.order.value_or(s.order);
    s.response_time_s = settings.response_time_s.value_or(s.response_time_s);
    s.patch_size_m = settings.patch_size_m.value_or(s.patch_size_m);
    if (settings.response_length_s) s.ir_length_s = settings.response_length_s;
    s.seed = settings.seed.value_or(s.seed);
    if (settings.threads) s.threads = settings.threads;
    threads = s.threads.value_or(default_threads());
    s.threads = threads;
    frames = settings.frames.value_or(s.window_frames());
}

Simulation Subject::simulation(Estimator estimator, int rays) const {
    Simulation s = scene.simulation;
    s.estimator = estimator;
    s.rays = rays;
    return s;
}

Simulation Subject::comparable_simulation(Estimator estimator, int rays) const {
    Simulation s = simulation(estimator, rays);
    s.diffraction_order = 0;
    s.transmission = false;
    return s;
}

std::string Subject::description() const {
    const Simulation& s = scene.simulation;
    std::size_t triangles = 0;
    for (const Object& object : scene.objects) triangles += object.triangles.size();
    std::array<char, 256> text{};
    std::snprintf(text.data(), text.size(),
                  "%s: %zu triangles, order %s, tau %g s, %d frames at %g Hz, lambda %g m, "
                  "detector %g m, seed %llu, %d thread%s",
                  name.c_str(), triangles,
                  s.order == 0 ? "unlimited" : std::to_string(s.order).c_str(),
                  double{s.response_time_s}, frames, double{s.frame_rate_hz},
                  double{s.patch_size_m}, double{s.listener_radius_m},
                  static_cast<unsigned long long>(s.seed), threads, threads == 1 ? "" : "s");
    return text.data();
}

double cpu_time_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

int rays_for_cpu_time(double budget_s, int rays, const std::function<double(int)>& frame_cpu_s) {
    constexpr int kRounds = 5;
    constexpr double kCloseEnough = 0.02;
    // The cost has a fixed part and a part per ray: proportional scaling converges from one side.
    for (int round = 0; round < kRounds; ++round) {
        const double share = frame_cpu_s(rays) / budget_s;
        if (std::abs(share - 1) < kCloseEnough) break;
        rays = std::clamp(static_cast<int>(std::lround(rays / std::clamp(share, 0.05, 20.0))), 1,
                          Simulation::kMaxRays);
    }
    return rays;
}

}  // namespace aula::bench
