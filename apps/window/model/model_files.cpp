#include <algorithm>
#include <utility>

#include "apps/session/base/formatted.h"
#include "apps/session/base/output_file.h"
#include "apps/session/edit/scene_edits.h"
#include "apps/session/edit/scene_writer.h"
#include "apps/session/offline/measurement_text.h"
#include "apps/window/model/model.h"

// File operations of the model.

namespace aula {

namespace {

std::filesystem::file_time_type time_of(const std::filesystem::path& file) {
    std::error_code none;
    return std::filesystem::last_write_time(file, none);
}

}  // namespace

Model::Loaded Model::load(const WindowOptions& options, const std::filesystem::path& file) {
    const auto time = time_of(file);
    auto read = std::make_shared<const LoadedScene>(options.load(file));
    Scene scene = read->scene;
    if (options.change) options.change(scene);
    for (Source& source : scene.sources) source.loop = true;
    auto rays = std::make_unique<RayScene>(scene);
    return {std::make_shared<const Scene>(std::move(scene)), std::move(read), std::move(rays), file,
            time};
}

/// Loads a scene; passes it to `take` if `is_newest` still holds at the end.
void Model::load_in_background(std::string what, const std::filesystem::path& file,
                               std::function<bool()> is_newest, void (Model::*take)(Loaded)) {
    in_background(std::move(what),
                  [this, file, take, is_newest = std::move(is_newest), options = options_,
                   rate_hz = player_->sample_rate_hz()]() -> Result {
                      auto loaded = std::make_shared<Loaded>(load(options, file));
                      // Errors of sound files must surface before anything changes.
                      read_signals(*loaded->scene, rate_hz);
                      return [this, take, is_newest, loaded] {
                          if (is_newest()) (this->*take)(std::move(*loaded));
                      };
                  });
}

void Model::open(const std::filesystem::path& file) {
    wanted_file_ = file;
    load_in_background(
        "opening " + file.filename().string(), file,
        [this, open = ++opens_] { return open == opens_; }, &Model::play_scene);
}

/// Starts another scene; begin_scene() shows it once it plays.
void Model::play_scene(Loaded loaded) {
    SessionOptions session = session_of(*loaded.read);
    session.ambisonic_order = settings_[active_].ambisonic_order;
    opened_change_ = player_->change(*loaded.scene, session, true);
    opened_ = std::move(loaded);
}

/// Shows the opened scene, unless playing it failed.
void Model::begin_scene() {
    Loaded loaded = std::move(*opened_);
    opened_.reset();
    if (status_.heard_change < opened_change_) return;
    scene_file_ = loaded.file;
    file_time_ = loaded.time;
    document_.restart({loaded.scene, loaded.read, {}});
    for (Setting& setting : settings_)
        setting = {scene().simulation, setting.ambisonic_order, false, nullptr, {}};
    active_ = 0;
    good_ = setting();
    requested_ = present_request();
    known_controls_ = controls = {};  // the player resets its controls, too
    controls.sources.resize(scene().sources.size());
    other_signals_.assign(scene().sources.size(), "");
    if (!scene().listener.path) controls.listener = scene().listener.pose;
    send_controls();
    request.source = 0;
    watch();
    shown_.reset();
    geometry_changed(std::move(loaded.rays));
    if (remote_) remote_->set_sources(source_names());
    say("playing " + scene_file_.filename().string());
}

void Model::open_next(int step_count) {
    const auto& scenes = options_.scenes;
    if (scenes.size() < 2) return;
    const auto here = std::find(scenes.begin(), scenes.end(), wanted_file_);
    const auto count = static_cast<std::ptrdiff_t>(scenes.size());
    const auto at = here == scenes.end() ? 0 : here - scenes.begin() + step_count;
    open(scenes[static_cast<std::size_t>((at % count + count) % count)]);
}

/// Reloads the scene file after an edit; errors are shown as messages.
void Model::watch_file() {
    constexpr double kInterval_s = 0.5;
    if (opened_ || now_s_ < file_checked_s_ + kInterval_s) return;
    file_checked_s_ = now_s_;
    const auto changed = time_of(scene_file_);
    if (changed == file_time_) return;
    file_time_ = changed;
    load_in_background(
        "reading " + scene_file_.filename().string(), scene_file_,
        [this, open = opens_, edit = ++edits_] { return open == opens_ && edit == edits_; },
        &Model::take_edit);
}

void Model::take_edit(Loaded loaded) {
    const auto before = document_.now().scene;
    document_.change({loaded.scene, loaded.read, {}});
    settings_[active_].simulation = loaded.scene->simulation;
    scene_changed(*before, std::move(loaded.rays));
    // Positions and rays of the file apply again.
    for (SourceControl& source : controls.sources) source.position.reset();
    controls.rays.reset();
    send_controls();
    apply();
    // Earlier errors of the file are obsolete.
    const std::string name = scene_file_.filename().string();
    std::erase_if(messages_, [&](const Message& message) {
        return message.is_error && message.text.find(name) != std::string::npos;
    });
    say(name + " reloaded");
}

void Model::toggle_recording() {
    try {
        if (heard_.recording) {
            player_->stop_recording();
            recording_.reset();
            // update() shows errors.
            const MonitorStatus done = player_->monitor_status();
            if (done.error.empty() && done.lost_s == 0) say("recording written");
            if (done.lost_s > 0)
                say(formatted("the disk was too slow: %.2f s of the recording are missing",
                              done.lost_s),
                    true);
        } else {
            recording_.emplace(scene_file_.stem().string() + "-heard", ".wav");
            player_->record(recording_->path());
            say("recording to " + recording_->path().string());
        }
    } catch (const std::exception& thrown) {
        recording_.reset();
        say(thrown.what(), true);
    }
}

void Model::save_response() {
    constexpr const char* kSaving = "saving the response";
    if (!shown_ || at_work(kSaving)) return;
    Scene measured = scene();
    measured.sources = {measured.sources[shown_->source]};
    measured.listener.pose = shown_->listener;
    measured.listener.path.reset();
    measured.simulation = shown_->simulation;
    SessionOptions session = options_.session;
    session.sample_rate_hz = player_->sample_rate_hz();
    session.ambisonic_order = settings_[active_].ambisonic_order;
    Measurement measurement;
    measurement.responses = {shown_->response};
    measurement.audible = {is_audible(shown_->response)};
    measurement.length_s = shown_->length_s;
    measurement.frames = 1;
    const std::string stem = scene_file_.stem().string();
    // Reading the HRTF takes a second.
    in_background(kSaving, [=, this]() -> Result {
        const NewFile response_file(stem + "-ir", ".wav");
        const NewFile report_file(stem + "-report", ".json");
        const auto channels = impulse_response(measured, 0, measurement, session,
                                               hrtf_for(session, session.sample_rate_hz));
        WavWriter writer(response_file.path(), session.sample_rate_hz, channels.size(),
                         SampleFormat::float32);
        std::vector<float> interleaved;
        for (std::size_t i = 0; i < channels[0].size(); ++i)
            for (const auto& channel : channels) interleaved.push_back(channel[i]);
        writer.write(interleaved);
        OutputFile report(report_file.path());
        report.write(report_json(measured, room_parameters(measurement)));
        writer.commit();
        report.commit();
        const std::string done =
            response_file.path().string() + " and " + report_file.path().string() + " written";
        return [this, done] { say(done); };
    });
}

void Model::save_scene() {
    const LoadedScene& read = *document_.now().read;
    Scene saved = scene();
    saved.simulation = settings_[active_].simulation;
    std::string left_out = "comments";
    for (std::size_t s = 0; s < saved.sources.size(); ++s) {
        const SourceControl& control = controls.sources[s];
        Source& source = saved.sources[s];
        source.loop = read.scene.sources[s].loop;
        if (control.gain_db) source.gain_db = *control.gain_db;
        if (!control.position) continue;
        source.position = *control.position;
        if (source.path) left_out += " and the path of " + source.name + ", which was moved";
        source.path.reset();
    }
    // A listener with a path follows it again in the saved scene; the walk is not saved.
    if (controls.listener && !saved.listener.path) saved.listener.pose = *controls.listener;
    try {
        const NewFile file(scene_file_.stem().string() + "-edited", ".json");
        write_edited_scene(read, saved, scene_file_, file.path());
        say("scene written to " + file.path().string() + ", without " + left_out);
    } catch (const std::exception& thrown) {
        say(thrown.what(), true);
    }
}

}  // namespace aula
