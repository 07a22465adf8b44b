#include "apps/window/model/saved_files.h"

#include <vector>

#include "apps/output/output_file.h"
#include "apps/room/edit/scene_writer.h"
#include "apps/room/offline/measurement_text.h"
#include "apps/window/model/new_file.h"
#include "apps/window/view/curves.h"
#include "engine/mesh/mesh_import.h"

namespace aula {

Scene played_scene(Scene scene, const PlayControls& controls, const Simulation& simulation) {
    scene.simulation = simulation;
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        const SourceControl control = controls.source(s);
        Source& source = scene.sources[s];
        if (control.gain_db) source.gain_db = *control.gain_db;
        if (!control.position && !control.angles_rad) continue;
        source.set_pose(controls.source_at(scene, s, 0));
        source.path.reset();
        source.from_listener.reset();
    }
    if (controls.listener && !scene.listener.path) scene.listener.pose = *controls.listener;
    scene.attach_sources();
    return scene;
}

std::string save_played_scene(const EditedScene& edited, const PlayControls& controls,
                              const Simulation& simulation) {
    const LoadedScene& read = edited.read();
    Scene saved = played_scene(edited.scene(), controls, simulation);
    std::vector<std::string> left_out;
    if (!is_mesh_file(edited.file())) left_out.emplace_back("comments");
    for (std::size_t s = 0; s < saved.sources.size(); ++s) {
        saved.sources[s].loop = read.scene.sources[s].loop;
        const Source& before = edited.scene().sources[s];
        if (before.from_listener && !saved.sources[s].from_listener)
            left_out.push_back("relative_to of " + before.name + ", which was moved");
        else if (before.path && !saved.sources[s].path)
            left_out.push_back("the path of " + before.name + ", which was moved");
    }
    const NewFile file(edited.file().stem().string() + "-edited", ".json");
    write_edited_scene(read, saved, edited.file(), file.path());
    std::string message = "scene written to " + file.path().string();
    for (std::size_t i = 0; i < left_out.size(); ++i)
        message += (i == 0 ? ", without " : " and ") + left_out[i];
    return message;
}

std::string save_response(const Scene& scene, const FrameView& view,
                          const PlaybackOptions& playback, const std::string& stem) {
    Measurement measurement;
    measurement.sources = {scene.sources[view.source]};
    measurement.receivers = {view.listener};
    measurement.simulation = view.simulation;
    measurement.medium = scene.medium;
    measurement.responses = {view.response};
    measurement.audible = {is_audible(view.response)};
    measurement.parameters = {view_parameters(view, scene.speech)};
    measurement.length_s = view.length_s;
    measurement.frames = 1;

    const NewFile response_file(stem + "-ir", ".wav");
    const NewFile report_file(stem + "-report", ".json");
    const ImpulseResponses impulse_responses(measurement, playback);
    const auto channels = impulse_responses.response(0);
    WavWriter writer(response_file.path(), playback.sample_rate_hz, channels.size(),
                     SampleFormat::float32);
    std::vector<float> interleaved;
    for (std::size_t i = 0; i < channels[0].size(); ++i)
        for (const auto& channel : channels) interleaved.push_back(channel[i]);
    writer.write(interleaved);
    OutputFile report(report_file.path());
    report.write(report_json(measurement));
    writer.commit();
    report.commit();
    return response_file.path().string() + " and " + report_file.path().string() + " written";
}

}  // namespace aula
