#include "aula/auralizer.h"

#include <algorithm>
#include <atomic>
#include <cfenv>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <future>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "apps/session/auralizer/frame_clock.h"
#include "apps/session/auralizer/room_renderer.h"
#include "apps/session/frames/frame_maker.h"
#include "aula/exception.h"

namespace aula {

namespace {

/// The block of the exact clock, and its latency.
constexpr int kExactBlock = 256;

/// Frames computed ahead on the exact clock, so that fast frames compensate for slow ones.
constexpr std::size_t kFramesAhead = 2;

constexpr double kPauseFade_s = 0.02;

/// Time by which a removed source is heard beyond its response: its fade and the filters' length.
constexpr double kRingTail_s = 0.1;

constexpr float kHighestGain_db = 120;

/// Rounding of a rotation that a host has multiplied up in single precision.
constexpr float kRigidTolerance = 1e-2F;

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

using Frames = std::vector<std::unique_ptr<RenderFrame>>;  ///< [listener]

/// Input of a frame: the room, and the material changes before it.
struct Room {
    RoomState state;
    std::vector<std::function<void(FrameMaker&)>> materials;
};

/// A change and its sample time.
template <typename Target>
struct Change {
    std::int64_t at = 0;
    std::function<void(Target&)> apply;
};

/// Changes ordered by time; those of one time keep the order of their calls.
template <typename Target>
class Changes {
 public:
    void add(std::int64_t at, std::function<void(Target&)> apply) {
        const auto later = std::upper_bound(
            changes_.begin(), changes_.end(), at,
            [](std::int64_t time, const Change<Target>& change) { return time < change.at; });
        changes_.insert(later, {at, std::move(apply)});
    }

    /// Applies all changes up to a time.
    void apply(std::int64_t until, Target& target) {
        while (!changes_.empty() && changes_.front().at <= until) {
            changes_.front().apply(target);
            changes_.pop_front();
        }
    }

    /// The time of the next change.
    std::int64_t next() const { return changes_.empty() ? kNever : changes_.front().at; }

 private:
    std::deque<Change<Target>> changes_;
};

/// A slot of the renderer.
struct SlotUse {
    SourceId source;              ///< that plays in it
    std::int64_t begins_at = 0;   ///< of the source
    std::int64_t removed_at = 0;  ///< when it last ended
    std::int64_t rung_out_at = 0;
};

void weight(std::span<const float> weights, float* samples) noexcept AULA_NONBLOCKING {
    for (std::size_t n = 0; n < weights.size(); ++n) samples[n] *= weights[n];
}

FrameSettings settings_of(const AuralizerOptions& options) {
    return {.sample_rate_hz = options.sample_rate_hz,
            .block = options.clock == RenderClock::exact ? kExactBlock : options.block,
            .output = options.output,
            .ambisonic_order = options.ambisonic_order,
            .half_precision_tail = options.half_precision_tail,
            .most_sources = options.most_sources,
            .listeners = options.listeners};
}

void need(bool holds, const char* what) {
    if (!holds) throw InputError(std::string("auralizer: ") + what);
}

void check(const AuralizerOptions& options) {
    need(options.sample_rate_hz >= 8000 && options.sample_rate_hz <= 384000,
         "the sample rate is not between 8000 and 384000 Hz");
    need(options.block >= 1 && options.block <= 8192, "the block is not between 1 and 8192");
    need(options.ambisonic_order >= 1 && options.ambisonic_order <= 3,
         "the ambisonic order is not between 1 and 3");
    need(options.listeners >= 1, "there is no listener");
}

bool is_finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Throws InputError for what would make every later sample not a number.
void check_position(const Vec3& position) { need(is_finite(position), "a position is not finite"); }

void check_pose(const Pose& pose) {
    check_position(pose.position);
    need(is_finite({pose.yaw_rad, pose.pitch_rad, pose.roll_rad}), "an angle is not finite");
}

void check_gain(float gain_db) {
    need(gain_db <= kHighestGain_db, "a gain is not a number up to 120 dB");
}

void check_transform(const RigidTransform& transform) {
    check_position(transform.translation);
    const glm::mat3 identity = glm::transpose(transform.rotation) * transform.rotation;
    bool rigid = glm::determinant(transform.rotation) > 0;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
            rigid = rigid && std::abs(identity[c][r] - (c == r ? 1.0F : 0.0F)) < kRigidTolerance;
    need(rigid, "a transform's rotation is not one: its columns are not orthonormal");
}

void check_material(const Material& material) {
    for (std::size_t b = 0; b < kBandCount; ++b)
        for (const float share : {material.absorption[b], material.scattering[b]})
            need(share >= 0 && share <= 1, "a coefficient of a material is not from 0 to 1");
}

/// The end of what rings, however late it begins.
std::int64_t saturated_sum(std::int64_t time, std::int64_t duration) {
    return time > kNever - duration ? kNever : time + duration;
}

}  // namespace

struct Auralizer::State {
    using Clock = FrameClock::Clock;

    State(const Scene& scene, AuralizerOptions options);
    ~State();

    void end();
    void build();
    void run(Auralizer& self);
    void run_exact(Auralizer& self);
    void run_real_time(Auralizer& self);
    void call_before_frame(Auralizer& self, std::int64_t sample, double time_s);
    bool in_frame() const {
        return frame_sample.has_value() && std::this_thread::get_id() == thread.get_id();
    }
    void follow_changes(std::int64_t sample, double time_s);
    Room take_changes(std::int64_t sample, double time_s);
    Frames unused_frames();
    void compute(Room& room, const Frames& frames);
    void publish(Frames frames);

    std::int64_t time_of(std::int64_t at) const;
    std::int64_t frame_start(std::int64_t frame) const;
    std::size_t take_slot(SourceId source, std::int64_t at);
    void route(std::size_t slot, SourceId source, std::int64_t at);
    void turn_head(std::size_t listener, const Pose& pose, std::int64_t at);
    void change_source(SourceId source, std::int64_t at, std::function<void(SourceState&)> apply);
    void check_object(std::size_t object) const;
    std::string name_of(std::size_t object) const;

    int gate(std::span<float* const> outputs, int done, int samples) noexcept AULA_NONBLOCKING;
    std::span<const float> pause_weights(int samples) noexcept AULA_NONBLOCKING;
    void render_real_time(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                          int samples) noexcept AULA_NONBLOCKING;
    void render_exact(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                      int samples);
    void render_block();
    Frames next_frames();

    Scene scene;
    AuralizerOptions options;
    bool exact;
    std::shared_ptr<const Hrtf> hrtf;
    std::optional<FrameMaker> maker;       ///< of the propagation thread
    std::optional<RoomRenderer> renderer;  ///< of the audio thread
    double rate_hz;
    double frame_s = 0;
    double response_length_s = 0;
    std::int64_t tail_samples = 0;

    // Of the rendering thread.
    Fade pause_fade;
    bool fading_out = false;  ///< along it, else in
    std::vector<float> weights;
    std::vector<float*> part_outputs;
    // Of it, on the exact clock.
    struct BlockInput {
        std::vector<float> samples = std::vector<float>(kExactBlock);
        bool given = false;  ///< in this block
    };
    std::map<std::uint64_t, BlockInput> block_inputs;  ///< by the source's number
    std::vector<std::vector<float>> block_outputs;
    int filled = 0;               ///< samples present in the current block
    std::exception_ptr broken;    ///< what ended rendering
    std::int64_t next_frame = 0;  ///< to be heard
    std::vector<SourceSignal> block_signals;
    std::vector<float*> block_pointers;

    // From other threads to the audio thread, on the real-time clock. Writers hold the mutex.
    Mailbox<std::vector<SourceId>> routes{1};           ///< [slot]
    std::vector<std::unique_ptr<Mailbox<Pose>>> heads;  ///< [listener]
    std::atomic<bool> paused = false;
    std::atomic<bool> silent = false;  ///< the fade to a pause is complete
    std::atomic<std::int64_t> rendered = 0;

    /// Locked while a frame is computed, and to read its inputs.
    std::mutex frame_mutex;

    mutable std::mutex mutex;  ///< of what follows
    std::condition_variable changed;
    bool stop = false;
    bool started = false;
    std::exception_ptr failure;
    Room room;  ///< with all changes up to the newest frame
    Changes<Room> changes;
    Changes<RoomRenderer> audio_changes;  ///< on the exact clock
    std::int64_t committed = 0;           ///< all changes before are known
    std::deque<Frames> ready;             ///< on the exact clock
    std::vector<Frames> spent;            ///< [listener] any number
    std::vector<SourceId> sources;
    std::vector<SlotUse> slots;
    std::vector<SourceId> routed;  ///< [slot] as published last
    std::uint64_t last_number = 0;
    std::vector<std::optional<Pose>> frame_heads;  ///< [listener] set before this frame
    std::optional<std::int64_t> frame_sample;      ///< of the frame that before_frame is called for
    struct Sight {
        SourceId source;
        std::vector<char> visible;  ///< [listener]
    };
    std::vector<Sight> sights;  ///< of the newest frame
    AuralizerStatus status;
    double frame_sum_ms = 0;

    std::promise<void> built;
    std::thread thread;
};

Auralizer::State::State(const Scene& scene_in, AuralizerOptions options_in)
    : scene(scene_in),
      options((check(options_in), std::move(options_in))),
      exact(options.clock == RenderClock::exact),
      rate_hz(options.sample_rate_hz),
      pause_fade(static_cast<std::size_t>(std::lround(kPauseFade_s * rate_hz))) {
    options.most_sources = std::max({options.most_sources, scene.sources.size(), std::size_t{1}});
}

/// [propagation thread]
void Auralizer::State::build() {
    if (options.output == OutputFormat::binaural)
        hrtf = std::make_shared<const Hrtf>(options.hrtf, rate_hz);
    maker.emplace(scene, settings_of(options), hrtf);
    renderer.emplace(maker->config(), options.listeners, hrtf);
    frame_s = maker->config().frame_s;
    response_length_s = maker->response_length_s();
    tail_samples = std::llround((response_length_s + kRingTail_s) * rate_hz);
    status.frame_period_ms = 1000 * frame_s;
    status.response_length_s = response_length_s;

    room.state = room_state(scene, 0);
    const Pose pose = room.state.listeners[0];
    room.state.listeners.assign(options.listeners, pose);
    for (const Object& object : scene.objects) room.state.objects.push_back(object.transform_at(0));
    for (std::size_t l = 0; l < options.listeners; ++l) {
        heads.push_back(std::make_unique<Mailbox<Pose>>(1));
        renderer->turn_head(l, pose);
    }
    frame_heads.resize(options.listeners);
    spent.resize(options.listeners);
    slots.resize(options.most_sources);
    routed.resize(options.most_sources);
    for (const SourceState& source : room.state.sources) {
        last_number = source.id;
        sources.push_back({source.id});
        slots[source.slot].source = sources.back();
        routed[source.slot] = sources.back();
        renderer->set_source(source.slot, sources.back());
    }
    const std::size_t channels = options.listeners * channel_count(options.output);
    part_outputs.resize(channels);
    weights.resize(static_cast<std::size_t>(std::max(kExactBlock, options.block)));
    block_outputs.assign(channels, std::vector<float>(kExactBlock));
    block_pointers.resize(channels);
}

Auralizer::State::~State() { end(); }

void Auralizer::State::end() {
    {
        const std::lock_guard lock(mutex);
        stop = true;
    }
    changed.notify_all();
    if (thread.joinable()) thread.join();
}

/// [propagation thread]
void Auralizer::State::run(Auralizer& self) {
    leave_realtime();
    // The rounding and denormal modes of the starting thread are not inherited.
    std::fesetenv(FE_DFL_ENV);
    if (!exact) give_way(kNiceOfFrames);
    try {
        build();
    } catch (...) {
        return built.set_exception(std::current_exception());
    }
    built.set_value();
    {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return started || stop; });
    }
    try {
        if (exact)
            run_exact(self);
        else
            run_real_time(self);
    } catch (...) {
        const std::lock_guard lock(mutex);
        failure = std::current_exception();
    }
    changed.notify_all();
}

/// The first sample at or after a frame's time.
std::int64_t Auralizer::State::frame_start(std::int64_t frame) const {
    const double frame_rate_hz = static_cast<double>(scene.simulation.frame_rate_hz);
    return static_cast<std::int64_t>(
        std::ceil(static_cast<double>(frame) * rate_hz / frame_rate_hz));
}

void Auralizer::State::run_exact(Auralizer& self) {
    for (std::int64_t k = 0;; ++k) {
        const std::int64_t sample = frame_start(k);
        {
            std::unique_lock lock(mutex);
            changed.wait(
                lock, [&] { return stop || (committed > sample && ready.size() < kFramesAhead); });
            if (stop) return;
        }
        const double time_s =
            static_cast<double>(k) / static_cast<double>(scene.simulation.frame_rate_hz);
        call_before_frame(self, sample, time_s);
        Room now = take_changes(sample, time_s);
        Frames frames = unused_frames();
        compute(now, frames);
        {
            const std::lock_guard lock(mutex);
            ready.push_back(std::move(frames));
        }
        changed.notify_all();
    }
}

/// Wakes at each frame time: publishes the frame computed since the one before, then computes the
/// next.
void Auralizer::State::run_real_time(Auralizer& self) {
    const auto wait_until = [this](Clock::time_point time) {
        std::unique_lock lock(mutex);
        return !changed.wait_until(lock, time, [this] { return stop; });
    };
    FrameClock clock(Clock::now());
    Frames computed;
    for (bool first = true;; first = false) {
        if (!first) {
            clock.next(frame_s);
            if (!wait_until(clock.due())) return;
            if (!computed.empty()) publish(std::move(computed));
            computed.clear();
            const std::uint64_t missed = clock.leave_out_missed(Clock::now());
            if (missed > 0) {
                const std::lock_guard lock(mutex);
                status.late_frames += missed;
            }
            if (!wait_until(clock.begin())) return;
        }
        const double time_s = clock.time_s();
        call_before_frame(self, rendered.load(), time_s);
        if (silent.load()) {
            follow_changes(kNever - 1, time_s);
        } else {
            Room now = take_changes(kNever - 1, time_s);
            const auto begin = Clock::now();
            computed = unused_frames();
            compute(now, computed);
            clock.took(std::chrono::duration<double>(Clock::now() - begin).count());
            if (first) publish(std::exchange(computed, {}));
        }
        clock.follow(static_cast<double>(rendered.load()) / rate_hz, Clock::now());
    }
}

void Auralizer::State::call_before_frame(Auralizer& self, std::int64_t sample, double time_s) {
    if (!options.before_frame) return;
    {
        const std::lock_guard lock(mutex);
        frame_sample = sample;
    }
    options.before_frame(self, time_s);
    const std::lock_guard lock(mutex);
    frame_sample.reset();
}

/// Applies all changes up to a frame to the room.
void Auralizer::State::follow_changes(std::int64_t sample, double time_s) {
    const std::lock_guard lock(mutex);
    changes.apply(sample, room);
    const std::int64_t now = exact ? sample : rendered.load();
    std::erase_if(room.state.sources, [&](const SourceState& source) {
        return source.ringing && source.rung_out_at <= now;
    });
    room.state.time_s = time_s;
}

/// The room with all changes up to a frame, for that frame.
Room Auralizer::State::take_changes(std::int64_t sample, double time_s) {
    follow_changes(sample, time_s);
    const std::lock_guard lock(mutex);
    return {room.state, std::exchange(room.materials, {})};
}

Frames Auralizer::State::unused_frames() {
    Frames frames(options.listeners);
    for (std::size_t l = 0; l < frames.size(); ++l) {
        const std::lock_guard lock(mutex);
        if (!exact) {
            frames[l] = renderer->frames(l).reclaim();
        } else if (!spent[l].empty()) {
            frames[l] = std::move(spent[l].back());
            spent[l].pop_back();
        }
    }
    for (auto& frame : frames)
        if (!frame) frame = maker->make_frame();
    return frames;
}

void Auralizer::State::compute(Room& now, const Frames& frames) {
    const auto begin = Clock::now();
    std::vector<Sight> seen;
    {
        const std::lock_guard computing(frame_mutex);
        for (const auto& change : now.materials) change(*maker);
        maker->fill(now.state, frames);
        for (const SourceState& source : now.state.sources) {
            if (source.ringing) continue;
            Sight sight{{source.id}, {}};
            for (std::size_t l = 0; l < options.listeners; ++l) {
                const SourceSound* const sound = maker->sound(source.id, l);
                sight.visible.push_back(sound != nullptr && sound->direct ? 1 : 0);
            }
            seen.push_back(std::move(sight));
        }
    }
    const double took_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    const std::lock_guard lock(mutex);
    std::swap(sights, seen);
    frame_sum_ms += took_ms;
    ++status.frames;
    status.frame_ms = took_ms;
    status.frame_mean_ms = frame_sum_ms / static_cast<double>(status.frames);
    status.frame_worst_ms = std::max(status.frame_worst_ms, took_ms);
    status.memory_bytes = maker->statistics().memory_bytes;
}

/// [real time]
void Auralizer::State::publish(Frames frames) {
    for (std::size_t l = 0; l < frames.size(); ++l)
        renderer->frames(l).publish(std::move(frames[l]));
    const std::lock_guard lock(mutex);
    for (std::size_t l = 0; l < heads.size(); ++l) {
        if (!frame_heads[l]) continue;
        heads[l]->publish(std::make_unique<Pose>(*frame_heads[l]));
        frame_heads[l].reset();
    }
}

/// The sample time of a change that is made now. The mutex is held.
std::int64_t Auralizer::State::time_of(std::int64_t at) const {
    if (!exact) return in_frame() ? *frame_sample : rendered.load();
    if (in_frame()) return std::max(at, *frame_sample);
    return std::max(at, committed);
}

/// A slot that is free at a time, or that of what has rung out the most. The mutex is held.
std::size_t Auralizer::State::take_slot(SourceId source, std::int64_t at) {
    std::size_t best = slots.size();
    for (std::size_t s = 0; s < slots.size(); ++s) {
        if (slots[s].source.number != 0 || slots[s].removed_at > at) continue;
        if (best == slots.size() || slots[s].rung_out_at < slots[best].rung_out_at) best = s;
        if (slots[best].rung_out_at <= at) break;
    }
    if (best == slots.size())
        throw InputError("auralizer: more than " + std::to_string(slots.size()) +
                         " sources; AuralizerOptions::most_sources is their number");
    slots[best].source = source;
    slots[best].begins_at = at;
    return best;
}

/// Tells the audio thread what a slot plays. The mutex is held.
void Auralizer::State::route(std::size_t slot, SourceId source, std::int64_t at) {
    if (exact) {
        audio_changes.add(at, [slot, source](RoomRenderer& r) { r.set_source(slot, source); });
        return;
    }
    routed[slot] = source;
    auto all = routes.reclaim();
    if (!all) all = std::make_unique<std::vector<SourceId>>();
    *all = routed;
    routes.publish(std::move(all));
}

/// The mutex is held.
void Auralizer::State::turn_head(std::size_t listener, const Pose& pose, std::int64_t at) {
    if (exact) {
        audio_changes.add(at, [listener, pose](RoomRenderer& r) { r.turn_head(listener, pose); });
    } else if (in_frame()) {
        frame_heads[listener] = pose;
    } else {
        auto head = heads[listener]->reclaim();
        if (!head) head = std::make_unique<Pose>();
        *head = pose;
        heads[listener]->publish(std::move(head));
    }
}

/// Changes a source, from its beginning on at the earliest. The mutex is held.
void Auralizer::State::change_source(SourceId source, std::int64_t at,
                                     std::function<void(SourceState&)> apply) {
    for (const SlotUse& slot : slots)
        if (slot.source == source) at = std::max(at, slot.begins_at);
    changes.add(at, [number = source.number, apply = std::move(apply)](Room& r) {
        for (SourceState& state : r.state.sources)
            if (state.id == number && !state.ringing) apply(state);
    });
}

void Auralizer::State::check_object(std::size_t object) const {
    if (object >= scene.objects.size())
        throw InputError("auralizer: there is no object " + std::to_string(object));
}

std::string Auralizer::State::name_of(std::size_t object) const {
    const std::string& name = scene.objects[object].name;
    return name.empty() ? std::to_string(object) : '"' + name + '"';
}

/// Follows pause() and resume(); how many of the samples are to be rendered, 0 in a pause.
int Auralizer::State::gate(std::span<float* const> outputs, int done, int samples) noexcept {
    const bool pausing = paused.load(std::memory_order_relaxed);
    if (pausing != fading_out) {
        fading_out = pausing;
        pause_fade.turn_back();
    }
    const bool is_silent = fading_out && pause_fade.done();
    silent.store(is_silent, std::memory_order_relaxed);
    if (is_silent) {
        for (float* const channel : outputs) std::fill_n(channel + done, samples, 0.0F);
        return 0;
    }
    // Time stands still from the end of the fade on.
    if (fading_out) return std::min(samples, static_cast<int>(pause_fade.remaining()));
    return samples;
}

/// The weights of a part's samples, in and out, on the way to a pause or back; empty elsewhere.
/// Inputs and outputs fade both, so that nothing from before a pause is heard after it.
std::span<const float> Auralizer::State::pause_weights(int samples) noexcept {
    if (pause_fade.done()) return {};
    const auto count = static_cast<std::size_t>(samples);
    for (std::size_t n = 0; n < count; ++n)
        weights[n] = fading_out ? 1 - pause_fade.weight(n) : pause_fade.weight(n);
    pause_fade.advance(count);
    return std::span(weights).first(count);
}

void Auralizer::State::render_real_time(std::span<const SourceSignal> inputs,
                                        std::span<float* const> outputs, int samples) noexcept {
    const FlushDenormals flush;
    RoomRenderer& r = *renderer;
    for (int done = 0; done < samples;) {
        const int part = gate(outputs, done, std::min(options.block, samples - done));
        if (part == 0) {
            done += std::min(options.block, samples - done);
            continue;
        }
        if (std::vector<SourceId>* const all = routes.take()) {
            for (std::size_t s = 0; s < all->size(); ++s) r.set_source(s, (*all)[s]);
            routes.give_back(all);
        }
        for (std::size_t l = 0; l < heads.size(); ++l) {
            Pose* const pose = heads[l]->take();
            if (pose == nullptr) continue;
            r.turn_head(l, *pose);
            heads[l]->give_back(pose);
        }
        for (std::size_t c = 0; c < outputs.size(); ++c) part_outputs[c] = outputs[c] + done;
        const std::span<const float> faded = pause_weights(part);
        r.render(inputs, done, faded, part_outputs, part);
        for (float* const output : part_outputs) weight(faded, output);
        done += part;
        rendered.fetch_add(part, std::memory_order_relaxed);
    }
}

/// Blocks begin at multiples of their size, independent of the size of the calls.
void Auralizer::State::render_exact(std::span<const SourceSignal> inputs,
                                    std::span<float* const> outputs, int samples) {
    if (broken) std::rethrow_exception(broken);
    const FlushDenormals flush;
    for (int done = 0; done < samples;) {
        const int left = std::min(kExactBlock - filled, samples - done);
        const int part = gate(outputs, done, left);
        if (part == 0) {
            done += left;
            continue;
        }
        const std::span<const float> faded = pause_weights(part);
        // Of several signals of a source the first is the one that counts.
        for (std::size_t i = inputs.size(); i-- > 0;) {
            const SourceSignal& input = inputs[i];
            if (input.samples == nullptr) continue;
            BlockInput& block = block_inputs[input.source.number];
            block.given = true;
            std::copy_n(input.samples + done, part, block.samples.data() + filled);
            weight(faded, block.samples.data() + filled);
        }
        for (std::size_t c = 0; c < outputs.size(); ++c) {
            std::copy_n(block_outputs[c].data() + filled, part, outputs[c] + done);
            weight(faded, outputs[c] + done);
        }
        filled += part;
        done += part;
        rendered.fetch_add(part);
        {
            const std::lock_guard lock(mutex);
            committed = std::max(committed, rendered.load());
        }
        changed.notify_all();
        if (filled < kExactBlock) continue;
        try {
            render_block();
        } catch (...) {
            broken = std::current_exception();
            throw;
        }
    }
}

/// The next frame of the exact clock; waits for it.
Frames Auralizer::State::next_frames() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return failure || !ready.empty(); });
    if (ready.empty()) std::rethrow_exception(failure);
    Frames frames = std::move(ready.front());
    ready.pop_front();
    lock.unlock();
    changed.notify_all();
    return frames;
}

/// Renders the block whose signals are there, divided where frames and changes begin.
void Auralizer::State::render_block() {
    RoomRenderer& r = *renderer;
    const std::int64_t end = rendered.load();
    block_signals.clear();
    for (const auto& [number, input] : block_inputs)
        block_signals.push_back({{number}, input.samples.data()});
    for (std::int64_t first = end - kExactBlock; first < end;) {
        if (frame_start(next_frame) <= first) {
            Frames frames = next_frames();
            ++next_frame;
            const std::lock_guard lock(mutex);
            for (std::size_t l = 0; l < frames.size(); ++l) {
                r.frames(l).publish(std::move(frames[l]));
                while (auto back = r.frames(l).reclaim()) spent[l].push_back(std::move(back));
            }
        }
        std::int64_t part_end = std::min(end, frame_start(next_frame));
        {
            const std::lock_guard lock(mutex);
            audio_changes.apply(first, r);
            part_end = std::min(part_end, audio_changes.next());
        }
        const auto offset = static_cast<int>(first - (end - kExactBlock));
        for (std::size_t c = 0; c < block_pointers.size(); ++c)
            block_pointers[c] = block_outputs[c].data() + offset;
        r.render(block_signals, offset, {}, block_pointers, static_cast<int>(part_end - first));
        first = part_end;
    }
    std::erase_if(block_inputs, [](const auto& entry) { return !entry.second.given; });
    for (auto& [number, input] : block_inputs) {
        std::fill(input.samples.begin(), input.samples.end(), 0.0F);
        input.given = false;
    }
    filled = 0;
}

Auralizer::Auralizer(const Scene& scene, AuralizerOptions options)
    : state_(std::make_unique<State>(scene, std::move(options))) {
    State& s = *state_;
    s.thread = std::thread([this, &s] { s.run(*this); });
    s.built.get_future().get();
    {
        const std::lock_guard lock(s.mutex);
        s.started = true;
    }
    s.changed.notify_all();
}

// While the object is whole: its thread may be in before_frame.
Auralizer::~Auralizer() { state_->end(); }

SourceId Auralizer::add_source(const NewSource& source, std::int64_t at) {
    State& s = *state_;
    check_position(source.position);
    check_gain(source.gain_db);
    const std::lock_guard lock(s.mutex);
    const std::int64_t time = s.time_of(at);
    const SourceId id{s.last_number + 1};
    const std::size_t slot = s.take_slot(id, time);
    s.last_number = id.number;
    s.sources.push_back(id);
    const SourceState state{
        .id = id.number,
        .slot = slot,
        .name = source.name.empty() ? "source " + std::to_string(id.number) : source.name,
        .position = source.position,
        .gain_db = source.gain_db};
    s.changes.add(time, [state](Room& room) {
        // The slot's ringing source ends.
        std::erase_if(room.state.sources,
                      [&](const SourceState& other) { return other.slot == state.slot; });
        room.state.sources.push_back(state);
    });
    s.route(slot, id, time);
    return id;
}

void Auralizer::remove_source(SourceId source, std::int64_t at) {
    State& s = *state_;
    const std::lock_guard lock(s.mutex);
    for (std::size_t slot = 0; slot < s.slots.size(); ++slot) {
        if (source.number == 0 || s.slots[slot].source != source) continue;
        const std::int64_t time = std::max(s.time_of(at), s.slots[slot].begins_at);
        const std::int64_t rung_out_at = saturated_sum(time, s.tail_samples);
        s.slots[slot] = {.source = {}, .removed_at = time, .rung_out_at = rung_out_at};
        std::erase(s.sources, source);
        s.change_source(source, time, [rung_out_at](SourceState& state) {
            state.ringing = true;
            state.rung_out_at = rung_out_at;
        });
        s.route(slot, {}, time);
    }
}

std::vector<SourceId> Auralizer::sources() const {
    const std::lock_guard lock(state_->mutex);
    return state_->sources;
}

void Auralizer::set_source(SourceId source, const Pose& pose, std::int64_t at) {
    check_position(pose.position);
    const std::lock_guard lock(state_->mutex);
    state_->change_source(source, state_->time_of(at),
                          [position = pose.position](SourceState& s) { s.position = position; });
}

void Auralizer::set_gain(SourceId source, float gain_db, std::int64_t at) {
    check_gain(gain_db);
    const std::lock_guard lock(state_->mutex);
    state_->change_source(source, state_->time_of(at),
                          [gain_db](SourceState& s) { s.gain_db = gain_db; });
}

void Auralizer::set_listener(std::size_t listener, const Pose& pose, std::int64_t at) {
    State& s = *state_;
    if (listener >= s.options.listeners)
        throw InputError("auralizer: there is no listener " + std::to_string(listener));
    check_pose(pose);
    const std::lock_guard lock(s.mutex);
    const std::int64_t time = s.time_of(at);
    s.changes.add(time, [listener, pose](Room& room) { room.state.listeners[listener] = pose; });
    s.turn_head(listener, pose, time);
}

void Auralizer::set_transform(std::size_t object, const RigidTransform& transform,
                              std::int64_t at) {
    State& s = *state_;
    s.check_object(object);
    if (!s.scene.objects[object].moves())
        throw InputError("auralizer: the object " + s.name_of(object) + " is not movable");
    check_transform(transform);
    const std::lock_guard lock(s.mutex);
    s.changes.add(s.time_of(at),
                  [object, transform](Room& room) { room.state.objects[object] = transform; });
}

void Auralizer::set_material(std::size_t object, const std::string& name, std::int64_t at) {
    set_material(object, state_->scene.find_material(name), at);
}

void Auralizer::set_material(std::size_t object, const Material& material, std::int64_t at) {
    State& s = *state_;
    s.check_object(object);
    check_material(material);
    const std::lock_guard lock(s.mutex);
    s.changes.add(s.time_of(at), [object, material](Room& room) {
        room.materials.push_back(
            [object, material](FrameMaker& maker) { maker.set_object_material(object, material); });
    });
}

void Auralizer::commit(std::int64_t until) {
    {
        const std::lock_guard lock(state_->mutex);
        state_->committed = std::max(state_->committed, until);
    }
    state_->changed.notify_all();
}

void Auralizer::pause() { state_->paused.store(true); }

void Auralizer::resume() { state_->paused.store(false); }

void Auralizer::render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                       int samples) {
    need(outputs.size() == output_channels(), "outputs are not output_channels() signals");
    if (state_->exact)
        state_->render_exact(inputs, outputs, samples);
    else
        state_->render_real_time(inputs, outputs, samples);
}

std::size_t Auralizer::output_channels() const {
    return state_->options.listeners * channel_count(state_->options.output);
}

int Auralizer::latency_samples() const { return state_->exact ? kExactBlock : 0; }

double Auralizer::sample_rate_hz() const { return state_->rate_hz; }

double Auralizer::response_length_s() const { return state_->response_length_s; }

std::int64_t Auralizer::tail_samples() const { return state_->tail_samples; }

std::vector<std::vector<float>> Auralizer::impulse_response(SourceId source,
                                                            std::size_t listener) const {
    State& s = *state_;
    Pose head;
    SourceSound sound;
    std::vector<std::vector<float>> channels;
    {
        const std::lock_guard computing(s.frame_mutex);
        const SourceSound* const newest =
            listener < s.options.listeners ? s.maker->sound(source.number, listener) : nullptr;
        if (newest == nullptr || newest->absent) return {};
        sound = *newest;
        for (std::span<const float>& channel : sound.ambisonics) {
            if (channel.empty()) continue;
            channels.emplace_back(channel.begin(), channel.end());
            channel = channels.back();
        }
        head = s.maker->listener(listener);
    }
    return render_response(sound, s.maker->config(), s.response_length_s, head, s.hrtf);
}

bool Auralizer::visible(SourceId source, std::size_t listener) const {
    const std::lock_guard lock(state_->mutex);
    for (const State::Sight& sight : state_->sights)
        if (sight.source == source)
            return listener < sight.visible.size() && sight.visible[listener];
    return false;
}

AuralizerStatus Auralizer::status() const {
    const std::lock_guard lock(state_->mutex);
    if (state_->failure) std::rethrow_exception(state_->failure);
    AuralizerStatus status = state_->status;
    status.samples = state_->rendered.load();
    status.paused = state_->silent.load();
    return status;
}

std::function<void(Auralizer&, double)> follow_paths(const Scene& scene) {
    return [scene](Auralizer& auralizer, double time_s) {
        for (std::size_t i = 0; i < scene.sources.size(); ++i) {
            if (!scene.sources[i].path) continue;
            Pose pose;
            pose.position = scene.sources[i].position_at(time_s);
            // The scene's sources have the first numbers.
            auralizer.set_source({i + 1}, pose);
        }
        if (scene.listener.path) auralizer.set_listener(scene.listener.pose_at(time_s));
        for (std::size_t o = 0; o < scene.objects.size(); ++o)
            if (scene.objects[o].path)
                auralizer.set_transform(o, scene.objects[o].transform_at(time_s));
    };
}

}  // namespace aula
