#include <algorithm>
#include <exception>
#include <utility>

#include "apps/output/formatted.h"
#include "apps/window/model/model.h"
#include "apps/window/model/saved_files.h"
#include "engine/mesh/mesh_import.h"

// File operations of the model.

namespace aula {

/// Loads a scene and passes it to `take` if `is_newest` is true after loading.
void Model::load_in_background(std::string what, const std::filesystem::path& file,
                               std::function<bool()> is_newest, void (Model::*take)(OpenedScene)) {
    jobs_.start(std::move(what),
                [this, file, take, is_newest = std::move(is_newest), options = options_,
                 rate_hz = player_->sample_rate_hz()]() -> BackgroundJobs::LastPart {
                    auto opened = std::make_shared<OpenedScene>(open_scene(options, file));
                    // Errors of sound files must be found before anything changes.
                    read_signals(*opened->scene, rate_hz);
                    return [this, take, is_newest, opened] {
                        if (is_newest()) (this->*take)(std::move(*opened));
                    };
                });
}

void Model::take_file(const std::filesystem::path& file) {
    if (file.extension() == ".json" || is_mesh_file(file))
        open(file);
    else
        play_file(request.source, file);
}

void Model::open(const std::filesystem::path& file) {
    wanted_file_ = file;
    load_in_background(
        "opening " + file.filename().string(), file,
        [this, open = ++opens_] { return open == opens_; }, &Model::play_scene);
}

/// Starts another scene; show_opened() shows it once it plays.
void Model::play_scene(OpenedScene opened) {
    opened_change_ = player_->change(*opened.scene, playback_options(), true);
    opened_ = std::move(opened);
}

/// Shows the opened scene, unless playing it failed.
void Model::show_opened() {
    OpenedScene opened = std::move(*opened_);
    opened_.reset();
    if (status_.audible_change < opened_change_) return;
    cancel_map();
    scene_.restart(std::move(opened));
    settings_.restart(scene().simulation);
    requested_ = wanted_setting();
    // The player has reset its controls.
    if (!scene().listener.path) take_listener(scene().listener.pose);
    read_controls();
    restart_sources();
    log_.say("playing " + scene_file().filename().string());
    say_warnings();
}

/// Shows the warnings of the scene's file, such as what was guessed of a model, in one message.
void Model::say_warnings() {
    constexpr std::size_t kMaxLines = 5;
    const std::vector<std::string>& warnings = scene_.read().warnings;
    if (warnings.empty()) return;
    std::string text;
    const std::string prefix = scene_file().string() + ": ";
    for (std::size_t i = 0; i < std::min(kMaxLines, warnings.size()); ++i)
        text += (i > 0 ? "\n" : "") +
                (warnings[i].starts_with(prefix) ? warnings[i].substr(prefix.size()) : warnings[i]);
    if (warnings.size() > kMaxLines)
        text += formatted("\nand %zu more", warnings.size() - kMaxLines);
    log_.say(text);
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
    if (opened_ || !scene_.file_changed(now_s_)) return;
    load_in_background(
        "reading " + scene_file().filename().string(), scene_file(),
        [this, open = opens_, edit = ++edits_] { return open == opens_ && edit == edits_; },
        &Model::take_edit);
}

void Model::take_edit(OpenedScene opened) {
    const EditedScene::Change change = scene_.reload(std::move(opened));
    settings_.set(scene().simulation, setting().ambisonic_order);
    scene_changed(change);
    // Poses and rays of the file apply again.
    adjust([](PlayControls& now) {
        for (SourceControl& source : now.sources) {
            source.position.reset();
            source.angles_rad.reset();
        }
        now.rays.reset();
    });
    apply();
    // Earlier errors of the file are obsolete.
    const std::string name = scene_file().filename().string();
    log_.remove_errors(name);
    log_.say(name + " reloaded");
}

void Model::toggle_recording() {
    try {
        if (monitor_status_.recording) {
            player_->stop_recording();
            recording_.reset();
            // Errors are reported by update().
            const MonitorStatus done = player_->monitor_status();
            if (done.error.empty() && done.lost_s == 0) log_.say("recording written");
            if (done.lost_s > 0)
                log_.say(formatted("the disk was too slow: %.2f s of the recording are missing",
                                   done.lost_s),
                         true);
        } else {
            recording_.emplace(scene_file().stem().string() + "-heard", ".wav");
            player_->record(recording_->path());
            log_.say("recording to " + recording_->path().string());
        }
    } catch (const std::exception& thrown) {
        recording_.reset();
        log_.say(thrown.what(), true);
    }
}

void Model::save_response() {
    constexpr const char* kSaving = "saving the response";
    if (!shown_ || jobs_.runs(kSaving)) return;
    PlaybackOptions playback = options_.playback;
    playback.sample_rate_hz = player_->sample_rate_hz();
    playback.ambisonic_order = setting().ambisonic_order;
    jobs_.start(kSaving,
                [this, playback, measured = scene_.shared_scene(), view = shown_,
                 stem = scene_file().stem().string()]() -> BackgroundJobs::LastPart {
                    const std::string saved = aula::save_response(*measured, *view, playback, stem);
                    return [this, saved] { log_.say(saved); };
                });
}

void Model::save_scene() {
    attempt([&] { log_.say(save_played_scene(scene_, controls_, setting().simulation)); });
}

}  // namespace aula
