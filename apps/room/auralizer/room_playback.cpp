#include "apps/room/auralizer/room_playback.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "apps/room/base/output_resources.h"
#include "audio/render/render_memory.h"

namespace aula {

namespace {

/// Time for which a removed source is audible beyond its response: its fade and the length of the
/// filters.
constexpr double kRingTail_s = 0.1;

/// Slots of the renderer beyond AuralizerOptions::max_sources. The slot of a removed source is
/// free for a while before another source plays in it.
constexpr std::size_t kSpareSlots = 2;

FrameSettings settings_of(const Scene& scene, const AuralizerOptions& options, int block,
                          const HeadphoneFilter* headphones) {
    // Not more spare slots than sources that can be added without a removal: if the scene has
    // max_sources sources, replacing one is rare.
    const std::size_t spare = std::min(options.max_sources - scene.sources.size(), kSpareSlots);
    FrameSettings settings{options};
    settings.block = block;
    settings.max_sources = options.max_sources + spare;
    settings.listeners = options.listeners;
    settings.waves_ready =
        options.clock == RenderClock::real_time ? WavesReady::later : WavesReady::at_once;
    if (headphones != nullptr) settings.headphones_bytes = equalizer_bytes(*headphones, block);
    settings.max_memory_bytes = options.max_memory_bytes;
    return settings;
}

}  // namespace

RoomPlayback::RoomPlayback(const Scene& scene, const AuralizerOptions& options, int block,
                           std::shared_ptr<const Hrtf> hrtf)
    : rate_hz_(options.sample_rate_hz),
      before_frame_(options.before_frame),
      headphones_(headphones_for(options)),
      computer_(scene, settings_of(scene, options, block, headphones_.get()),
                hrtf ? std::move(hrtf) : hrtf_for(options)),
      renderer_(computer_.config(), options.listeners, computer_.hrtf(), headphones_.get()),
      renderer_slots_(computer_.config().sources),
      pause_(rate_hz_, block),
      tail_samples_(tail_of(computer_.config().longest_delay_s)),
      sources_(options.max_sources),
      room_{.state = room_state(scene, 0), .slots = renderer_slots_} {
    const Pose pose = room_.state.listeners[0];
    room_.state.listeners.assign(options.listeners, pose);
    room_.poses_ns.resize(options.listeners);
    for (const Object& object : scene.objects)
        room_.state.objects.push_back(object.transform_at(0));
    for (std::size_t l = 0; l < options.listeners; ++l) renderer_.turn_head(l, pose);
    for (SourceState& state : room_.state.sources) {
        const SourceId source = sources_.add({});
        state.id = source.number;
        state.slot = room_.slots.begin(source);
        renderer_.set_source(renderer_slots_.begin(source), source);
    }
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

AuralizerStatus RoomPlayback::status() const {
    {
        const std::lock_guard lock(mutex_);
        if (failure_) std::rethrow_exception(failure_);
    }
    AuralizerStatus status = computer_.status();
    status.samples = rendered_.load();
    status.paused = pause_.silent();
    status.muted_samples = renderer_.muted_samples();
    return status;
}

void RoomPlayback::call_before_frame(Auralizer& auralizer, std::int64_t sample, double time_s) {
    if (!before_frame_) return;
    {
        const std::lock_guard lock(mutex_);
        frame_sample_ = sample;
    }
    before_frame_(auralizer, time_s);
    const std::lock_guard lock(mutex_);
    frame_sample_.reset();
}

void RoomPlayback::apply_changes(std::int64_t until, std::int64_t now, double time_s) {
    const std::lock_guard lock(mutex_);
    changes_.apply(until, room_);
    sources_.forget(now);
    std::erase_if(room_.state.sources, [&](const SourceState& source) {
        return source.removed_at &&
               now - *source.removed_at >= tail_of(computer_.longest_delay_s({source.id}));
    });
    room_.state.time_s = time_s;
}

/// How long sources are audible after their signals have ended.
std::int64_t RoomPlayback::tail_of(double longest_delay_s) const {
    const double length_s = std::max(computer_.response_length_s(), longest_delay_s);
    return std::llround((length_s + headphones_s() + kRingTail_s) * rate_hz_);
}

/// How long the headphone filter rings after a sample.
double RoomPlayback::headphones_s() const {
    return headphones_ ? static_cast<double>(headphones_->taps() - 1) / rate_hz_ : 0;
}

std::vector<std::vector<float>> RoomPlayback::impulse_response(SourceId source,
                                                               std::size_t listener) const {
    auto response = computer_.impulse_response(source, listener);
    if (headphones_ && !response.empty()) equalize(*headphones_, response);
    return response;
}

std::int64_t RoomPlayback::newest_tail_samples() const {
    double longest_s = 0;
    for (const SourceState& source : room_.state.sources)
        longest_s = std::max(longest_s, computer_.longest_delay_s({source.id}));
    return tail_of(longest_s);
}

FrameRoom RoomPlayback::take_changes(std::int64_t until, std::int64_t now, double time_s) {
    apply_changes(until, now, time_s);
    FrameRoom room = room_;
    room_.materials.clear();
    std::fill(room_.poses_ns.begin(), room_.poses_ns.end(), 0);
    return room;
}

}  // namespace aula
