#include "apps/bench/rendering/budget.h"

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "apps/bench/propagation/source_positions.h"
#include "apps/room/frames/ray_budget.h"
#include "apps/room/frames/signals.h"
#include "apps/room/offline/offline.h"
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

/// Renders the scene's sound in its quality. `movement`: of its sources.
Row rendered(const Subject& subject, const Scene& scene, const char* movement) {
    PlaybackOptions options;
    options.duration_s = kSound_s;
    const double begin_s = cpu_time_s();
    OfflineRendering rendering(scene, read_signals(scene, options.sample_rate_hz), options);
    rendering.render([](std::span<const std::span<const float>>) {}, {});
    const double took_s = cpu_time_s() - begin_s;
    const AuralizerStatus status = rendering.status();
    Row row;
    row.figures = {{"bench", "budget"},
                   {"scene", subject.name},
                   {"quality", quality_name(scene.simulation.quality)},
                   {"movement", movement},
                   {"sources", static_cast<std::int64_t>(scene.sources.size())},
                   {"response_s", status.response_length_s},
                   {"rays", std::int64_t{status.rays}},
                   {"cpu_per_second", took_s / kSound_s},
                   {"counted_to_measured", counted_over_measured(scene, status.rays)}};
    return row;
}

/// `count` sources like the scene's first one, at rest or each moving up and down by 0.2 m.
std::vector<Source> sources_like_first(const Scene& scene, int count, bool moving) {
    std::vector<Source> sources;
    for (const Vec3& position : source_positions(scene, count)) {
        Source source = scene.sources[0];
        source.position = position;
        source.path.reset();
        if (moving) {
            const Pose low = source.pose_at(0);
            Pose high = low;
            high.position.z += 0.2F;
            source.path = Trajectory{{{0, low}, {0.5, high}, {1, low}}, true};
        }
        sources.push_back(std::move(source));
    }
    return sources;
}

}  // namespace

std::vector<Row> measure_budget(const Subject& subject, const Settings& settings) {
    std::vector<Row> rows;
    Scene scene = subject.scene;
    scene.sources = subject.sources;
    scene.simulation.rays = settings.rays;
    for (const Quality quality : {Quality::draft, Quality::normal, Quality::fine}) {
        settings.progress(std::string("budget: ") + quality_name(quality));
        scene.simulation.quality = quality;
        rows.push_back(rendered(subject, scene, "of the scene"));
    }
    scene.simulation.quality = Quality::normal;
    for (const bool moving : {false, true}) {
        for (const int count : {1, 4, 16}) {
            settings.progress("budget: " + std::to_string(count) + " sources");
            scene.sources = sources_like_first(subject.scene, count, moving);
            rows.push_back(rendered(subject, scene, moving ? "moving" : "at rest"));
        }
    }
    return rows;
}

const std::vector<Column>& budget_columns() {
    static const std::vector<Column> columns =
        columns_of({"quality", "movement", "sources", "response_s", "rays", "cpu_per_second",
                    "counted_to_measured"});
    return columns;
}

}  // namespace aula::bench
