#include "apps/window/model/model.h"

#include <utility>

#include "apps/room/edit/scene_edits.h"

namespace aula {

namespace {

/// The window plays until it is closed, regardless of the scene's duration.
WindowOptions without_end(WindowOptions options) {
    if (!options.playback.duration_s) options.playback.duration_s = PlaybackOptions::kUnlimited_s;
    return options;
}

/// The player of a scene. Where no sound device can be opened and none was asked for, it plays in
/// silence: the room can be seen and edited, and its response is computed.
std::unique_ptr<Player> opened_player(const Scene& scene, PlaybackOptions playback,
                                      const std::function<void(const std::string&)>& warn) {
    try {
        return std::make_unique<Player>(scene, playback);
    } catch (const Failure& failure) {
        if (!playback.device.empty()) throw;
        playback.device = AudioDevice::kNone;
        auto silent = std::make_unique<Player>(scene, playback);
        warn(failure.what() + std::string("; playing in silence"));
        return silent;
    }
}

}  // namespace

Model::Model(const WindowOptions& options)
    : options_(without_end(options)),
      scene_(open_scene(options_, options_.scene_file)),
      settings_(scene().simulation, options_.playback.ambisonic_order),
      library_(material_library()),
      player_(opened_player(scene(), playback_options(), options_.warn)),
      signals_(player_->sample_rate_hz(),
               [this](std::size_t source, std::shared_ptr<const Signal> signal) {
                   player_->play_signal(source, std::move(signal));
               }),
      wanted_file_(options_.scene_file),
      requested_(wanted_setting()) {
    player_->measure_loudness();
    for (const std::string& warning : player_->warnings()) log_.say(warning);
    say_warnings();
    signals_.restart(scene().sources.size());
    if (!scene().listener.path) take_listener(scene().listener.pose);
    read_controls();
    if (options_.osc) {
        remote_ = std::make_unique<OscRemote>(*options_.osc, *player_, scene());
        log_.say("listening for OSC on port " + std::to_string(remote_->port()));
        log_.say(remote_->region_text());
    }
}

void Model::update(double now_s) {
    now_s_ = now_s;
    log_.set_time(now_s);
    status_ = player_->status();
    monitor_status_ = player_->monitor_status();
    if (status_.sample_rate_hz != signals_.sample_rate_hz())
        signals_.set_sample_rate(status_.sample_rate_hz);
    if (opened_ && (status_.audible_change >= opened_change_ || !status_.preparing)) show_opened();
    if (playback_messages_.take(status_, monitor_status_, now_s, log_)) {
        requested_.reset();
        requested_change_ = 0;
        settings_.revert();
    } else if (!changes()) {
        settings_.confirm();
    }
    // Until a change of sources plays, the player reports the previous ones.
    if (status_.sources.size() > scene().sources.size())
        status_.sources.resize(scene().sources.size());

    // A view from before the last change does not belong to this setting. The player's own changes,
    // which adapt the response to the machine, do not matter: they may follow each other for long.
    const auto newest = player_->view();
    if (newest && newest->change == status_.audible_change && !changes() &&
        newest->source < scene().sources.size())
        settings_.add_view(newest);
    if (!frozen || !shown_) shown_ = setting().view;
    if (shown_) level_walk_.add(*shown_);
    if (shown_ != measured_) {
        measured_ = shown_;
        parameters_ = shown_ ? view_parameters(*shown_, scene().speech) : PairParameters();
    }
    read_controls();
    replace_materials();
    jobs_.finish([this](const std::string& error) { log_.say(error, true); });
    drop_old_map();
    scene_.move_objects(scene_time_s());
    watch_file();
}

/// Options of the playback of a scene; the ambisonic order is that of the setting.
PlaybackOptions Model::playback_options() const {
    PlaybackOptions playback = options_.playback;
    playback.rays_fall = !options_.rays_given;
    playback.ambisonic_order = setting().ambisonic_order;
    return playback;
}

Model::PlayedSetting Model::wanted_setting() const {
    return {scene_.shared_scene(), setting().simulation, setting().ambisonic_order};
}

/// Plays the present scene and setting; does nothing if they play already.
void Model::apply() {
    if (requested_ == wanted_setting()) return;
    requested_ = wanted_setting();
    Scene played = scene();
    played.simulation = setting().simulation;
    requested_change_ = player_->change(played, playback_options());
}

/// False, with a message, while another scene is being opened.
bool Model::may_change() {
    if (opened_)
        log_.say("no changes while " + opened_->file.filename().string() + " is being opened");
    return !opened_;
}

/// Changes controls of the player; the others keep their present values.
void Model::adjust(const std::function<void(PlayControls&)>& change) {
    player_->adjust([&](PlayControls& now, const Pose&) {
        if (now.sources.size() < scene().sources.size()) now.sources.resize(scene().sources.size());
        change(now);
    });
    read_controls();
}

void Model::read_controls() {
    controls_ = player_->controls();
    controls_.sources.resize(scene().sources.size());
}

void Model::walk(const WalkInput& input, double time_s) {
    if (!input.any()) return;
    const Pose from = controls_.listener.value_or(status_.listener);
    take_listener(walked(from, input, time_s, collides ? &rays() : nullptr));
}

void Model::follow_path() {
    if (scene().listener.path) set_control(&PlayControls::listener, std::nullopt);
}

void Model::move_source(std::size_t source, const Vec3& position) {
    set_control(source, &SourceControl::position, position);
}

EditedScene::SourcePositions Model::source_positions() const {
    EditedScene::SourcePositions positions;
    for (const SourceControl& source : controls_.sources) positions.push_back(source.position);
    return positions;
}

void Model::source_moved() { scene_.move_sources(source_positions()); }

void Model::play_own_signal(std::size_t source) {
    attempt([&] { signals_.play_own(scene(), source); });
}

void Model::play_test_signal(std::size_t source, TestSignal signal) {
    signals_.play_test(source, signal);
}

void Model::play_file(std::size_t source, const std::filesystem::path& file) {
    attempt([&] {
        signals_.play_file(source, file);
        log_.say(scene().sources[source].name + " plays " + signals_.name(source));
    });
}

/// Opens the microphone in the background, which may take a second. All sources share it.
void Model::play_microphone(std::size_t source) {
    const auto play = [this, source, opens = opens_](const std::shared_ptr<Microphone>& opened) {
        if (opens != opens_ || source >= signals_.source_count()) return;
        signals_.play_microphone(source, opened);
        log_.say("microphone: " + opened->name());
    };
    if (const auto open = signals_.open_microphone()) return play(open);
    constexpr const char* kOpening = "opening the microphone";
    if (jobs_.runs(kOpening)) return;
    jobs_.start(kOpening,
                [play, output = player_->device(), rate_hz = player_->sample_rate_hz(),
                 block = options_.playback.block]() -> BackgroundJobs::LastPart {
                    auto opened = std::make_shared<Microphone>(output, rate_hz, block);
                    return [play, opened] { play(opened); };
                });
}

void Model::set_simulation(const Simulation& simulation, int ambisonic_order) {
    if (!may_change()) return;
    settings_.set(simulation, ambisonic_order);
    apply();
}

void Model::set_quality(Quality quality) {
    if (!may_change()) return;
    Simulation simulation = setting().simulation;
    simulation.quality = quality;
    simulation.rays.reset();
    adjust([](PlayControls& now) {
        now.rays.reset();
        now.frame_share.reset();
    });
    set_simulation(simulation, setting().ambisonic_order);
}

void Model::set_rays(int rays) {
    settings_.set_rays(rays);
    set_control(&PlayControls::rays, rays);
}

void Model::switch_setting() {
    if (!may_change()) return;
    settings_.switch_active();
    set_control(&PlayControls::rays,
                setting().rays_given ? setting().simulation.rays : std::nullopt);
    apply();
    log_.say(active() == 0 ? "playing setting A" : "playing setting B");
}

const Material& Model::surface_material() const { return material_of(scene(), surface()->picked); }

void Model::give_material(const Material& material, bool everywhere) {
    if (!may_change()) return;
    const auto triangles =
        everywhere ? triangles_like(scene(), surface()->picked) : surface()->triangles;
    scene_changed(scene_.edit(with_material(scene(), triangles, material), source_positions()));
    apply();
}

void Model::replace_materials() {
    if (!remote_ || opened_) return;
    std::optional<Scene> edited;
    for (const auto& [from, to] : remote_->take_materials()) {
        if (auto next = with_material_replaced(edited ? *edited : scene(), from, to))
            edited = std::move(next);
        else
            log_.say("OSC: unknown material \"" + from + "\" or \"" + to + "\"", true);
    }
    if (!edited) return;
    scene_changed(scene_.edit_remotely(std::move(*edited), source_positions()));
    apply();
}

/// Updates what depends on the scene.
void Model::scene_changed(const EditedScene::Change& change) {
    if (change.sources) {
        cancel_map();
        adjust([&](PlayControls& now) { now.sources.assign(scene().sources.size(), {}); });
        restart_sources();
        settings_.discard_views();
    }
    if (change.scene) settings_.discard_other_view();
}

/// Restarts signals, view and OSC after a change of the sources; the first source is selected.
void Model::restart_sources() {
    signals_.restart(scene().sources.size());
    request.source = 0;
    watch();
    shown_.reset();
    if (remote_) remote_->set_scene(scene());
}

/// After undo or redo.
void Model::scene_stepped(const EditedScene::Change& change) {
    scene_changed(change);
    EditedScene::SourcePositions positions = scene_.source_positions();
    positions.resize(scene().sources.size());
    adjust([&](PlayControls& now) {
        for (std::size_t s = 0; s < positions.size(); ++s) now.sources[s].position = positions[s];
    });
    if (change.scene) apply();
}

void Model::undo() {
    if (can_undo() && may_change()) scene_stepped(scene_.undo());
}

void Model::redo() {
    if (can_redo() && may_change()) scene_stepped(scene_.redo());
}

std::string Model::busy() const {
    return opened_ ? "opening " + opened_->file.filename().string() : jobs_.newest();
}

}  // namespace aula
