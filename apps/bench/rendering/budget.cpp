#include "apps/bench/rendering/budget.h"

#include <cmath>
#include <cstdint>
#include <span>

#include "apps/session/frames/ray_budget.h"
#include "apps/session/frames/signals.h"
#include "apps/session/offline/offline.h"
#include "aula/engine/propagation.h"

namespace aula::bench {

namespace {

/// The sound of a scene without paths and sounds that end.
constexpr double kSound_s = 10;

/// The counted over the measured time of the frames of a walk.
double counted_over_measured(const Scene& scene, int rays) {
    Simulation simulation = scene.simulation;
    simulation.rays = rays;
    Propagation propagation(scene, simulation);
    double counted = 0;
    const double begin_s = cpu_time_s();
    const auto rate_hz = double{simulation.frame_rate_hz};
    for (int frame = 0; frame < std::lround(kSound_s * rate_hz); ++frame) {
        const double time_s = frame / rate_hz;
        FrameInput input{.time_s = time_s,
                         .sources = {},
                         .listeners = {scene.listener.pose_at(time_s).position}};
        for (const Source& source : scene.sources) {
            input.sources.push_back(source.position_at(time_s));
            input.source_rotations.push_back(source.pose_at(time_s).rotation());
        }
        propagation.step(input);
        counted += counted_s(propagation.statistics());
    }
    return counted / (cpu_time_s() - begin_s);
}

}  // namespace

std::vector<Row> measure_budget(const Subject& subject, const Settings& settings) {
    std::vector<Row> rows;
    for (const Quality quality : {Quality::draft, Quality::normal, Quality::fine}) {
        settings.progress(std::string("budget: ") + quality_name(quality));
        Scene scene = subject.scene;
        scene.sources = subject.sources;
        scene.simulation.quality = quality;
        scene.simulation.rays = settings.rays;
        SessionOptions options;
        options.duration_s = kSound_s;
        const double begin_s = cpu_time_s();
        OfflineRendering rendering(scene, read_signals(scene, options.sample_rate_hz), options);
        rendering.render([](std::span<const std::span<const float>>) {}, {});
        const double took_s = cpu_time_s() - begin_s;
        const AuralizerStatus status = rendering.status();
        Row row;
        row.figures = {{"bench", "budget"},
                       {"scene", subject.name},
                       {"quality", quality_name(quality)},
                       {"sources", static_cast<std::int64_t>(scene.sources.size())},
                       {"response_s", status.response_length_s},
                       {"rays", std::int64_t{status.rays}},
                       {"cpu_per_second", took_s / kSound_s},
                       {"counted_to_measured", counted_over_measured(scene, status.rays)}};
        rows.push_back(row);
    }
    return rows;
}

const std::vector<Column>& budget_columns() {
    static const std::vector<Column> columns = columns_of(
        {"quality", "sources", "response_s", "rays", "cpu_per_second", "counted_to_measured"});
    return columns;
}

}  // namespace aula::bench
