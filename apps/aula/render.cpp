#include <cstdio>
#include <functional>

#include "apps/aula/commands.h"
#include "apps/aula/outputs.h"
#include "apps/aula/terminal/progress_bar.h"
#include "apps/aula/terminal/standard_output.h"
#include "apps/aula/terminal/terminal.h"
#include "apps/output/formatted.h"
#include "apps/output/output_file.h"
#include "apps/output/printable.h"
#include "apps/room/offline/measurement_text.h"
#include "apps/room/offline/offline.h"
#include "aula/audio/sound_file.h"
#include "aula/measurement.h"

namespace aula {

namespace {

void write_planar(WavWriter& writer, const std::vector<std::vector<float>>& channels) {
    std::vector<float> interleaved;
    for (std::size_t i = 0; i < channels[0].size(); ++i)
        for (const auto& channel : channels) interleaved.push_back(channel[i]);
    writer.write(interleaved);
}

void print(const std::string& text) {
    std::fputs(printable(text).c_str(), stdout);
    flush_standard_output();
}

/// The output files of --ir, --echogram and --report. They are opened before the measurement and
/// committed after it: a file that cannot be written is reported first, and no partial file
/// remains. The HRTF and the headphones of --ir are read before it, too.
class MeasurementFiles {
 public:
    MeasurementFiles(const Arguments& arguments, const Scene& scene) : arguments_(arguments) {
        const PlaybackOptions& playback = arguments.playback;
        if (arguments.ir) {
            output_.emplace(playback, "impulse responses");
            for (std::size_t s = 0; s < scene.sources.size(); ++s)
                responses_.push_back(std::make_unique<WavWriter>(
                    response_file(*arguments.ir, scene, s), playback.sample_rate_hz,
                    channel_count(playback.output), SampleFormat::float32));
        }
        if (arguments.echogram) echogram_.emplace(*arguments.echogram);
        if (arguments.report_json) report_.emplace(*arguments.report_json);
    }

    void write(const Scene& scene, const Measurement& measurement) {
        if (arguments_.ir) {
            const ImpulseResponses impulse_responses = responses_with(measurement, *output_);
            for (std::size_t s = 0; s < responses_.size(); ++s)
                write_planar(*responses_[s], impulse_responses.response(s));
        }
        if (echogram_) echogram_->write(echogram_csv(scene, measurement, arguments_.bin_s));
        if (report_) report_->write(report_json(measurement));
        std::int64_t muted = 0;
        for (const auto& response : responses_) muted += response->muted_samples();
        if (muted > 0) warn({muted_text(muted)}, arguments_.quiet);
        for (auto& response : responses_) response->commit();
        if (echogram_) echogram_->commit();
        if (report_) report_->commit();
        // Last, because the reader of standard output may have ended.
        if (arguments_.report) print(report_table(measurement));
    }

 private:
    const Arguments& arguments_;
    std::optional<OutputResources> output_;  ///< of --ir
    std::vector<std::unique_ptr<WavWriter>> responses_;
    std::optional<OutputFile> echogram_;
    std::optional<OutputFile> report_;
};

}  // namespace

int render(const Arguments& arguments) {
    const Scene scene = read_scene(arguments);
    ProgressBar bar("rendering", arguments.quiet);
    const auto warnings =
        render_offline(scene, arguments.playback, arguments.offline, std::ref(bar));
    if (!warnings) return interrupted_status();
    warn(*warnings, arguments.quiet);
    return 0;
}

int measure(const Arguments& arguments) {
    const Scene scene = read_scene(arguments);
    MeasurementFiles files(arguments, scene);
    ProgressBar bar("measuring", arguments.quiet);
    const auto measurement = measure(
        scene, within_budget({.frames = arguments.frames,
                              .max_work_s = MeasurementOptions::kProgramWork_s,
                              .parameters = arguments.report || arguments.report_json.has_value(),
                              .third_octaves = arguments.third_octaves,
                              .interaural = arguments.report || arguments.report_json.has_value(),
                              .progress = std::ref(bar)},
                             scene.simulation.quality));
    if (!measurement) return interrupted_status();
    warn(warnings_of(*measurement), arguments.quiet);
    files.write(scene, *measurement);
    return 0;
}

}  // namespace aula
