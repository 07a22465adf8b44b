#include "apps/room/auralizer/real_time_playback.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "apps/room/base/latency.h"
#include "aula/audio/realtime.h"

namespace aula {

namespace {

/// A time after all changes.
constexpr std::int64_t kAll = kNever - 1;

}  // namespace

RealTimePlayback::RealTimePlayback(std::shared_ptr<BuiltRoom> first,
                                   const AuralizerOptions& options)
    : RoomPlayback(std::move(first), options, options.block),
      block_(options.block),
      part_outputs_(options.listeners * channel_count(options.output)),
      sounding_{&newest()},
      frame_heads_(options.listeners) {}

// Never before that of an earlier call, so that changes keep the order of the calls.
ChangeTime RealTimePlayback::time_of(std::int64_t /*at*/) const { return {rendered_.load()}; }

// A room whose scene is replaced before its next frame has no response for the source.
void RealTimePlayback::begin_source(SourceId source, const ChangeTime& /*time*/) {
    if (scene_waits_) return;
    sounding_.back()->slots.begin(source);
    publish_routes(*sounding_.back());
}

void RealTimePlayback::end_source(SourceId source, const ChangeTime& /*time*/) {
    for (SoundingRoom* const room : sounding_) {
        if (!room->plays(source)) continue;
        room->slots.end(source);
        publish_routes(*room);
    }
}

void RealTimePlayback::publish_routes(SoundingRoom& room) {
    auto routes = room.routes.reclaim();
    if (!routes) routes = std::make_unique<std::vector<SourceId>>();
    *routes = room.slots.playing();
    room.routes.publish(std::move(routes));
}

void RealTimePlayback::announce_scene() {
    scene_waits_ = true;
    changed_.notify_all();
}

void RealTimePlayback::take_scene(SoundingRoom& next) {
    scene_waits_ = false;
    sounding_.push_back(&next);
}

/// The first frame of the present scene has been handed over.
void RealTimePlayback::note_scene() {
    {
        const std::lock_guard lock(mutex_);
        heard_scene_ = scene_number();
    }
    changed_.notify_all();
}

/// The rooms that have rung out.
std::vector<std::unique_ptr<SoundingRoom>> RealTimePlayback::take_silent_rooms() {
    std::vector<std::unique_ptr<SoundingRoom>> rooms;
    while (auto room = rooms_.reclaim()) {
        const std::lock_guard lock(mutex_);
        std::erase(sounding_, room.get());
        rooms.push_back(std::move(room));
    }
    return rooms;
}

void RealTimePlayback::turn_head(std::size_t listener, const Pose& pose,
                                 const ChangeTime& /*time*/) {
    if (in_before_frame()) {
        frame_heads_[listener] = pose;
    } else {
        frame_heads_[listener].reset();  // the new pose is newer
        publish_head(listener, pose);
    }
}

void RealTimePlayback::publish_head(std::size_t listener, const Pose& pose) {
    for (SoundingRoom* const room : sounding_) {
        Mailbox<HeadPose>& heads = *room->heads[listener];
        auto head = heads.reclaim();
        if (!head) head = std::make_unique<HeadPose>();
        *head = {pose, running_ ? clock_ns() : 0};
        heads.publish(std::move(head));
    }
}

/// The latency of a frame's pose counts from the frame's time.
std::int64_t RealTimePlayback::pose_ns() const {
    if (!running_) return 0;
    return in_before_frame() ? frame_due_ns_ : clock_ns();
}

double RealTimePlayback::played_s() const {
    return hooks_.played_s ? hooks_.played_s() : static_cast<double>(rendered_.load()) / rate_hz_;
}

/// False at the end, and if another scene is to begin.
bool RealTimePlayback::wait_until(Clock::time_point time) {
    std::unique_lock lock(mutex_);
    return !changed_.wait_until(lock, time, [this] { return stop_ || scene_waits_; });
}

/// Applies changes until a pause ends, during which the time of frames stops. False at the end.
bool RealTimePlayback::wait_out_pause(FrameClock& clock) {
    if (!pause_.silent()) return true;
    const auto period = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(computer().config().frame_s));
    while (pause_.silent()) {
        if (!wait_until(Clock::now() + period)) return false;
        apply_changes(kAll, rendered_.load(), clock.time_s());
    }
    clock.resume(played_s(), Clock::now());
    return true;
}

/// Empty if another scene is to begin and this is not its first frame.
ListenerFrames RealTimePlayback::compute(double time_s, bool is_first) {
    const std::optional<FrameRoom> room = take_changes(kAll, rendered_.load(), time_s, is_first);
    if (!room) return {};
    ListenerFrames frames;
    for (std::size_t l = 0; l < listeners_; ++l)
        frames.push_back(newest().renderer.frames(l).reclaim());
    computer().compute(*room, frames);
    for (std::size_t l = 0; l < frames.size(); ++l) frames[l]->stamp = room->poses_ns[l];
    return frames;
}

const FrameMaker& RealTimePlayback::compute_first(double time_s) {
    publish(compute(time_s, true));
    return computer().maker();
}

void RealTimePlayback::wait_for(std::uint64_t scene) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return stop_ || failure_ || heard_scene_ >= scene; });
}

void RealTimePlayback::compute_frames(Auralizer& auralizer) {
    // The time of frames increases, even if no block was rendered during the first one.
    constexpr double kMinStep_s = 0.001;
    auralizer_ = &auralizer;
    bool is_first = computer().status().frames == 0;
    for (;;) {
        double earliest_s = 0;
        const bool replaces = is_first && computer().status().frames > 0;
        if (is_first) {
            if (replaces && hooks_.scene_begins) hooks_.scene_begins();
            const double time_s = played_s();
            frame_due_ns_ = clock_ns();
            call_before_frame(auralizer, rendered_.load(), time_s);
            compute_first(time_s);
            if (replaces && hooks_.scene_has_begun) hooks_.scene_has_begun(computer().maker());
            earliest_s = time_s + kMinStep_s;
            note_scene();
        }
        lower_priority(kPropagationNice);
        FrameClock clock(Clock::now(), std::max(played_s(), earliest_s));
        clock.took(computer().status().frame_ms / 1000);
        {
            const std::lock_guard lock(mutex_);
            running_ = true;
        }
        run_frames(clock, computer().config().frame_s, *this);
        computed_.clear();
        const std::lock_guard lock(mutex_);
        if (stop_) return;
        is_first = true;
    }
}

bool RealTimePlayback::publish_frame(FrameClock& clock) {
    if (!computed_.empty()) publish(std::exchange(computed_, {}));
    return wait_out_pause(clock);
}

double RealTimePlayback::compute_frame(FrameClock& clock) {
    frame_due_ns_ = clock.due().time_since_epoch().count();
    call_before_frame(*auralizer_, rendered_.load(), clock.time_s());
    const auto begin = Clock::now();
    computed_ = compute(clock.time_s(), false);
    if (computed_.empty()) return 0;  // run_frames() returns
    const double took_s = std::chrono::duration<double>(Clock::now() - begin).count();
    if (hooks_.after_frame)
        hooks_.after_frame(computer().maker(),
                           std::chrono::duration<double>(clock.end() - Clock::now()).count());
    clock.follow(played_s(), Clock::now());
    return took_s;
}

void RealTimePlayback::publish(ListenerFrames frames) {
    for (std::size_t l = 0; l < frames.size(); ++l)
        newest().renderer.frames(l).publish(std::move(frames[l]));
    tail_samples_ = newest_tail_samples();
    newest().tail = tail_samples_.load();
    const auto silent_rooms = take_silent_rooms();
    if (scene_begins()) {
        rooms_.publish(std::move(built()->made));
        finish_beginning();
    }
    const std::lock_guard lock(mutex_);
    for (std::size_t l = 0; l < listeners_; ++l) {
        if (frame_heads_[l]) publish_head(l, *frame_heads_[l]);
        frame_heads_[l].reset();
    }
    computer().set_handed_over();
}

/// Takes the sources and the orientations that commands have set.
void RealTimePlayback::take_commands(SoundingRoom& room) noexcept {
    if (std::vector<SourceId>* const all = room.routes.take()) {
        for (std::size_t s = 0; s < all->size(); ++s) room.renderer.set_source(s, (*all)[s]);
        room.routes.give_back(all);
    }
    for (std::size_t l = 0; l < room.heads.size(); ++l) {
        HeadPose* const head = room.heads[l]->take();
        if (head == nullptr) continue;
        room.renderer.turn_head(l, head->pose);
        if (l == 0) head_pose_ns_ = head->set_ns;
        room.heads[l]->give_back(head);
    }
}

void RealTimePlayback::render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                              int samples) noexcept {
    const FlushDenormals flush;
    for (int done = 0; done < samples;) {
        const int left = std::min(block_, samples - done);
        const int part = pause_.advance(outputs, done, left);
        if (part == 0) {
            done += left;
            continue;
        }
        exchange_.advance([this](SoundingRoom& next) noexcept AULA_NONBLOCKING {
            const SoundingRoom* const before = exchange_.playing();
            if (!next.signals) return before != nullptr;
            return next.signals->begin(rendered_samples(),
                                       before != nullptr ? before->signals.get() : nullptr);
        });
        exchange_.for_each([this](SoundingRoom& room) { take_commands(room); });
        for (std::size_t c = 0; c < outputs.size(); ++c) part_outputs_[c] = outputs[c] + done;
        const std::span<const float> weights = pause_.weights(part);
        render_rooms(inputs, done, weights, part_outputs_, part);
        for (float* const output : part_outputs_) apply_weights(weights, output);
        done += part;
        rendered_.fetch_add(part, std::memory_order_relaxed);
    }
}

}  // namespace aula
