#include "apps/window/model/model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <iterator>
#include <limits>
#include <utility>

#include "apps/session/edit/scene_edits.h"

namespace aula {

namespace {

/// The window plays until it is closed, regardless of the scene's duration.
constexpr double kUnlimited_s = 1e6;

}  // namespace

Model::Model(const WindowOptions& options)
    : options_(options), document_(Document{}), library_(material_library()) {
    Loaded loaded = load(options_, options_.scene_file);
    scene_file_ = wanted_file_ = loaded.file;
    file_time_ = loaded.time;
    document_.restart({loaded.scene, loaded.read, {}});
    if (!options_.session.duration_s) options_.session.duration_s = kUnlimited_s;
    player_ = std::make_unique<Player>(scene(), session_of(*loaded.read));
    player_->measure_loudness();
    for (const std::string& warning : player_->warnings()) say(warning);
    for (Setting& setting : settings_)
        setting = {scene().simulation, options_.session.ambisonic_order, false, nullptr, {}};
    good_ = setting();
    requested_ = present_request();
    controls.sources.resize(scene().sources.size());
    other_signals_.resize(scene().sources.size());
    if (!scene().listener.path) controls.listener = scene().listener.pose;
    send_controls();
    geometry_changed(std::move(loaded.rays));
    if (options_.osc) {
        remote_ = std::make_unique<OscRemote>(*options_.osc, *player_, source_names());
        say("listening for OSC on port " + std::to_string(remote_->port()));
    }
}

std::vector<std::string> Model::source_names() const {
    std::vector<std::string> names;
    for (const Source& source : scene().sources) names.push_back(source.name);
    return names;
}

void Model::geometry_changed(std::unique_ptr<RayScene> rays) {
    rays_ = std::move(rays);
    surface_.reset();
    low_ = Vec3(std::numeric_limits<float>::infinity());
    high_ = -low_;
    for (const auto& triangle : rays_->triangles()) {
        for (const Vec3& v : triangle.vertices) {
            low_ = glm::min(low_, v);
            high_ = glm::max(high_, v);
        }
    }
    if (rays_->triangle_count() == 0) {
        low_ = high_ = scene().listener.pose_at(0).position;
        for (const Source& source : scene().sources) {
            low_ = glm::min(low_, source.position_at(0));
            high_ = glm::max(high_, source.position_at(0));
        }
        low_ -= 1.0F;
        high_ += 1.0F;
    }
    ++geometry_version_;
    ++scene_version_;
}

void Model::say(const std::string& text, bool is_error) {
    constexpr std::size_t kMax = 5;
    messages_.push_back({text, is_error, now_s_});
    if (messages_.size() > kMax) messages_.pop_front();
}

void Model::update(double now_s) {
    now_s_ = now_s;
    const std::uint64_t underruns = status_.underruns;
    status_ = player_->status();
    heard_ = player_->monitor_status();
    if (opened_ && !status_.preparing) begin_scene();
    if (status_.muted_samples > 0 && muted_before_ == 0)
        say("samples that are not finite are muted", true);
    muted_before_ = status_.muted_samples;
    if (status_.underruns > underruns) last_underrun_s_ = status_.time_s;
    if (status_.failed_changes > failed_changes_) {
        failed_changes_ = status_.failed_changes;
        requested_.reset();
        say(status_.change_error, true);
        settings_[active_].simulation = good_.simulation;
        settings_[active_].ambisonic_order = good_.ambisonic_order;
    } else if (!status_.preparing && !opened_) {
        good_.simulation = settings_[active_].simulation;
        good_.ambisonic_order = settings_[active_].ambisonic_order;
    }
    if (const auto text = load_news_.take(status_, now_s)) say("this machine " + *text);
    if (heard_.error != recording_error_) {
        recording_error_ = heard_.error;
        if (!recording_error_.empty()) say(recording_error_, true);
    }
    // The player reports the old sources until a change of them plays.
    if (status_.sources.size() > scene().sources.size())
        status_.sources.resize(scene().sources.size());

    Setting& now = settings_[active_];
    const auto newest = player_->view();
    // A view from before the last change does not belong to this setting.
    const bool current = newest && newest->change == status_.heard_change && !status_.preparing &&
                         newest->source < scene().sources.size();
    if (current && newest != now.view) {
        const std::size_t s = newest->source;
        if (s < newest->sources.size())
            now.noise.add(newest->response, newest->sources[s], newest->listener.position,
                          newest->change);
        now.view = newest;
    }
    if (!frozen || !shown_) shown_ = now.view;
    // OSC messages may have changed the controls.
    controls = player_->controls();
    controls.sources.resize(scene().sources.size());
    known_controls_ = controls;
    replace_materials();
    take_results();

    const auto moves = [](const Object& object) { return object.path.has_value(); };
    if (std::any_of(scene().objects.begin(), scene().objects.end(), moves))
        rays_->move(scene_time_s());
    watch_file();
}

/// Session options of a scene; the ambisonic order is that of the setting.
SessionOptions Model::session_of(const LoadedScene& read) const {
    SessionOptions session = options_.session;
    session.rays_fall = !options_.rays_given && !read.rays_given;
    return session;
}

Model::Request Model::present_request() const {
    return {document_.now().scene, setting().simulation, setting().ambisonic_order};
}

void Model::apply() {
    if (requested_ == present_request()) return;
    requested_ = present_request();
    Scene scene_now = scene();
    scene_now.simulation = settings_[active_].simulation;
    SessionOptions session = session_of(*document_.now().read);
    session.ambisonic_order = settings_[active_].ambisonic_order;
    player_->change(scene_now, session);
}

/// False, with a message, while another scene is being opened.
bool Model::may_change() {
    if (opened_) say("no changes while " + opened_->file.filename().string() + " is being opened");
    return !opened_;
}

void Model::send_controls() {
    player_->adjust([this](PlayControls& now, const Pose&) {
        now = with_changes(std::move(now), known_controls_, controls);
    });
    known_controls_ = controls;
}

void Model::walk(const WalkInput& input, double time_s) {
    if (!input.any()) return;
    const Pose from = controls.listener.value_or(status_.listener);
    take_listener(walked(from, input, time_s, collides ? rays_.get() : nullptr));
}

void Model::take_listener(const Pose& pose) {
    controls.listener = pose;
    send_controls();
}

void Model::follow_path() {
    if (!scene().listener.path) return;
    controls.listener.reset();
    send_controls();
}

void Model::move_source(std::size_t source, const Vec3& position) {
    controls.sources[source].position = position;
    send_controls();
}

Model::Document Model::document_with(std::shared_ptr<const Scene> scene_now) const {
    Document document{std::move(scene_now), document_.now().read, {}};
    for (const SourceControl& source : controls.sources)
        document.source_positions.push_back(source.position);
    return document;
}

void Model::source_moved() { document_.change(document_with(document_.now().scene)); }

void Model::play_signal(std::size_t source, std::shared_ptr<const Signal> signal,
                        std::string name) {
    player_->play_signal(source, std::move(signal));
    other_signals_[source] = std::move(name);
}

void Model::play_own_signal(std::size_t source) {
    try {
        play_signal(source, read_signal(scene(), source, player_->sample_rate_hz()), "");
    } catch (const std::exception& thrown) {
        say(thrown.what(), true);
    }
}

void Model::play_test_signal(std::size_t source, TestSignal signal) {
    play_signal(source, test_signal(signal, player_->sample_rate_hz()), test_signal_name(signal));
}

void Model::play_file(std::size_t source, const std::filesystem::path& file) {
    Source wanted = scene().sources[source];
    wanted.signal = Source::Signal::file;
    wanted.signal_file = file;
    wanted.loop = true;
    try {
        const std::string name = file.filename().string();
        play_signal(source, std::make_shared<const Signal>(wanted, player_->sample_rate_hz(), 0),
                    name);
        say(wanted.name + " plays " + name);
    } catch (const std::exception& thrown) {
        say(thrown.what(), true);
    }
}

/// Opens the microphone in the background, which may take a second. All sources share it.
void Model::play_microphone(std::size_t source) {
    const auto listen = [this, source, opens = opens_](std::shared_ptr<Microphone> microphone) {
        if (opens != opens_ || source >= other_signals_.size()) return;
        microphone_ = microphone;
        say("microphone: " + microphone->name());
        const auto read = [microphone](std::int64_t position, std::span<float> out) {
            microphone->read(position, out);
        };
        play_signal(source, std::make_shared<const Signal>(read), "microphone");
    };
    if (auto open = microphone_.lock(); open && open->alive()) return listen(std::move(open));
    constexpr const char* kOpening = "opening the microphone";
    if (at_work(kOpening)) return;
    in_background(kOpening,
                  [listen, output = player_->device(), rate_hz = player_->sample_rate_hz(),
                   block = options_.session.block]() -> Result {
                      auto opened = std::make_shared<Microphone>(output, rate_hz, block);
                      return [listen, opened] { listen(opened); };
                  });
}

bool Model::at_work(std::string_view what) const {
    return std::any_of(work_.begin(), work_.end(), [&](const Work& w) { return w.what == what; });
}

void Model::in_background(std::string what, std::function<Result()> work) {
    work_.push_back({std::move(what), std::async(std::launch::async, std::move(work))});
}

std::string Model::busy() const {
    if (opened_) return "opening " + opened_->file.filename().string();
    return work_.empty() ? "" : work_.back().what;
}

void Model::take_results() {
    const auto done = std::partition(work_.begin(), work_.end(), [](const Work& work) {
        return work.result.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
    });
    std::vector<Work> ready(std::make_move_iterator(done), std::make_move_iterator(work_.end()));
    work_.erase(done, work_.end());
    for (Work& work : ready) {
        try {
            work.result.get()();
        } catch (const std::exception& thrown) {
            say(thrown.what(), true);
        }
    }
}

void Model::set_simulation(const Simulation& simulation, int ambisonic_order) {
    if (!may_change()) return;
    settings_[active_].simulation = simulation;
    settings_[active_].ambisonic_order = ambisonic_order;
    apply();
}

void Model::set_rays(int rays) {
    settings_[active_].simulation.rays = rays;
    settings_[active_].rays_given = true;
    controls.rays = rays;
    send_controls();
}

void Model::switch_setting() {
    if (!may_change()) return;
    active_ = 1 - active_;
    controls.rays = setting().rays_given ? std::optional(setting().simulation.rays) : std::nullopt;
    send_controls();
    apply();
    say(active_ == 0 ? "playing setting A" : "playing setting B");
}

void Model::pick(std::uint32_t triangle) {
    Surface surface{surface_of(*rays_, triangle), triangle, 0};
    for (const std::uint32_t t : surface.triangles) {
        surface.area_m2 += rays_->triangle(t).area_m2();
    }
    surface_ = std::move(surface);
}

const Material& Model::surface_material() const { return material_of(scene(), surface_->picked); }

void Model::give_material(const Material& material, bool everywhere) {
    if (!may_change()) return;
    const auto triangles =
        everywhere ? triangles_like(scene(), surface_->picked) : surface_->triangles;
    scene_edited(std::make_shared<const Scene>(with_material(scene(), triangles, material)));
}

/// Plays a scene with other materials.
void Model::scene_edited(std::shared_ptr<const Scene> edited) {
    document_.change(document_with(std::move(edited)));
    scene_differs();
    apply();
}

/// Discards the other setting's view: it belongs to the previous room.
void Model::scene_differs() {
    ++scene_version_;
    settings_[1 - active_].view.reset();
    settings_[1 - active_].noise = {};
}

void Model::replace_materials() {
    if (!remote_ || opened_) return;
    auto edited = document_.now().scene;
    for (const auto& [from, to] : remote_->take_materials()) {
        if (auto next = with_material_replaced(*edited, from, to))
            edited = std::make_shared<const Scene>(std::move(*next));
        else
            say("OSC: unknown material \"" + from + "\" or \"" + to + "\"", true);
    }
    if (edited == document_.now().scene) return;
    // Consecutive messages form one undo step.
    if (edited_remotely_ == document_.now().scene) document_.undo();
    scene_edited(edited);
    edited_remotely_ = edited;
}

void Model::step(void (Undo<Document>::*direction)()) {
    const auto before = document_.now().scene;
    (document_.*direction)();
    if (document_.now().scene != before) scene_changed(*before, nullptr);
    const Document& now = document_.now();
    for (std::size_t s = 0; s < controls.sources.size(); ++s)
        controls.sources[s].position =
            s < now.source_positions.size() ? now.source_positions[s] : std::nullopt;
    send_controls();
    if (now.scene != before) apply();
}

/// Updates all state that depends on the scene. Builds `rays` if null and the geometry changed.
void Model::scene_changed(const Scene& before, std::unique_ptr<RayScene> rays) {
    const auto named = [](const Source& a, const Source& b) { return a.name == b.name; };
    if (!std::equal(scene().sources.begin(), scene().sources.end(), before.sources.begin(),
                    before.sources.end(), named)) {
        controls.sources.assign(scene().sources.size(), {});
        other_signals_.assign(scene().sources.size(), "");
        request.source = 0;
        watch();
        shown_.reset();
        for (Setting& setting : settings_) setting.view.reset();
        if (remote_) remote_->set_sources(source_names());
    }
    scene_differs();
    if (!same_geometry(scene(), before))
        geometry_changed(rays ? std::move(rays) : std::make_unique<RayScene>(scene()));
}

void Model::undo() {
    if (can_undo() && may_change()) step(&Undo<Document>::undo);
}

void Model::redo() {
    if (can_redo() && may_change()) step(&Undo<Document>::redo);
}

}  // namespace aula
