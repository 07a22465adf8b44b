#include "apps/window/model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "apps/session/measurement_text.h"
#include "apps/session/output_file.h"
#include "apps/session/scene_edits.h"
#include "apps/session/scene_writer.h"

namespace aula {

namespace {

/// A window plays until it is closed, whatever the scene says.
constexpr double kWithoutEnd_s = 1e6;

/// NAME.wav, or NAME-2.wav and so on where that is taken, in the working directory.
std::filesystem::path free_name(const std::string& stem, const std::string& extension) {
    for (int number = 1;; ++number) {
        const std::filesystem::path name =
            stem + (number > 1 ? "-" + std::to_string(number) : "") + extension;
        if (!std::filesystem::exists(name)) return name;
    }
}

std::filesystem::file_time_type time_of(const std::filesystem::path& file) {
    std::error_code none;
    return std::filesystem::last_write_time(file, none);
}

bool same_geometry(const Scene& a, const Scene& b) {
    if (a.objects.size() != b.objects.size()) return false;
    for (std::size_t i = 0; i < a.objects.size(); ++i) {
        if (a.objects[i].vertices != b.objects[i].vertices ||
            a.objects[i].triangles != b.objects[i].triangles)
            return false;
    }
    return true;
}

}  // namespace

Model::Model(const WindowOptions& options)
    : options_(options),
      scene_file_(options.scene_file),
      file_time_(time_of(scene_file_)),
      document_({std::make_shared<const Scene>(load_endless(scene_file_)), {}}),
      library_(material_library()) {
    if (!options_.session.duration_s) options_.session.duration_s = kWithoutEnd_s;
    player_ = std::make_unique<Player>(scene(), options_.session);
    player_->measure_loudness();
    for (const std::string& warning : player_->warnings()) say(warning);
    for (Setting& setting : settings_)
        setting = {scene().simulation, options_.session.ambisonic_order, nullptr, {}};
    controls.sources.resize(scene().sources.size());
    test_signals_.resize(scene().sources.size());
    if (!scene().listener.path) controls.listener = scene().listener.pose;
    hand_over();
    geometry_changed();
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

/// A scene whose sources go on for ever.
Scene Model::load_endless(const std::filesystem::path& file) {
    Scene loaded = options_.load(file);
    loops_.clear();
    for (Source& source : loaded.sources) {
        loops_.push_back(source.loop);
        source.loop = true;
    }
    return loaded;
}

void Model::geometry_changed() {
    rays_ = std::make_unique<RayScene>(scene());
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
    constexpr std::size_t kMost = 5;
    messages_.push_back({text, is_error, now_s_});
    if (messages_.size() > kMost) messages_.pop_front();
}

void Model::update(double now_s) {
    now_s_ = now_s;
    const std::uint64_t underruns = status_.underruns;
    status_ = player_->status();
    heard_ = player_->monitor_status();
    if (status_.underruns > underruns) last_underrun_s_ = status_.time_s;
    if (status_.change_error != change_error_) {
        change_error_ = status_.change_error;
        if (!change_error_.empty()) say(change_error_, true);
    }
    if (!heard_.error.empty() && !heard_.recording) say(heard_.error, true);

    Setting& now = settings_[active_];
    const auto newest = player_->view();
    // A view of what played before the last change is not of this setting.
    const bool current = newest && newest->changes == status_.changes && !status_.preparing;
    if (current && newest != now.view) {
        const std::size_t s = newest->source;
        if (s < newest->sources.size())
            now.noise.add(newest->response, newest->sources[s], newest->listener.position,
                          newest->changes);
        now.view = newest;
    }
    if (!frozen || !shown_) shown_ = now.view;
    // Others may have moved something: OSC.
    controls = player_->controls();
    controls.sources.resize(scene().sources.size());
    replace_materials();
    if (saving_.valid() && saving_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
        try {
            say(saving_.get());
        } catch (const std::exception& thrown) {
            say(thrown.what(), true);
        }
    }

    const auto moves = [](const Object& object) { return object.path.has_value(); };
    if (std::any_of(scene().objects.begin(), scene().objects.end(), moves))
        rays_->move(scene_time_s());
    watch_file();
}

void Model::apply(bool starts_anew) {
    Scene scene_now = scene();
    scene_now.simulation = settings_[active_].simulation;
    SessionOptions session = options_.session;
    session.ambisonic_order = settings_[active_].ambisonic_order;
    player_->change(scene_now, session, starts_anew);
}

void Model::walk(const WalkInput& input, double time_s) {
    if (!input.any()) return;
    const Pose from = controls.listener.value_or(status_.listener);
    take_listener(walked(from, input, time_s, collides ? rays_.get() : nullptr));
}

void Model::take_listener(const Pose& pose) {
    controls.listener = pose;
    hand_over();
}

void Model::follow_path() {
    if (!scene().listener.path) return;
    controls.listener.reset();
    hand_over();
}

void Model::move_source(std::size_t source, const Vec3& position) {
    controls.sources[source].position = position;
    hand_over();
}

Model::Document Model::document_with(std::shared_ptr<const Scene> scene_now) const {
    Document document{std::move(scene_now), {}};
    for (const SourceControl& source : controls.sources)
        document.source_positions.push_back(source.position);
    return document;
}

void Model::source_moved() { document_.change(document_with(document_.now().scene)); }

void Model::play_test_signal(std::size_t source, std::optional<TestSignal> signal) {
    try {
        player_->play_signal(source, signal
                                         ? test_signal(*signal, player_->sample_rate_hz())
                                         : read_signal(scene(), source, player_->sample_rate_hz()));
        test_signals_[source] = signal;
    } catch (const std::exception& thrown) {
        say(thrown.what(), true);
    }
}

void Model::play_file(std::size_t source, const std::filesystem::path& file) {
    Source wanted = scene().sources[source];
    wanted.signal = Source::Signal::file;
    wanted.signal_file = file;
    wanted.loop = true;
    try {
        player_->play_signal(source,
                             std::make_shared<const Signal>(wanted, player_->sample_rate_hz(), 0));
        test_signals_[source].reset();
        say(wanted.name + " plays " + file.filename().string());
    } catch (const std::exception& thrown) {
        say(thrown.what(), true);
    }
}

std::optional<TestSignal> Model::test_signal_of(std::size_t source) const {
    return test_signals_[source];
}

void Model::set_simulation(const Simulation& simulation, int ambisonic_order) {
    settings_[active_].simulation = simulation;
    settings_[active_].ambisonic_order = ambisonic_order;
    apply(false);
}

void Model::switch_setting() {
    active_ = 1 - active_;
    apply(false);
    say(active_ == 0 ? "A is heard" : "B is heard");
}

void Model::pick(std::uint32_t triangle) {
    Surface surface{surface_of(*rays_, triangle), triangle, 0};
    for (const std::uint32_t t : surface.triangles) {
        const auto& v = rays_->triangle(t).vertices;
        surface.area_m2 += glm::length(glm::cross(v[1] - v[0], v[2] - v[0])) / 2;
    }
    surface_ = std::move(surface);
}

const Material& Model::surface_material() const { return material_of(scene(), surface_->picked); }

void Model::give_material(const Material& material, bool everywhere) {
    const auto triangles =
        everywhere ? triangles_like(scene(), surface_->picked) : surface_->triangles;
    scene_edited(std::make_shared<const Scene>(with_material(scene(), triangles, material)));
}

/// Takes over a scene of other materials.
void Model::scene_edited(std::shared_ptr<const Scene> edited) {
    document_.change(document_with(std::move(edited)));
    ++scene_version_;
    apply(false);
}

void Model::replace_materials() {
    if (!remote_) return;
    for (const auto& [from, to] : remote_->take_materials()) {
        auto edited = with_material_replaced(scene(), from, to);
        if (edited)
            scene_edited(std::make_shared<const Scene>(std::move(*edited)));
        else
            say("OSC: no material \"" + from + "\" here, or none \"" + to + "\"", true);
    }
}

void Model::step(void (Undo<Document>::*direction)()) {
    const auto before = document_.now().scene;
    (document_.*direction)();
    const Document& now = document_.now();
    for (std::size_t s = 0; s < controls.sources.size(); ++s)
        controls.sources[s].position =
            s < now.source_positions.size() ? now.source_positions[s] : std::nullopt;
    hand_over();
    if (now.scene == before) return;
    if (same_geometry(*now.scene, *before))
        ++scene_version_;
    else
        geometry_changed();
    apply(false);
}

void Model::undo() {
    if (can_undo()) step(&Undo<Document>::undo);
}

void Model::redo() {
    if (can_redo()) step(&Undo<Document>::redo);
}

void Model::open(const std::filesystem::path& file) {
    try {
        Scene loaded = load_endless(file);
        scene_file_ = file;
        file_time_ = time_of(file);
        document_.restart({std::make_shared<const Scene>(std::move(loaded)), {}});
        for (Setting& setting : settings_)
            setting = {scene().simulation, setting.ambisonic_order, nullptr, {}};
        active_ = 0;
        controls = {};
        controls.sources.resize(scene().sources.size());
        test_signals_.assign(scene().sources.size(), std::nullopt);
        if (!scene().listener.path) controls.listener = scene().listener.pose;
        shown_.reset();
        geometry_changed();
        if (remote_) remote_->set_sources(source_names());
        apply(true);
        say("opening " + file.filename().string());
    } catch (const std::exception& thrown) {
        say(thrown.what(), true);
    }
}

void Model::open_next(int step_count) {
    const auto& scenes = options_.scenes;
    if (scenes.size() < 2) return;
    const auto here = std::find(scenes.begin(), scenes.end(), scene_file_);
    const auto count = static_cast<std::ptrdiff_t>(scenes.size());
    const auto at = here == scenes.end() ? 0 : here - scenes.begin() + step_count;
    open(scenes[static_cast<std::size_t>((at % count + count) % count)]);
}

/// Takes over a scene file that was edited; what is wrong with it is said.
void Model::watch_file() {
    constexpr double kInterval_s = 0.5;
    if (now_s_ < file_looked_at_s_ + kInterval_s) return;
    file_looked_at_s_ = now_s_;
    const auto changed = time_of(scene_file_);
    if (changed == file_time_) return;
    file_time_ = changed;
    try {
        const auto before = document_.now().scene;
        auto loaded = std::make_shared<const Scene>(load_endless(scene_file_));
        const bool same_sources = loaded->sources.size() == before->sources.size();
        if (!same_sources) {
            controls.sources.assign(loaded->sources.size(), {});
            test_signals_.assign(loaded->sources.size(), std::nullopt);
        }
        // What the file says of places counts again.
        for (SourceControl& source : controls.sources) source.position.reset();
        document_.change({loaded, {}});
        settings_[active_].simulation = loaded->simulation;
        if (same_geometry(*loaded, *before))
            ++scene_version_;
        else
            geometry_changed();
        hand_over();
        apply(false);
        say(scene_file_.filename().string() + " was edited: taken over");
    } catch (const std::exception& thrown) {
        say(thrown.what(), true);
    }
}

void Model::toggle_recording() {
    try {
        if (heard_.recording) {
            player_->stop_recording();
            say("recording written");
        } else {
            const auto file = free_name(scene_file_.stem().string() + "-heard", ".wav");
            player_->record(file);
            say("recording to " + file.string());
        }
    } catch (const std::exception& thrown) {
        say(thrown.what(), true);
    }
}

void Model::save_response() {
    if (!shown_ || saving_.valid()) return;
    Scene measured = scene();
    measured.sources = {measured.sources[shown_->source]};
    measured.listener.pose = shown_->listener;
    measured.listener.path.reset();
    measured.simulation = shown_->simulation;
    SessionOptions session = options_.session;
    session.sample_rate_hz = player_->sample_rate_hz();
    session.ambisonic_order = settings_[active_].ambisonic_order;
    const Measurement measurement{{shown_->response}, shown_->length_s, 1};
    const std::string stem = scene_file_.stem().string();
    // The HRTF takes a second to read.
    saving_ = std::async(std::launch::async, [=] {
        const auto response_file = free_name(stem + "-ir", ".wav");
        const auto report_file = free_name(stem + "-report", ".json");
        const auto channels = impulse_response(measured, 0, measurement, session,
                                               hrtf_for(session, session.sample_rate_hz));
        WavWriter writer(response_file, session.sample_rate_hz, channels.size(),
                         SampleFormat::float32);
        std::vector<float> interleaved;
        for (std::size_t i = 0; i < channels[0].size(); ++i)
            for (const auto& channel : channels) interleaved.push_back(channel[i]);
        writer.write(interleaved);
        OutputFile report(report_file);
        report.write(report_json(measured, room_parameters(measurement)));
        writer.commit();
        report.commit();
        return response_file.string() + " and " + report_file.string() + " written";
    });
}

void Model::save_scene() {
    Scene saved = scene();
    saved.simulation = settings_[active_].simulation;
    for (std::size_t s = 0; s < saved.sources.size(); ++s) {
        const SourceControl& control = controls.sources[s];
        saved.sources[s].loop = loops_[s];
        if (control.gain_db) saved.sources[s].gain_db = *control.gain_db;
        if (!control.position) continue;
        saved.sources[s].position = *control.position;
        saved.sources[s].path.reset();
    }
    if (controls.listener) {
        saved.listener.pose = *controls.listener;
        saved.listener.path.reset();
    }
    try {
        const auto file = free_name(scene_file_.stem().string() + "-edited", ".json");
        write_scene(saved, file);
        say("scene written to " + file.string());
    } catch (const std::exception& thrown) {
        say(thrown.what(), true);
    }
}

}  // namespace aula
