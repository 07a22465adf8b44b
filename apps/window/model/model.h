#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "apps/documents/receiver_grid.h"
#include "apps/room/frames/play_controls.h"
#include "apps/room/live/player.h"
#include "apps/room/remote/osc_remote.h"
#include "apps/window/model/background_jobs.h"
#include "apps/window/model/edited_scene.h"
#include "apps/window/model/message_log.h"
#include "apps/window/model/new_file.h"
#include "apps/window/model/playback_messages.h"
#include "apps/window/model/setting_comparison.h"
#include "apps/window/model/source_signals.h"
#include "apps/window/model/window_options.h"
#include "apps/window/view/first_person.h"
#include "apps/window/view/level_walk.h"
#include "apps/window/view/standing_waves.h"
#include "aula/engine/material_library.h"
#include "aula/measurement.h"

namespace aula {

/// A measured map of a room.
struct MappedRoom {
    ReceiverGrid grid;
    Measurement measurement;  ///< of all sources at the receivers of the grid
};

/// State and actions of the window, independent of the toolkit: joins the edited scene, the
/// compared settings and the sources' signals with the player. [window's thread]
class Model {
 public:
    explicit Model(const WindowOptions& options);

    /// Updates status, views and watched files; call it once per frame. `now_s` is the window's
    /// clock.
    void update(double now_s);

    Player& player() { return *player_; }
    const PlayStatus& status() const { return status_; }
    const MonitorStatus& monitor_status() const { return monitor_status_; }
    /// Whether the sound is discarded: no device could be opened, or none was wanted.
    bool is_silent() const { return player_->device().name == AudioDevice::kNone; }
    double last_underrun_s() const { return playback_messages_.last_underrun_s(); }

    const Scene& scene() const { return scene_.scene(); }
    const std::filesystem::path& scene_file() const { return scene_.file(); }
    const RayScene& rays() const { return scene_.rays(); }
    std::uint64_t geometry_version() const { return scene_.geometry_version(); }
    std::uint64_t scene_version() const { return scene_.version(); }
    const Bounds& bounds() const { return scene_.bounds(); }
    double scene_time_s() const { return status_.scene_time_s; }

    // Playback. OSC messages change the controls, too.
    const PlayControls& controls() const { return controls_; }
    template <typename T>
    void set_control(T PlayControls::*control, const std::type_identity_t<T>& value) {
        adjust([&](PlayControls& now) { now.*control = value; });
    }
    template <typename T>
    void set_control(std::size_t source, T SourceControl::*control,
                     const std::type_identity_t<T>& value) {
        adjust([&](PlayControls& now) { now.sources[source].*control = value; });
    }
    void walk(const WalkInput& input, double time_s);
    void take_listener(const Pose& pose) { set_control(&PlayControls::listener, pose); }
    void follow_path();
    bool follows_path() const { return scene().listener.path && !controls_.listener; }
    bool collides = true;
    void move_source(std::size_t source, const Vec3& position);
    void source_moved();  ///< ends a move: adds an undo step
    void play_own_signal(std::size_t source);
    void play_test_signal(std::size_t source, TestSignal signal);
    void play_microphone(std::size_t source);
    void play_file(std::size_t source, const std::filesystem::path& file);
    /// Name of the signal that replaces a source's signal; empty: none.
    const std::string& other_signal(std::size_t source) const { return signals_.name(source); }

    // Settings.
    using Setting = SettingComparison::Setting;
    const Setting& setting() const { return settings_.active(); }
    const Setting& other_setting() const { return settings_.other(); }
    std::size_t active() const { return settings_.active_index(); }
    bool compares() const { return settings_.compares(); }
    void set_simulation(const Simulation& simulation, int ambisonic_order);
    void set_quality(Quality quality);  ///< replaces the number of rays, also an automatic one
    void set_rays(int rays);            ///< takes effect in the next frame
    void switch_setting();

    // The view.
    ViewRequest request;  ///< call watch() after a change
    void watch() { player_->watch(request); }
    std::shared_ptr<const FrameView> view() const { return shown_; }
    /// The parameters of the view, as reports have them; empty values without a view.
    const PairParameters& parameters() const { return parameters_; }

    /// The levels of the direct sound where the listener walked.
    const LevelWalk& level_walk() const { return level_walk_; }
    bool frozen = false;

    // Surfaces.
    const std::vector<LibraryMaterial>& library() const { return library_; }
    const std::optional<EditedScene::Surface>& surface() const { return scene_.surface(); }
    void pick(std::uint32_t triangle) { scene_.pick(triangle); }
    void deselect() { scene_.deselect(); }
    const Material& surface_material() const;
    void give_material(const Material& material, bool everywhere);
    bool can_undo() const { return scene_.can_undo(); }
    bool can_redo() const { return scene_.can_redo(); }
    void undo();
    void redo();

    // A map of the parameters, measured in the background: of the scene as it plays, at time 0.
    void start_map(double height_m, double spacing_m);
    void cancel_map() { map_job_.cancel(); }
    std::optional<double> map_progress() const;  ///< 0..1; empty: no map is being measured
    /// The newest map; null: none of this geometry.
    std::shared_ptr<const MappedRoom> map() const { return map_; }
    /// False after changes of materials, settings or source positions.
    bool map_is_current() const;

    // The modes of the room at a height, found in the background: of the scene as it plays, at
    // time 0.
    void start_standing_waves(double height_m);
    bool finds_standing_waves() const;
    /// The newest ones; null: none of this geometry.
    std::shared_ptr<const StandingWaves> standing_waves() const { return waves_; }

    // Files. Long operations run in the background; meanwhile the present scene plays.
    /// Opens a scene or a model. Any other file is a sound, which the selected source plays.
    void take_file(const std::filesystem::path& file);
    void open(const std::filesystem::path& file);
    void open_next(int step);
    void toggle_recording();
    void save_scene();
    void save_response();  ///< impulse response and report of the shown view

    /// Whether a change of the scene or the setting has yet to become audible.
    bool changes() const { return opened_ || status_.audible_change < requested_change_; }

    /// Name of the background job, such as "opening church.json"; empty: none.
    std::string busy() const;

    const std::deque<MessageLog::Message>& messages() const { return log_.messages(); }

 private:
    /// What the player plays or prepares.
    struct PlayedSetting {
        std::shared_ptr<const Scene> scene;
        Simulation simulation;
        int ambisonic_order = 1;
        friend bool operator==(const PlayedSetting&, const PlayedSetting&) = default;
    };

    /// The state of a measurement in the background. [any thread]
    struct MapProgress {
        std::atomic<double> done{0};
        std::atomic<bool> cancelled{false};
        std::atomic<bool> ended{false};

        /// Marks the end, also after exceptions.
        struct End {
            MapProgress& progress;
            ~End() { progress.ended = true; }
        };
    };

    /// Cancels the measurement of a map when destroyed.
    struct MapJob {
        std::shared_ptr<MapProgress> progress;

        MapJob() = default;
        ~MapJob() { cancel(); }
        MapJob(const MapJob&) = delete;
        MapJob& operator=(const MapJob&) = delete;
        bool runs() const { return progress && !progress->ended; }
        void cancel() {
            if (progress) progress->cancelled = true;
        }
    };

    /// Runs an action; an exception becomes a message.
    template <typename Action>
    void attempt(const Action& action) {
        try {
            action();
        } catch (const std::exception& thrown) {
            log_.say(thrown.what(), true);
        }
    }

    void adjust(const std::function<void(PlayControls&)>& change);
    void read_controls();
    PlaybackOptions playback_options() const;
    PlayedSetting wanted_setting() const;
    void apply();
    bool may_change();

    EditedScene::SourcePositions source_positions() const;
    void scene_changed(const EditedScene::Change& change);
    void scene_stepped(const EditedScene::Change& change);
    void restart_sources();
    void replace_materials();
    void drop_old_map();

    void load_in_background(std::string what, const std::filesystem::path& file,
                            std::function<bool()> is_newest, void (Model::*take)(OpenedScene));
    void play_scene(OpenedScene opened);
    void show_opened();
    void say_warnings();
    void watch_file();
    void take_edit(OpenedScene opened);

    WindowOptions options_;
    MessageLog log_;
    PlaybackMessages playback_messages_;
    EditedScene scene_;
    SettingComparison settings_;
    std::vector<LibraryMaterial> library_;
    std::optional<NewFile> recording_;  ///< destroyed after the player that writes it
    std::unique_ptr<Player> player_;
    std::unique_ptr<OscRemote> remote_;  ///< destroyed before the player that it controls
    SourceSignals signals_;
    BackgroundJobs jobs_;
    MapJob map_job_;  ///< destroyed before the jobs, which its destructor ends
    std::shared_ptr<const MappedRoom> map_;
    std::optional<PlayedSetting> map_setting_;
    EditedScene::SourcePositions map_positions_;
    std::uint64_t map_version_ = 0;  ///< of the geometry
    std::shared_ptr<const StandingWaves> waves_;
    std::uint64_t waves_version_ = 0;    ///< of the geometry
    std::filesystem::path wanted_file_;  ///< last file to open, including failures
    std::uint64_t opens_ = 0;            ///< number of files opened; only the newest is shown
    std::uint64_t edits_ = 0;            ///< number of reloads of the shown scene
    std::optional<OpenedScene> opened_;  ///< shown once it plays
    std::uint64_t opened_change_ = 0;    ///< its change number
    PlayControls controls_;              ///< as last read from the player
    PlayStatus status_;
    MonitorStatus monitor_status_;
    std::shared_ptr<const FrameView> shown_;
    std::shared_ptr<const FrameView> measured_;  ///< the view of the parameters
    PairParameters parameters_;
    LevelWalk level_walk_;                    ///< of the shown views
    std::optional<PlayedSetting> requested_;  ///< from the player; empty after a failure
    std::uint64_t requested_change_ = 0;      ///< its change number
    double now_s_ = 0;
};

}  // namespace aula
