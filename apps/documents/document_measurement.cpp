#include "apps/documents/document_measurement.h"

#include <algorithm>
#include <utility>

namespace aula {

namespace {

/// Standard errors of maps, in every octave from 125 Hz to 4 kHz: half of the just noticeable
/// differences.
constexpr MeasurementLimits kMapLimits{.level_db = 0.5, .c80_db = 0.5, .t30 = 0.025, .edt = 0.025};

/// Frames of a map that does not reach these limits before, so that large maps end.
constexpr int kMapFrames = 256;

/// Standard errors of reports, in every octave from 125 Hz to 4 kHz: a quarter of the just
/// noticeable differences.
constexpr MeasurementLimits kReportLimits{
    .level_db = 0.25, .c80_db = 0.25, .t30 = 0.0125, .edt = 0.0125};

/// Frames of a report that does not reach these limits before: of the late sound of rooms with
/// parallel hard walls, for instance. Two sources then take about 45 s at six receivers.
constexpr int kReportFrames = 500;

/// Counted work of larger reports, with the interaural coefficients. With the length of the
/// responses before, a dozen pairs should take at most two minutes of one thread.
constexpr double kReportWork_s = 80;

/// Counted work with each scattering: with both, a report of a dozen pairs takes less than two
/// minutes.
constexpr double kScatteringWork_s = 10;

}  // namespace

std::string uncertainty_summary(const Measurement& measurement) {
    const auto uncertain =
        std::count_if(measurement.uncertain.begin(), measurement.uncertain.end(),
                      [](const std::string& parameters) { return !parameters.empty(); });
    if (uncertain == 0) return {};
    return "standard errors after " + std::to_string(measurement.frames) +
           " frames are larger than wanted at " + std::to_string(uncertain) + " of " +
           std::to_string(measurement.audible.size()) + " pairs of source and receiver";
}

std::optional<Measurement> measure_map(const Scene& scene, const ReceiverGrid& grid,
                                       std::optional<int> frames, const FurtherParameters& further,
                                       const std::function<bool(double done)>& progress) {
    return measure(scene, scene.sources, grid.receivers,
                   within_budget({.frames = frames,
                                  .limits = kMapLimits,
                                  .max_frames = kMapFrames,
                                  .max_work_s = MeasurementOptions::kProgramWork_s,
                                  .third_octaves = further.third_octaves,
                                  .interaural = further.interaural,
                                  .progress = progress},
                                 scene.simulation.quality));
}

std::optional<Measurement> measure_report(const Scene& scene, std::span<const Pose> receivers,
                                          std::vector<std::string> receiver_names,
                                          std::optional<int> frames,
                                          const FurtherParameters& further,
                                          const std::function<bool(double done)>& progress) {
    const Quality quality = scene.simulation.quality;
    MeasurementOptions options{.frames = frames,
                               .max_work_s = kReportWork_s,
                               .third_octaves = further.third_octaves,
                               .interaural = further.interaural,
                               .receiver_names = std::move(receiver_names),
                               .progress = progress};
    if (quality != Quality::fine) {
        options.limits = kReportLimits;
        options.max_frames = kReportFrames;
    }
    return measure(scene, scene.sources, receivers, within_budget(std::move(options), quality));
}

std::optional<std::vector<Measurement>> measure_scattering(
    const Scene& scene, std::span<const Pose> receivers, std::optional<int> frames,
    const std::function<bool(double done)>& progress) {
    std::vector<Measurement> all;
    for (const float factor : kScatteringFactors) {
        Scene changed = scene;
        for (Material& material : changed.materials)
            for (std::size_t b = 0; b < kBandCount; ++b)
                material.scattering[b] = std::min(1.0F, factor * material.scattering[b]);
        const auto share = [&](double done) {
            return progress((static_cast<double>(all.size()) + done) / kScatteringFactors.size());
        };
        std::optional<Measurement> one = measure(changed, changed.sources, receivers,
                                                 within_budget({.frames = frames,
                                                                .limits = kMapLimits,
                                                                .max_frames = kMapFrames,
                                                                .max_work_s = kScatteringWork_s,
                                                                .progress = share},
                                                               scene.simulation.quality));
        if (!one) return std::nullopt;
        all.push_back(std::move(*one));
    }
    return all;
}

}  // namespace aula
