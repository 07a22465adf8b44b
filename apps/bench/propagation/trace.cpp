#include "apps/bench/propagation/trace.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <memory>
#include <optional>

#include "apps/bench/base/statistics.h"
#include "aula/engine/impulse_response.h"
#include "aula/engine/propagation.h"
#include "engine/base/worker_pool.h"
#include "engine/frame_rays.h"
#include "engine/rays/ray_scene.h"

namespace aula::bench {

namespace {

constexpr int kRounds = 20;
constexpr int kRepetitions = 4;  // the first one, not timed, fills the processor's caches
constexpr double kSampleRate_hz = 48000;
constexpr std::size_t kShare = 1024;  // rays of a task

double wall_time_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

struct Speed {
    double segments = 0;  // per frame
    double prepare_s = 0;
    double frame_s = 0;
    double one_thread_frame_s = 0;  // of the same frames
    double raw_s = 0;
    double one_thread_raw_s = 0;
    double impulse_response_s = 0;  // time to build one with four channels
    FrameStatistics parts;          // sums over frames
};

Speed measure_speed(const Subject& subject, Estimator estimator, const RayScene& scene,
                    const Settings& settings) {
    const auto clock_s = subject.threads == 1 ? cpu_time_s : wall_time_s;
    const auto seconds_of = [&](const auto& work) {
        const double began_s = clock_s();
        work();
        return clock_s() - began_s;
    };
    Simulation simulation = subject.simulation(estimator, subject.scene.simulation.ray_count());
    Speed speed;
    std::optional<Propagation> propagation;
    speed.prepare_s = seconds_of([&] { propagation.emplace(subject.scene, simulation); });
    std::optional<Propagation> one_thread;
    if (subject.threads > 1) {
        simulation.threads = 1;
        one_thread.emplace(subject.scene, simulation);
    }
    WorkerPool workers(subject.threads);
    WorkerPool one_worker(1);
    ImpulseResponseBuilder builder(make_noise_carriers(kSampleRate_hz, simulation.seed),
                                   subject.scene.medium, propagation->response_length_s(),
                                   subject.scene.sources[0].name);
    ImpulseResponse impulse_response;
    const FrameInput input{
        0, {subject.scene.sources[0].position_at(0)}, {subject.scene.listener.pose_at(0).position}};
    // Fill the window: caches cost more when full.
    for (int i = 0; i < subject.scene.simulation.window_frames(); ++i) {
        propagation->step(input);
        if (one_thread) one_thread->step(input);
    }
    std::vector<double> frame_s;
    std::vector<double> one_thread_frame_s;
    std::vector<double> raw_s;
    std::vector<double> one_thread_raw_s;
    std::vector<double> impulse_response_s;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    const auto step = [&](Propagation& p) { return seconds_of([&] { p.step(input); }); };
    const auto trace_raw = [&](WorkerPool& pool) {
        return seconds_of([&] {
            pool.run((rays.size() + kShare - 1) / kShare, [&](std::size_t share) {
                const std::size_t first = share * kShare;
                const std::size_t count = std::min(kShare, rays.size() - first);
                scene.intersect_each(std::span(rays).subspan(first, count),
                                     std::span(hits).subspan(first, count));
            });
        });
    };
    for (int round = 0; round < kRounds; ++round) {
        settings.progress(std::string("trace: ") + estimator_name(estimator) + ", round " +
                          std::to_string(round + 1));
        rays = FrameRays::of_next(*propagation, input);
        hits.resize(rays.size());
        for (int k = 0; k < kRepetitions; ++k) {
            const double time_s = step(*propagation);
            const FrameStatistics& parts = propagation->statistics();
            assert(k > 0 || rays.size() == parts.segments);
            if (k == 0) continue;
            frame_s.push_back(time_s);
            speed.segments += static_cast<double>(parts.segments) / (kRounds * (kRepetitions - 1));
            speed.parts.trace_s += parts.trace_s;
            speed.parts.cache_s += parts.cache_s;
            speed.parts.gather_s += parts.gather_s;
            speed.parts.specular_s += parts.specular_s;
            speed.parts.diffraction_s += parts.diffraction_s;
            speed.parts.memory_bytes = parts.memory_bytes;
        }
        for (int k = 0; k < kRepetitions && one_thread; ++k) {
            const double time_s = step(*one_thread);
            if (k > 0) one_thread_frame_s.push_back(time_s);
        }
        const auto ray_count = static_cast<double>(rays.size());
        for (int k = 0; k < kRepetitions; ++k) {
            const double time_s = trace_raw(workers) / ray_count;
            if (k > 0) raw_s.push_back(time_s);
        }
        for (int k = 0; k < kRepetitions && one_thread; ++k) {
            const double time_s = trace_raw(one_worker) / ray_count;
            if (k > 0) one_thread_raw_s.push_back(time_s);
        }
        impulse_response_s.push_back(
            seconds_of([&] { builder.build(propagation->response(0), impulse_response); }));
    }
    speed.frame_s = median(frame_s);
    speed.raw_s = median(raw_s) * speed.segments;
    if (one_thread) {
        speed.one_thread_frame_s = median(one_thread_frame_s);
        speed.one_thread_raw_s = median(one_thread_raw_s) * speed.segments;
    }
    speed.impulse_response_s = median(impulse_response_s);
    return speed;
}

}  // namespace

std::vector<Row> measure_tracing(const Subject& subject, const Settings& settings) {
    const RayScene scene(subject.scene);
    std::vector<Row> rows;
    for (const Estimator estimator : settings.estimators) {
        const Speed speed = measure_speed(subject, estimator, scene, settings);
        const FrameStatistics& parts = speed.parts;
        const double parts_s =
            parts.trace_s + parts.cache_s + parts.gather_s + parts.specular_s + parts.diffraction_s;
        const auto segment_ns = [&](double part_s) {
            return part_s / parts_s * speed.frame_s / speed.segments * 1e9;
        };
        const auto times = [](double one_thread_s, double s) {
            return one_thread_s > 0 ? Value(one_thread_s / s) : Value();
        };
        Row row;
        row.figures = {{"bench", "trace"},
                       {"scene", subject.name},
                       {"basis", "rays"},
                       {"estimator", estimator_name(estimator)},
                       {"rays", std::int64_t{subject.scene.simulation.ray_count()}},
                       {"triangles", static_cast<std::int64_t>(scene.triangle_count())},
                       {"threads", std::int64_t{subject.threads}},
                       {"prepare_s", speed.prepare_s},
                       {"segments", speed.segments},
                       {"frame_ms", speed.frame_s * 1e3},
                       {"memory_mb", static_cast<double>(parts.memory_bytes) / 1e6},
                       {"trace_ns", segment_ns(parts.trace_s)},
                       {"cache_ns", segment_ns(parts.cache_s)},
                       {"gather_ns", segment_ns(parts.gather_s)},
                       {"specular_ns", segment_ns(parts.specular_s)},
                       {"diffraction_ns", segment_ns(parts.diffraction_s)},
                       {"raw_ns", speed.raw_s / speed.segments * 1e9},
                       {"segments_per_s", speed.segments / speed.frame_s},
                       {"raw_per_s", speed.segments / speed.raw_s},
                       {"ratio", speed.raw_s / speed.frame_s},
                       {"times_one_thread", times(speed.one_thread_frame_s, speed.frame_s)},
                       {"raw_times_one_thread", times(speed.one_thread_raw_s, speed.raw_s)},
                       {"response_ms", speed.impulse_response_s * 1e3}};
        rows.push_back(row);
    }
    return rows;
}

const std::vector<Column>& tracing_columns() {
    static const std::vector<Column> columns = columns_of(
        {"estimator", "rays", "triangles", "prepare_s", "segments", "frame_ms", "memory_mb",
         "trace_ns", "cache_ns", "gather_ns", "specular_ns", "diffraction_ns", "raw_ns", "ratio",
         "times_one_thread", "raw_times_one_thread", "response_ms"});
    return columns;
}

}  // namespace aula::bench
