#pragma once

#include <array>
#include <deque>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/session/frames/play_controls.h"
#include "apps/session/live/load_news.h"
#include "apps/session/live/player.h"
#include "apps/session/remote/osc_remote.h"
#include "apps/window/model/new_file.h"
#include "apps/window/model/test_signals.h"
#include "apps/window/model/undo.h"
#include "apps/window/model/window_options.h"
#include "apps/window/view/curves.h"
#include "apps/window/view/first_person.h"
#include "aula/devices/microphone.h"
#include "aula/engine/material_library.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// State and actions of the window, independent of the toolkit: the player, the edited scene, two
/// settings to compare, the selected surface, messages. [window's thread]
class Model {
 public:
    /// A simulation setting, with the newest view and noise measured while it played.
    struct Setting {
        Simulation simulation;
        int ambisonic_order = 1;
        bool rays_given = false;  ///< by set_rays(): not reduced under overload
        std::shared_ptr<const FrameView> view;
        FrameNoise noise;
    };

    struct Message {
        std::string text;
        bool is_error = false;
        double time_s = 0;  ///< by the window's clock
    };

    /// A surface picked with the mouse.
    struct Surface {
        std::vector<std::uint32_t> triangles;
        std::uint32_t picked = 0;
        float area_m2 = 0;
    };

    explicit Model(const WindowOptions& options);

    /// Updates status, views and watched files; call it once per frame. `now_s` is the window's
    /// clock.
    void update(double now_s);

    Player& player() { return *player_; }
    const PlayStatus& status() const { return status_; }
    const MonitorStatus& heard() const { return heard_; }
    double last_underrun_s() const { return last_underrun_s_; }

    const Scene& scene() const { return *document_.now().scene; }
    const std::filesystem::path& scene_file() const { return scene_file_; }
    const RayScene& rays() const { return *rays_; }
    std::uint64_t geometry_version() const { return geometry_version_; }
    std::uint64_t scene_version() const { return scene_version_; }
    Vec3 low() const { return low_; }
    Vec3 high() const { return high_; }
    double scene_time_s() const { return status_.scene_time_s; }

    // Playback.
    PlayControls controls;  ///< call send_controls() after a change
    void send_controls();
    void walk(const WalkInput& input, double time_s);
    void take_listener(const Pose& pose);
    void follow_path();
    bool follows_path() const { return scene().listener.path && !controls.listener; }
    bool collides = true;
    void move_source(std::size_t source, const Vec3& position);
    void source_moved();  ///< ends a move: adds an undo step
    void play_own_signal(std::size_t source);
    void play_test_signal(std::size_t source, TestSignal signal);
    void play_microphone(std::size_t source);
    void play_file(std::size_t source, const std::filesystem::path& file);
    /// Name of the signal that replaces a source's signal; empty: none.
    const std::string& other_signal(std::size_t source) const { return other_signals_[source]; }

    // Settings.
    const Setting& setting() const { return settings_[active_]; }
    const Setting& other_setting() const { return settings_[1 - active_]; }
    std::size_t active() const { return active_; }
    bool compares() const { return settings_[1 - active_].view != nullptr; }
    void set_simulation(const Simulation& simulation, int ambisonic_order);
    void set_rays(int rays);  ///< takes effect in the next frame
    void switch_setting();

    // The view.
    ViewRequest request;  ///< call watch() after a change
    void watch() { player_->watch(request); }
    std::shared_ptr<const FrameView> view() const { return shown_; }
    bool frozen = false;

    // Surfaces.
    const std::vector<LibraryMaterial>& library() const { return library_; }
    const std::optional<Surface>& surface() const { return surface_; }
    void pick(std::uint32_t triangle);
    void deselect() { surface_.reset(); }
    const Material& surface_material() const;
    void give_material(const Material& material, bool everywhere);
    bool can_undo() const { return document_.can_undo(); }
    bool can_redo() const { return document_.can_redo(); }
    void undo();
    void redo();

    // Files. Long operations run in the background, while the old scene plays.
    void open(const std::filesystem::path& file);
    void open_next(int step);
    void toggle_recording();
    void save_scene();
    void save_response();  ///< impulse response and report of the shown view

    /// Name of the background job, such as "opening church.json"; empty: none.
    std::string busy() const;

    const std::deque<Message>& messages() const { return messages_; }
    void say(const std::string& text, bool is_error = false);

 private:
    /// The state that undo restores.
    struct Document {
        std::shared_ptr<const Scene> scene;
        std::shared_ptr<const LoadedScene> read;  ///< the scene as read from its file
        std::vector<std::optional<Vec3>> source_positions;
    };

    /// A scene as the window plays it: all signals loop.
    struct Loaded {
        std::shared_ptr<const Scene> scene;
        std::shared_ptr<const LoadedScene> read;
        std::unique_ptr<RayScene> rays;
        std::filesystem::path file;
        std::filesystem::file_time_type time;
    };
    static Loaded load(const WindowOptions& options, const std::filesystem::path& file);
    void load_in_background(std::string what, const std::filesystem::path& file,
                            std::function<bool()> is_newest, void (Model::*take)(Loaded));

    /// The last part of a background job; update() calls it on the window's thread.
    using Result = std::function<void()>;
    struct Work {
        std::string what;
        std::future<Result> result;
    };

    bool at_work(std::string_view what) const;
    void in_background(std::string what, std::function<Result()> work);
    void take_results();
    void play_signal(std::size_t source, std::shared_ptr<const Signal> signal, std::string name);
    void play_scene(Loaded loaded);
    void begin_scene();
    void take_edit(Loaded loaded);
    bool may_change();
    /// Plays the present scene and setting; does nothing if they play already.
    void apply();
    struct Request {
        std::shared_ptr<const Scene> scene;
        Simulation simulation;
        int ambisonic_order = 1;
        friend bool operator==(const Request&, const Request&) = default;
    };
    Request present_request() const;
    void step(void (Undo<Document>::*direction)());
    SessionOptions session_of(const LoadedScene& read) const;
    Document document_with(std::shared_ptr<const Scene> scene) const;
    void scene_changed(const Scene& before, std::unique_ptr<RayScene> rays);
    void geometry_changed(std::unique_ptr<RayScene> rays);
    void watch_file();
    void replace_materials();
    void scene_edited(std::shared_ptr<const Scene> edited);
    void scene_differs();
    std::vector<std::string> source_names() const;

    WindowOptions options_;
    std::filesystem::path scene_file_;
    std::filesystem::path wanted_file_;  ///< last file to open, including failures
    std::filesystem::file_time_type file_time_;
    Undo<Document> document_;
    std::optional<NewFile> recording_;  ///< destroyed after the player that writes it
    std::unique_ptr<Player> player_;
    std::unique_ptr<OscRemote> remote_;  ///< destroyed before the player that it controls
    std::vector<Work> work_;
    std::uint64_t opens_ = 0;          ///< number of opens begun; only the newest counts
    std::uint64_t edits_ = 0;          ///< the same for reloads of the shown scene
    std::optional<Loaded> opened_;     ///< shown once it plays
    std::uint64_t opened_change_ = 0;  ///< its change number
    std::shared_ptr<const Scene> edited_remotely_;  ///< newest scene made by OSC
    std::weak_ptr<Microphone> microphone_;
    std::unique_ptr<RayScene> rays_;
    std::uint64_t geometry_version_ = 0;
    std::uint64_t scene_version_ = 0;
    Vec3 low_{0};
    Vec3 high_{0};
    std::vector<LibraryMaterial> library_;
    PlayControls known_controls_;  ///< as last read from the player
    std::array<Setting, 2> settings_;
    std::size_t active_ = 0;
    std::optional<Surface> surface_;
    std::vector<std::string> other_signals_;  ///< [source]
    PlayStatus status_;
    MonitorStatus heard_;
    std::shared_ptr<const FrameView> shown_;
    double last_underrun_s_ = -1;
    std::uint64_t failed_changes_ = 0;
    std::int64_t muted_before_ = 0;
    Setting good_;                      ///< the last setting that played
    std::optional<Request> requested_;  ///< requested of the player; empty after a failure
    LoadNews load_news_;
    std::string recording_error_;
    double now_s_ = 0;
    double file_checked_s_ = 0;
    std::deque<Message> messages_;
};

}  // namespace aula
