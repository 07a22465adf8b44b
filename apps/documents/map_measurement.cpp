#include "apps/documents/map_measurement.h"

namespace aula {

namespace {

/// Standard errors of maps, in every octave from 125 Hz to 4 kHz: half of the just noticeable
/// differences.
constexpr MeasurementLimits kMapLimits{.level_db = 0.5, .c80_db = 0.5, .t30 = 0.025, .edt = 0.025};

/// Frames of a map that does not reach these limits before, so that large maps end.
constexpr int kMapFrames = 256;

}  // namespace

std::optional<Measurement> measure_map(const Scene& scene, const ReceiverGrid& grid,
                                       std::optional<int> frames, bool interaural,
                                       const std::function<bool(double done)>& progress) {
    return measure(scene, scene.sources, grid.receivers,
                   {.frames = frames,
                    .limits = kMapLimits,
                    .max_frames = kMapFrames,
                    .interaural = interaural,
                    .progress = progress});
}

}  // namespace aula
