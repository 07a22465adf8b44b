#include "aula/auralizer.h"

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <string>
#include <utility>

#include "apps/room/auralizer/auralizer_state.h"
#include "apps/room/auralizer/command_checks.h"
#include "apps/room/auralizer/exact_playback.h"
#include "apps/room/auralizer/real_time_playback.h"
#include "apps/room/frames/ray_budget.h"
#include "aula/audio/realtime.h"
#include "aula/exception.h"

namespace aula {

namespace {

AuralizerOptions checked(AuralizerOptions options, const Scene& scene) {
    check_options(options);
    options.max_sources = std::max({options.max_sources, scene.sources.size(), std::size_t{1}});
    return options;
}

}  // namespace

Auralizer::State::State(const Scene& scene_in, AuralizerOptions options_in,
                        std::shared_ptr<const Hrtf> hrtf_in)
    : scene(scene_in), options(checked(std::move(options_in), scene)), hrtf(std::move(hrtf_in)) {}

// Resets priority, rounding and denormal modes, which this thread inherits from the calling thread
// and the engine's threads from this one.
void Auralizer::State::build() {
    leave_realtime();
    std::fesetenv(FE_DFL_ENV);
    if (options.clock == RenderClock::exact) {
        playback = std::make_unique<ExactPlayback>(scene, options, hrtf);
    } else {
        // The caller waits for the room, also with processors that are busy. Threads of the engine
        // keep the priority of this one; a single one has none.
        if (scene.simulation.threads != 1) lower_priority(kPropagationNice);
        playback = std::make_unique<RealTimePlayback>(scene, options, hrtf);
        playback->change_room(kNow, [rays = live_rays(scene.simulation)](FrameRoom& room) {
            room.state.rays = rays;
        });
    }
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

void Auralizer::State::check_object(std::size_t object) const {
    if (object >= scene.objects.size())
        throw InputError("auralizer: there is no object " + std::to_string(object));
}

Auralizer::Auralizer(const Scene& scene, AuralizerOptions options)
    : Auralizer(std::make_unique<State>(scene, std::move(options))) {
    state_->begin();
}

Auralizer::Auralizer(std::unique_ptr<State> state) : state_(std::move(state)) {
    State& s = *state_;
    s.thread = std::thread([this, &s] {
        try {
            s.build();
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
    state_->check_object(object);
    const Object& moved = state_->scene.objects[object];
    if (!moved.moves())
        throw InputError("auralizer: the object " +
                         (moved.name.empty() ? std::to_string(object) : '"' + moved.name + '"') +
                         " is not movable");
    check_transform(transform);
    state_->playback->change_room(
        at, [object, transform](FrameRoom& room) { room.state.objects[object] = transform; });
}

void Auralizer::set_material(std::size_t object, const std::string& name, std::int64_t at) {
    set_material(object, state_->scene.find_material(name), at);
}

void Auralizer::set_material(std::size_t object, const Material& material, std::int64_t at) {
    state_->check_object(object);
    check_material(material);
    state_->playback->change_room(at, [object, material](FrameRoom& room) {
        room.materials.insert_or_assign(object, material);
    });
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
    return state_->playback->computer().response_length_s();
}

double Auralizer::heard_length_s() const { return state_->playback->heard_length_s(); }

float Auralizer::patch_size_m() const { return state_->playback->computer().patch_size_m(); }

std::int64_t Auralizer::tail_samples() const { return state_->playback->tail_samples(); }

std::vector<std::vector<float>> Auralizer::impulse_response(SourceId source,
                                                            std::size_t listener) const {
    if (listener >= state_->options.listeners) return {};
    return state_->playback->impulse_response(source, listener);
}

bool Auralizer::visible(SourceId source, std::size_t listener) const {
    return state_->playback->computer().visible(source, listener);
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
        for (std::size_t o = 0; o < scene.objects.size(); ++o)
            if (scene.objects[o].path)
                auralizer.set_transform(o, scene.objects[o].transform_at(time_s));
    };
}

}  // namespace aula
