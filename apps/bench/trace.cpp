#include "apps/bench/trace.h"

#include <cassert>
#include <chrono>

#include "engine/propagation.h"
#include "engine/ray_scene.h"
#include "engine/worker_pool.h"

namespace aula::bench {

namespace {

constexpr int kTimedFrames = 60;
constexpr std::size_t kShare = 1024;  // rays that a thread takes at a time

struct Speed {
    double segments = 0;
    double frame_s = 0;
    double raw_s = 0;
};

double seconds_of(const auto& work) {
    const auto began = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

Speed measure(const Subject& subject, Estimator estimator, const RayScene& scene,
              const Settings& settings) {
    Propagation propagation(subject.scene,
                            subject.simulation(estimator, subject.scene.simulation.rays));
    WorkerPool workers(subject.threads);
    const FrameInput input{
        0, {subject.scene.sources[0].position_at(0)}, {subject.scene.listener.pose_at(0).position}};
    // Fill the window: caches cost more when full.
    for (int i = 0; i < subject.scene.simulation.window_frames(); ++i) propagation.step(input);
    Speed speed;
    for (int i = 0; i < kTimedFrames; ++i) {
        settings.progress(std::string("trace: ") + estimator_name(estimator) + ", frame " +
                          std::to_string(i + 1));
        const std::vector<Ray> rays = propagation.rays(input);
        std::vector<Hit> hits(rays.size());
        speed.frame_s += seconds_of([&] { propagation.step(input); });
        speed.raw_s += seconds_of([&] {
            workers.run((rays.size() + kShare - 1) / kShare, [&](std::size_t share) {
                const std::size_t first = share * kShare;
                const std::size_t count = std::min(kShare, rays.size() - first);
                scene.intersect_each(std::span(rays).subspan(first, count),
                                     std::span(hits).subspan(first, count));
            });
        });
        assert(rays.size() == propagation.statistics().segments);
        speed.segments += static_cast<double>(rays.size());
    }
    return speed;
}

}  // namespace

std::vector<Row> measure_tracing(const Subject& subject, const Settings& settings) {
    const RayScene scene(subject.scene);
    std::vector<Row> rows;
    for (const Estimator estimator : settings.estimators) {
        const Speed speed = measure(subject, estimator, scene, settings);
        Row row;
        row.figures = {{"bench", "trace"},
                       {"scene", subject.name},
                       {"basis", "rays"},
                       {"estimator", estimator_name(estimator)},
                       {"rays", std::int64_t{subject.scene.simulation.rays}},
                       {"triangles", static_cast<std::int64_t>(scene.triangle_count())},
                       {"threads", std::int64_t{subject.threads}},
                       {"segments", speed.segments / kTimedFrames},
                       {"segments_per_s", speed.segments / speed.frame_s},
                       {"raw_per_s", speed.segments / speed.raw_s},
                       {"ratio", speed.raw_s / speed.frame_s}};
        rows.push_back(row);
    }
    return rows;
}

const std::vector<Column>& tracing_columns() {
    static const std::vector<Column> columns{
        {"estimator", "estimator", 0},       {"rays", "rays", 0},
        {"triangles", "triangles", 0},       {"threads", "threads", 0},
        {"segments", "segments a frame", 0}, {"segments_per_s", "segments/s", 0},
        {"raw_per_s", "raw/s", 0},           {"ratio", "/ raw", 3}};
    return columns;
}

}  // namespace aula::bench
