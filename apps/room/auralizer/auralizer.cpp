#include "aula/auralizer.h"

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <future>
#include <string>
#include <utility>
#include <vector>

#include "apps/room/auralizer/auralizer_state.h"
#include "apps/room/auralizer/command_checks.h"
#include "apps/room/auralizer/exact_playback.h"
#include "apps/room/auralizer/real_time_playback.h"
#include "aula/audio/realtime.h"
#include "aula/exception.h"

namespace aula {

namespace {

AuralizerOptions checked(AuralizerOptions options, const Scene& scene) {
    check_options(options);
    options.max_sources = std::max({options.max_sources, scene.sources.size(), std::size_t{1}});
    return options;
}

/// Resets priority, rounding and denormal modes, which a thread that builds a room inherits from
/// the calling thread and the engine's threads from that one.
void prepare_thread(const AuralizerOptions& options, const Simulation& simulation) {
    leave_realtime();
    std::fesetenv(FE_DFL_ENV);
    // The caller waits for the room, also with processors that are busy. Threads of the engine
    // keep the priority of this one; a single one has none.
    if (options.clock == RenderClock::real_time && simulation.threads != 1)
        lower_priority(kPropagationNice);
}

/// The largest number of samples that the renderers process together.
int block_of(const AuralizerOptions& options) {
    return options.clock == RenderClock::exact ? ExactPlayback::kBlock : options.block;
}

}  // namespace

Auralizer::State::State(const Scene& scene, AuralizerOptions options_in)
    : options(checked(std::move(options_in), scene)) {}

void Auralizer::State::build(const Scene& scene) {
    prepare_thread(options, scene.simulation);
    auto first = std::make_shared<BuiltRoom>(scene, BuiltRoom::Sources::of_scene, options,
                                             block_of(options), nullptr);
    if (options.clock == RenderClock::exact)
        playback = std::make_unique<ExactPlayback>(std::move(first), options);
    else
        playback = std::make_unique<RealTimePlayback>(std::move(first), options);
}

// On a thread of its own, because the engine's threads inherit its priority.
std::shared_ptr<BuiltRoom> Auralizer::State::build_next(
    const Scene& scene, BuiltRoom::Sources sources, AuralizerOptions next,
    const std::function<void(BuiltRoom&)>& prepare) const {
    next.clock = options.clock;
    if (sources == BuiltRoom::Sources::of_scene) next = checked(std::move(next), scene);
    const std::shared_ptr<const BuiltRoom> present = playback->present();
    const auto build = [&] {
        prepare_thread(next, scene.simulation);
        auto built = std::make_shared<BuiltRoom>(
            scene, sources, next, block_of(next),
            next.hrtf == present->hrtf_file ? present->computer.hrtf() : nullptr);
        if (prepare) prepare(*built);
        return built;
    };
    return std::async(std::launch::async, build).get();
}

Auralizer::State::FoundObject Auralizer::State::find_object(std::size_t index,
                                                            std::int64_t at) const {
    auto found = playback->scene_at(at);
    if (index >= found.scene->objects.size())
        throw InputError("auralizer: there is no object " + std::to_string(index));
    return {std::move(found), index};
}

Auralizer::State::FoundObject Auralizer::State::find_object(const std::string& name,
                                                            std::int64_t at) const {
    auto found = playback->scene_at(at);
    const std::vector<Object>& objects = found.scene->objects;
    const auto object = std::find_if(objects.begin(), objects.end(),
                                     [&](const Object& o) { return o.name == name; });
    if (name.empty() || object == objects.end())
        throw InputError("object: there is no \"" + name + "\" in the room");
    const auto index = static_cast<std::size_t>(object - objects.begin());
    return {std::move(found), index};
}

void Auralizer::State::set_transform(const FoundObject& object, const RigidTransform& transform,
                                     std::int64_t at) {
    const Object& moved = object.of.scene->objects[object.index];
    if (!moved.moves())
        throw InputError(
            "auralizer: the object " +
            (moved.name.empty() ? std::to_string(object.index) : '"' + moved.name + '"') +
            " is not movable");
    check_transform(transform);
    playback->change_scene(object.of.number, at,
                           [index = object.index, transform](FrameRoom& room) {
                               room.state.objects[index] = transform;
                           });
}

void Auralizer::State::set_material(const FoundObject& object, const std::string& name,
                                    std::int64_t at) {
    set_material(object, object.of.scene->find_material(name), at);
}

void Auralizer::State::set_material(const FoundObject& object, const Material& material,
                                    std::int64_t at) {
    check_material(material);
    playback->change_scene(object.of.number, at, [index = object.index, material](FrameRoom& room) {
        room.materials.insert_or_assign(index, material);
    });
}

void Auralizer::State::begin() {
    is_started = true;
    started.set_value(true);
}

void Auralizer::State::end() {
    if (!std::exchange(is_started, true)) started.set_value(false);
    playback->stop();
    if (thread.joinable()) thread.join();
}

Auralizer::Auralizer(const Scene& scene, AuralizerOptions options)
    : Auralizer(scene, std::make_unique<State>(scene, std::move(options))) {
    state_->begin();
}

Auralizer::Auralizer(const Scene& scene, std::unique_ptr<State> state) : state_(std::move(state)) {
    State& s = *state_;
    s.thread = std::thread([this, &s, &scene] {
        try {
            s.build(scene);
        } catch (...) {
            return s.built.set_exception(std::current_exception());
        }
        s.built.set_value();
        if (s.started.get_future().get()) s.playback->run(*this);
    });
    try {
        s.built.get_future().get();
    } catch (...) {
        s.thread.join();
        throw;
    }
}

// Ends the thread before any member is destroyed: it may be in before_frame, which uses this
// object.
Auralizer::~Auralizer() { state_->end(); }

void Auralizer::set_scene(const Scene& scene, std::int64_t at) {
    const std::lock_guard lock(state_->scene_mutex);
    RoomPlayback& playback = *state_->playback;
    const auto warm_up = [&](BuiltRoom& next) { next.computer.warm_up(playback.state_in(next)); };
    // Not on the exact clock: how many frames there are in a time depends on the machine.
    const bool is_exact = state_->options.clock == RenderClock::exact;
    playback.begin_scene(
        state_->build_next(scene, BuiltRoom::Sources::of_room_before, state_->options,
                           is_exact ? std::function<void(BuiltRoom&)>() : warm_up),
        at);
}

std::shared_ptr<const Scene> Auralizer::scene() const {
    return state_->playback->scene_at(kNow).scene;
}

SourceId Auralizer::add_source(const NewSource& source, std::int64_t at) {
    check_pose({source.position, source.yaw_rad, source.pitch_rad, source.roll_rad});
    check_gain(source.gain_db);
    return state_->playback->add_source(source, at);
}

void Auralizer::remove_source(SourceId source, std::int64_t at) {
    state_->playback->remove_source(source, at);
}

std::vector<SourceId> Auralizer::sources() const { return state_->playback->sources(); }

void Auralizer::set_source(SourceId source, const Pose& pose, std::int64_t at) {
    check_pose(pose);
    state_->playback->change_source(source, at, [pose](SourceState& s) { s.pose = pose; });
}

void Auralizer::set_gain(SourceId source, float gain_db, std::int64_t at) {
    check_gain(gain_db);
    state_->playback->change_source(source, at, [gain_db](SourceState& s) { s.gain_db = gain_db; });
}

void Auralizer::set_listener(std::size_t listener, const Pose& pose, std::int64_t at) {
    if (listener >= state_->options.listeners)
        throw InputError("auralizer: there is no listener " + std::to_string(listener));
    check_pose(pose);
    state_->playback->set_listener(listener, pose, at);
}

void Auralizer::set_transform(std::size_t object, const RigidTransform& transform,
                              std::int64_t at) {
    state_->set_transform(state_->find_object(object, at), transform, at);
}

void Auralizer::set_transform(const std::string& object, const RigidTransform& transform,
                              std::int64_t at) {
    state_->set_transform(state_->find_object(object, at), transform, at);
}

void Auralizer::set_material(std::size_t object, const std::string& name, std::int64_t at) {
    state_->set_material(state_->find_object(object, at), name, at);
}

void Auralizer::set_material(std::size_t object, const Material& material, std::int64_t at) {
    state_->set_material(state_->find_object(object, at), material, at);
}

void Auralizer::set_material(const std::string& object, const std::string& name, std::int64_t at) {
    state_->set_material(state_->find_object(object, at), name, at);
}

void Auralizer::set_material(const std::string& object, const Material& material, std::int64_t at) {
    state_->set_material(state_->find_object(object, at), material, at);
}

void Auralizer::set_part_gains(const PartGains& gains, std::int64_t at) {
    check_part_gains(gains);
    state_->playback->change_room(at, [gains](FrameRoom& room) {
        room.state.direct_gain = gains.direct;
        room.state.early_gain = gains.early;
        room.state.late_gain = gains.late;
    });
}

void Auralizer::set_rays(int rays, std::int64_t at) {
    require(rays >= 1 && rays <= Simulation::kMaxRays, "the number of rays is out of range");
    state_->playback->change_room(at, [rays](FrameRoom& room) {
        room.state.rays = rays;
        room.state.frame_share.reset();
    });
}

void Auralizer::set_frame_share(double share) {
    require(state_->options.clock == RenderClock::real_time,
            "rays by computation time are not reproducible, as the exact clock requires");
    require(share >= 0 && std::isfinite(share),
            "the share of the frame period is not a number from 0 on");
    state_->playback->change_room(kNow,
                                  [share](FrameRoom& room) { room.state.frame_share = share; });
}

void Auralizer::commit(std::int64_t until) { state_->playback->commit(until); }

void Auralizer::pause() { state_->playback->set_paused(true); }

void Auralizer::resume() { state_->playback->set_paused(false); }

void Auralizer::render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                       int samples) {
    require(outputs.size() == output_channels(), "outputs are not output_channels() signals");
    state_->playback->render(inputs, outputs, samples);
}

std::size_t Auralizer::output_channels() const {
    return state_->options.listeners * channel_count(state_->options.output);
}

int Auralizer::latency_samples() const { return state_->playback->latency_samples(); }

double Auralizer::sample_rate_hz() const { return state_->options.sample_rate_hz; }

double Auralizer::response_length_s() const {
    return state_->playback->present()->computer.response_length_s();
}

double Auralizer::heard_length_s() const { return state_->playback->present()->heard_length_s(); }

float Auralizer::patch_size_m() const {
    return state_->playback->present()->computer.patch_size_m();
}

std::int64_t Auralizer::tail_samples() const { return state_->playback->tail_samples(); }

std::vector<std::vector<float>> Auralizer::impulse_response(SourceId source,
                                                            std::size_t listener) const {
    if (listener >= state_->options.listeners) return {};
    return state_->playback->impulse_response(source, listener);
}

bool Auralizer::visible(SourceId source, std::size_t listener) const {
    return state_->playback->present()->computer.visible(source, listener);
}

bool Auralizer::silent(SourceId source, std::size_t listener) const {
    return state_->playback->present()->computer.silent(source, listener);
}

AuralizerStatus Auralizer::status() const { return state_->playback->status(); }

std::function<void(Auralizer&, double)> follow_paths(const Scene& scene) {
    return [scene](Auralizer& auralizer, double time_s) {
        for (std::size_t i = 0; i < scene.sources.size(); ++i) {
            // The scene's sources have the first numbers.
            if (scene.sources[i].path)
                auralizer.set_source({i + 1}, scene.sources[i].pose_at(time_s));
        }
        if (scene.listener.path) auralizer.set_listener(scene.listener.pose_at(time_s));
        const std::shared_ptr<const Scene> present = auralizer.scene();
        for (std::size_t o = 0; o < present->objects.size(); ++o)
            if (present->objects[o].path)
                auralizer.set_transform(o, present->objects[o].transform_at(time_s));
    };
}

}  // namespace aula
