#include "apps/room/auralizer/room_playback.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

namespace aula {

namespace {

/// Another scene replaces the present one: listeners, gains of parts and the share of the frame
/// period stay, and the sources, unless the scene has others. Objects and materials are those of
/// the scene.
RoomState state_in_scene(RoomState state, const BuiltRoom& next) {
    if (next.sources == BuiltRoom::Sources::of_scene)
        state.sources = room_state(*next.scene, 0).sources;
    std::erase_if(state.sources,
                  [](const SourceState& source) { return source.removed_at.has_value(); });
    state.objects.clear();
    for (const Object& object : next.scene->objects)
        state.objects.push_back(object.transform_at(0));
    state.rays = next.rays;
    return state;
}

void begin(FrameRoom& room, std::shared_ptr<BuiltRoom> next, std::uint64_t number) {
    room.state = state_in_scene(std::move(room.state), *next);
    room.slots = SourceSlots(next->computer.config().sources);
    for (SourceState& source : room.state.sources) source.slot = room.slots.begin({source.id});
    room.materials.clear();
    room.built = std::move(next);
    room.scene = number;
}

}  // namespace

RoomPlayback::RoomPlayback(std::shared_ptr<BuiltRoom> first, const AuralizerOptions& options,
                           int block)
    : rate_hz_(options.sample_rate_hz),
      listeners_(options.listeners),
      before_frame_(options.before_frame),
      pause_(rate_hz_, block),
      exchange_(rooms_, rate_hz_, block),
      tail_samples_(first->sounding->tail_samples()),
      room_outputs_(options.listeners * channel_count(options.output),
                    std::vector<float>(static_cast<std::size_t>(block))),
      room_weights_(static_cast<std::size_t>(block)),
      sources_(options.max_sources),
      room_{.state = room_state(*first->scene, 0), .slots = SourceSlots(0)},
      built_(std::move(first)),
      present_(built_) {
    for (std::vector<float>& output : room_outputs_) room_pointers_.push_back(output.data());
    room_.state.listeners.assign(listeners_, Pose(room_.state.listeners[0]));
    room_.poses_ns.resize(listeners_);
    sources_.restart(room_.state.sources.size(), options.max_sources);
    begin(room_, built_, 0);
    scenes_.push_back({{kNow}, 0, built_});
    newest().begin(room_.slots, room_.state.listeners);
    rooms_.publish(std::move(built_->made));
}

void RoomPlayback::run(Auralizer& auralizer) {
    {
        const std::lock_guard lock(mutex_);
        frame_thread_ = std::this_thread::get_id();
    }
    try {
        compute_frames(auralizer);
    } catch (...) {
        const std::lock_guard lock(mutex_);
        failure_ = std::current_exception();
        changes_ = {};
    }
    changed_.notify_all();
}

void RoomPlayback::stop() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    changed_.notify_all();
}

SourceId RoomPlayback::add_source(const NewSource& source, std::int64_t at) {
    const std::lock_guard lock(mutex_);
    if (failure_) return {};
    const ChangeTime time = time_of(at);
    const SourceId id = sources_.add(time);
    SourceState state{
        .id = id.number,
        .name = source.name.empty() ? "source " + std::to_string(id.number) : source.name,
        .pose = {source.position, source.yaw_rad, source.pitch_rad, source.roll_rad},
        .directivity = source.directivity,
        .gain_db = source.gain_db};
    changes_.add(time, [state](FrameRoom& room) mutable {
        state.slot = room.slots.begin({state.id});
        // The slot's ringing source ends.
        std::erase_if(room.state.sources,
                      [&](const SourceState& other) { return other.slot == state.slot; });
        room.state.sources.push_back(state);
    });
    begin_source(id, time);
    return id;
}

void RoomPlayback::remove_source(SourceId source, std::int64_t at) {
    const std::lock_guard lock(mutex_);
    if (failure_) return;
    const std::optional<ChangeTime> time = sources_.remove(source, time_of(at));
    if (!time) return;
    changes_.add(*time, [source, at = time->sample](FrameRoom& room) {
        room.slots.end(source);
        for (SourceState& state : room.state.sources)
            if (state.id == source.number) state.removed_at = at;
    });
    end_source(source, *time);
}

std::vector<SourceId> RoomPlayback::sources() const {
    const std::lock_guard lock(mutex_);
    return sources_.sources();
}

void RoomPlayback::change_source(SourceId source, std::int64_t at,
                                 std::function<void(SourceState&)> change) {
    const std::lock_guard lock(mutex_);
    if (failure_) return;
    changes_.add(sources_.after_beginning(source, time_of(at)),
                 [number = source.number, change = std::move(change)](FrameRoom& room) {
                     for (SourceState& state : room.state.sources)
                         if (state.id == number && !state.removed_at) change(state);
                 });
}

void RoomPlayback::set_listener(std::size_t listener, const Pose& pose, std::int64_t at) {
    const std::lock_guard lock(mutex_);
    if (failure_) return;
    const ChangeTime time = time_of(at);
    changes_.add(time, [listener, pose, set_ns = pose_ns()](FrameRoom& room) {
        room.state.listeners[listener] = pose;
        if (room.poses_ns[listener] == 0) room.poses_ns[listener] = set_ns;
    });
    turn_head(listener, pose, time);
}

void RoomPlayback::change_room(std::int64_t at, std::function<void(FrameRoom&)> change) {
    const std::lock_guard lock(mutex_);
    if (failure_) return;
    changes_.add(time_of(at), std::move(change));
}

void RoomPlayback::change_scene(std::uint64_t number, std::int64_t at,
                                std::function<void(FrameRoom&)> change) {
    change_room(at, [number, change = std::move(change)](FrameRoom& room) {
        if (room.scene == number) change(room);
    });
}

std::uint64_t RoomPlayback::begin_scene(std::shared_ptr<BuiltRoom> next, std::int64_t at) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t number = ++last_scene_;
    if (failure_) return number;
    const ChangeTime time = time_of(at);
    if (next->sources == BuiltRoom::Sources::of_scene)
        sources_.restart(next->scene->sources.size(), next->max_sources);
    const auto later = std::upper_bound(
        scenes_.begin(), scenes_.end(), time,
        [](const ChangeTime& added, const SceneTime& scene) { return added < scene.begin; });
    scenes_.insert(later, {time, number, next});
    if (in_before_frame() && time <= time_of(kNow)) frame_scene_ = number;
    changes_.add(time,
                 [next = std::move(next), number](FrameRoom& room) { begin(room, next, number); });
    announce_scene();
    return number;
}

/// The mutex is locked. Commands of before_frame refer to the scene that was there when it was
/// called.
const RoomPlayback::SceneTime& RoomPlayback::scene_of(const ChangeTime& time) const {
    if (in_before_frame() && time <= time_of(kNow)) {
        const auto of_frame =
            std::find_if(scenes_.begin(), scenes_.end(),
                         [this](const SceneTime& scene) { return scene.number == frame_scene_; });
        return *of_frame;
    }
    const auto after = std::upper_bound(
        scenes_.begin() + 1, scenes_.end(), time,
        [](const ChangeTime& given, const SceneTime& scene) { return given < scene.begin; });
    return *(after - 1);
}

RoomPlayback::NumberedScene RoomPlayback::scene_at(std::int64_t at) const {
    const std::lock_guard lock(mutex_);
    const SceneTime& found = scene_of(time_of(at));
    return {found.built->scene, found.number};
}

std::shared_ptr<const BuiltRoom> RoomPlayback::present() const {
    const std::lock_guard lock(mutex_);
    return present_;
}

RoomState RoomPlayback::state_in(const BuiltRoom& next) const {
    const std::lock_guard lock(mutex_);
    return state_in_scene(room_.state, next);
}

AuralizerStatus RoomPlayback::status() const {
    {
        const std::lock_guard lock(mutex_);
        if (failure_) std::rethrow_exception(failure_);
    }
    AuralizerStatus status = present()->computer.status();
    status.samples = rendered_.load();
    status.paused = pause_.silent();
    status.muted_samples = muted_.load();
    return status;
}

void RoomPlayback::call_before_frame(Auralizer& auralizer, std::int64_t sample, double time_s) {
    if (!before_frame_) return;
    {
        const std::lock_guard lock(mutex_);
        frame_scene_ = scene_of({sample, true}).number;
        frame_sample_ = sample;
    }
    before_frame_(auralizer, time_s);
    const std::lock_guard lock(mutex_);
    frame_sample_.reset();
}

bool RoomPlayback::apply_changes(std::int64_t until, std::int64_t now, double time_s) {
    const std::lock_guard lock(mutex_);
    return apply(until, now, time_s, false);
}

/// The mutex is locked.
bool RoomPlayback::apply(std::int64_t until, std::int64_t now, double time_s,
                         bool may_begin_scene) {
    const bool begins = scenes_.size() > 1 && scenes_[1].begin.sample <= until;
    if (begins && !may_begin_scene) return false;
    changes_.apply(until, room_);
    sources_.forget(now);
    if (begins) {
        built_ = room_.built;
        computer().continue_counts(present_->computer);
        const auto begun =
            std::find_if(scenes_.begin(), scenes_.end(),
                         [this](const SceneTime& scene) { return scene.number == room_.scene; });
        std::move(scenes_.begin(), begun, std::back_inserter(ended_));
        scenes_.erase(scenes_.begin(), begun);
        newest().begin(room_.slots, room_.state.listeners);
        take_scene(newest());
    }
    std::erase_if(room_.state.sources, [&](const SourceState& source) {
        return source.removed_at &&
               now - *source.removed_at >=
                   built_->tail_samples(computer().longest_delay_s({source.id}));
    });
    room_.state.time_s = time_s;
    return true;
}

void RoomPlayback::finish_beginning() {
    std::vector<SceneTime> ended;  // destroyed after the lock
    std::shared_ptr<BuiltRoom> before;
    const std::lock_guard lock(mutex_);
    std::swap(ended, ended_);
    before = std::exchange(present_, built_);
}

std::vector<std::vector<float>> RoomPlayback::impulse_response(SourceId source,
                                                               std::size_t listener) const {
    const std::shared_ptr<const BuiltRoom> room = present();
    auto response = room->computer.impulse_response(source, listener);
    if (room->headphones && !response.empty()) equalize(*room->headphones, response);
    return response;
}

std::int64_t RoomPlayback::newest_tail_samples() const {
    double longest_s = 0;
    for (const SourceState& source : room_.state.sources)
        longest_s = std::max(longest_s, built_->computer.longest_delay_s({source.id}));
    return built_->tail_samples(longest_s);
}

std::optional<FrameRoom> RoomPlayback::take_changes(std::int64_t until, std::int64_t now,
                                                    double time_s, bool may_begin_scene) {
    const std::lock_guard lock(mutex_);
    if (!apply(until, now, time_s, may_begin_scene)) return {};
    FrameRoom room = room_;
    room_.materials.clear();
    std::fill(room_.poses_ns.begin(), room_.poses_ns.end(), 0);
    return room;
}

void RoomPlayback::render_rooms(std::span<const SourceSignal> inputs, int offset,
                                std::span<const float> weights, std::span<float* const> outputs,
                                int samples) noexcept {
    exchange_.render(samples, [&](SoundingRoom& room, std::span<float> input_weights,
                                  std::span<const float> output_weights) {
        const bool plays = &room == exchange_.playing();
        const std::int64_t sample = rendered_.load(std::memory_order_relaxed);
        std::span<const float> given = weights;
        if (!input_weights.empty()) {
            std::copy(input_weights.begin(), input_weights.end(), room_weights_.begin());
            apply_weights(weights, room_weights_.data());
            given = std::span(room_weights_).first(input_weights.size());
        }
        const std::span<float* const> heard = plays ? outputs : room_pointers_;
        if (room.signals) {
            room.renderer.render(room.signals->read(sample, samples), 0, given, heard, samples);
            room.signals->end(sample, heard, samples);
        } else {
            room.renderer.render(inputs, offset, given, heard, samples);
        }
        if (const std::int64_t muted = room.renderer.take_muted(); muted > 0)
            muted_.fetch_add(muted, std::memory_order_relaxed);
        if (plays) return;
        for (std::size_t c = 0; c < outputs.size(); ++c) {
            apply_weights(output_weights, heard[c]);
            for (int n = 0; n < samples; ++n) outputs[c][n] += heard[c][n];
        }
    });
}

}  // namespace aula
