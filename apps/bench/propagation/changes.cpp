#include "apps/bench/propagation/changes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <string>

#include "apps/bench/propagation/source_positions.h"
#include "aula/engine/propagation.h"

namespace aula::bench {

namespace {

constexpr double kBeforeChange_s = 2;  // before the change
constexpr double kMoving_s = 1;        // duration of a walk
constexpr double kAfter_s = 1;         // rest after it
constexpr double kWalk_m_s = 1.5;
constexpr double kLongestPath_s = 10;  // of the objects
constexpr int kChangeRepetitions = 3;

enum class Change { none, walk, jump };

struct Script {
    const char* name;
    Change source;
    Change listener;
    bool objects = false;
};

constexpr std::array kScripts{Script{"rest", Change::none, Change::none},
                              Script{"source walks", Change::walk, Change::none},
                              Script{"listener walks", Change::none, Change::walk},
                              Script{"both walk", Change::walk, Change::walk},
                              Script{"source jumps", Change::jump, Change::none},
                              Script{"listener jumps", Change::none, Change::jump},
                              Script{"both jump", Change::jump, Change::jump},
                              Script{"objects move", Change::none, Change::none, true}};

/// An end of the paths: where it rests, its walk towards another point, and where it jumps.
struct End {
    Vec3 from{0};
    Vec3 towards{0};
    Vec3 target{0};

    /// The position `moving_s` seconds after the start of the change.
    Vec3 at(Change change, double moving_s) const {
        if (change == Change::none || moving_s <= 0) return from;
        if (change == Change::jump) return target;
        const Vec3 offset = towards - from;
        const float distance_m = glm::length(offset);
        const auto walked_m = static_cast<float>(kWalk_m_s * std::min(moving_s, kMoving_s));
        return from + offset / distance_m * std::min(walked_m, distance_m / 2);
    }
};

/// The time at which the objects of a scene rest for the first time, at most kLongestPath_s; 0 if
/// none has a path.
double end_of_paths_s(const Scene& scene) {
    double end_s = 0;
    for (const Object& object : scene.objects) {
        if (object.path) end_s = std::max(end_s, object.path->duration_s());
    }
    return std::min(end_s, kLongestPath_s);
}

/// The frames of a script. Objects move from time 0 on, or not at all.
std::vector<FrameInput> frames_of(const Subject& subject, const Script& script) {
    const double rate_hz = double{subject.scene.simulation.frame_rate_hz};
    const double duration_s = script.objects ? end_of_paths_s(subject.scene) + kAfter_s
                                             : kBeforeChange_s + kMoving_s + kAfter_s;
    const std::vector<Vec3> targets = source_positions(subject.scene, 3);
    const Vec3 source_m = subject.scene.sources[0].position_at(0);
    const Vec3 listener_m = subject.scene.listener.pose_at(0).position;
    const End source{source_m, listener_m, targets[1 % targets.size()]};
    const End listener{listener_m, source_m, targets[2 % targets.size()]};
    std::vector<FrameInput> frames;
    for (int f = 0; f < std::lround(duration_s * rate_hz); ++f) {
        const double time_s = f / rate_hz;
        frames.push_back({script.objects ? time_s : 0,
                          {source.at(script.source, time_s - kBeforeChange_s)},
                          {listener.at(script.listener, time_s - kBeforeChange_s)}});
    }
    return frames;
}

/// CPU time of each frame.
std::vector<double> measure_frames(const Subject& subject, const std::vector<FrameInput>& frames) {
    Propagation propagation(
        subject.scene, subject.simulation(Estimator::patch, subject.scene.simulation.ray_count()));
    std::vector<double> frame_s;
    for (const FrameInput& frame : frames) {
        const double began_s = cpu_time_s();
        propagation.step(frame);
        frame_s.push_back(cpu_time_s() - began_s);
    }
    return frame_s;
}

}  // namespace

std::vector<Row> measure_changes(const Subject& subject, const Settings& settings) {
    std::vector<Row> rows;
    for (const Script& script : kScripts) {
        if (script.objects && end_of_paths_s(subject.scene) == 0) continue;
        const std::vector<FrameInput> frames = frames_of(subject, script);
        std::vector<double> least_s(frames.size(), std::numeric_limits<double>::infinity());
        for (int k = 0; k < kChangeRepetitions; ++k) {
            settings.progress(std::string("changes: ") + script.name + ", " +
                              std::to_string(k + 1));
            const std::vector<double> frame_s = measure_frames(subject, frames);
            std::transform(frame_s.begin(), frame_s.end(), least_s.begin(), least_s.begin(),
                           [](double a, double b) { return std::min(a, b); });
        }
        const auto worst = std::max_element(least_s.begin(), least_s.end());
        const double mean_s = std::accumulate(least_s.begin(), least_s.end(), 0.0) /
                              static_cast<double>(least_s.size());
        Row row;
        row.figures = {{"bench", "changes"},
                       {"scene", subject.name},
                       {"change", script.name},
                       {"rays", std::int64_t{subject.scene.simulation.ray_count()}},
                       {"frames", static_cast<std::int64_t>(frames.size())},
                       {"frame_cpu_ms", mean_s * 1e3},
                       {"worst_cpu_ms", *worst * 1e3},
                       {"worst_to_mean", *worst / mean_s},
                       {"worst_frame", static_cast<std::int64_t>(worst - least_s.begin())}};
        rows.push_back(row);
    }
    return rows;
}

const std::vector<Column>& changes_columns() {
    static const std::vector<Column> columns =
        columns_of({"change", "rays", "frames", "frame_cpu_ms", "worst_cpu_ms", "worst_to_mean",
                    "worst_frame"});
    return columns;
}

}  // namespace aula::bench
