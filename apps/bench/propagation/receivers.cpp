#include "apps/bench/propagation/receivers.h"

#include <cstdint>
#include <string>

#include "apps/bench/base/statistics.h"
#include "apps/bench/propagation/source_positions.h"
#include "apps/room/offline/static_propagation.h"
#include "aula/engine/propagation.h"
#include "engine/base/sampling.h"
#include "engine/base/stopwatch.h"

namespace aula::bench {

namespace {

constexpr int kReceivers = 32;
constexpr int kWindows = 11;

}  // namespace

std::vector<Row> measure_receivers(const Subject& subject, const Settings& settings) {
    Scene scene = subject.scene;
    scene.sources.resize(1);
    const Simulation simulation =
        subject.simulation(Estimator::patch, scene.simulation.ray_count());
    Propagation propagation(scene, simulation);
    const FrameInput input{.sources = {scene.sources[0].position_at(0)},
                           .listeners = {scene.listener.pose_at(0).position}};
    std::vector<Vec3> receivers = source_positions(scene, kReceivers + 1);
    receivers.erase(receivers.begin());

    std::vector<double> trace_s;
    std::vector<double> receiver_s;
    double first_s = 0;
    for (int window = 0; window <= kWindows; ++window) {
        settings.progress("receivers: window " + std::to_string(window));
        propagation.restart(derive_seed(simulation.seed, static_cast<std::uint64_t>(window)));
        double traced_s = 0;
        for (int frame = 0; frame < StaticPropagation::gather_frames(kReceivers); ++frame) {
            propagation.step(input);
            traced_s += propagation.statistics().trace_s;
        }
        Stopwatch watch;
        const auto responses = propagation.responses_at(input, receivers);
        const double gathered_s = watch.lap_s() / static_cast<double>(responses.size());
        // The first window searches for the paths of the direct sound.
        if (window == 0) {
            first_s = gathered_s;
            continue;
        }
        trace_s.push_back(traced_s);
        receiver_s.push_back(gathered_s);
    }
    Row row;
    row.figures = {{"bench", "receivers"},
                   {"scene", subject.name},
                   {"rays", std::int64_t{simulation.ray_count()}},
                   {"receivers", std::int64_t{kReceivers}},
                   {"source_trace_ms", median(trace_s) * 1000},
                   {"receiver_ms", median(receiver_s) * 1000},
                   {"first_receiver_ms", first_s * 1000},
                   {"receiver_to_trace", median(receiver_s) / median(trace_s)}};
    return {row};
}

const std::vector<Column>& receivers_columns() {
    static const std::vector<Column> columns =
        columns_of({"rays", "receivers", "source_trace_ms", "receiver_ms", "first_receiver_ms",
                    "receiver_to_trace"});
    return columns;
}

}  // namespace aula::bench
