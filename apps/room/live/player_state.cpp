#include "apps/room/live/player_state.h"

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "apps/room/base/patch_warning.h"
#include "apps/room/frames/ray_budget.h"
#include "aula/exception.h"

namespace aula {

Player::State::State(const Scene& scene, const PlaybackOptions& options) {
    rate_hz = options.sample_rate_hz;
    build(scene, options);
    try {
        open_device(options);
    } catch (const SampleRateRefused& refused) {
        rate_hz = refused.device_rate_hz();
        build(scene, options);
        open_device(options);
        warnings.push_back("the output device \"" + device->info().name + "\" plays at " +
                           std::to_string(std::lround(rate_hz)) + " Hz, not at " +
                           std::to_string(std::lround(options.sample_rate_hz)));
    }
    device_rate_hz = rate_hz;
    load = load_of(*playing);
    auralizer->set_state(playing->number, playing->state(controls_of(*playing, *load), 0));
    take_frame(auralizer->compute_first(0));
    changes = std::make_unique<ChangePreparer>(
        rate_hz,
        ChangePreparer::Hooks{
            .reusable = [this] { return reusable(); },
            .state = [this](const PreparedScene& prepared) { return state_of(prepared); },
            .begin = [this](std::unique_ptr<PreparedScene> prepared,
                            std::uint64_t number) { return begin(std::move(prepared), number); }});
    device->start();
    start();
}

Player::State::~State() {
    {
        const std::lock_guard lock(mutex);
        stop = true;
    }
    // The sound and its recording end first, because the present frame may take long.
    fade_out();
    device->stop();
    monitor.reset();
    changes->stop();
    auralizer->stop();
}

/// Waits until the last fade has been played.
void Player::State::fade_out() {
    constexpr int kMaxTurns = 50;
    constexpr std::chrono::milliseconds kTurn{5};
    mixer->pause(true);
    for (int turn = 0; turn < kMaxTurns && device->active() && !mixer->silent(); ++turn)
        std::this_thread::sleep_for(kTurn);
}

/// Builds everything except the device, so that errors of the input are reported before a device is
/// opened.
void Player::State::build(const Scene& scene, const PlaybackOptions& options) {
    PlaybackOptions at_rate = options;
    at_rate.sample_rate_hz = rate_hz;
    playing = std::make_unique<PreparedScene>(scene, at_rate, false);
    warnings = warnings_of(playing->signals);
    monitor.reset();
    mixer.reset();
    auralizer = std::move(playing->auralizer);
    warn_of_patch_size(scene.simulation, auralizer->room().patch_size_m(), warnings);
    mixer = std::make_unique<LiveMixer>(*auralizer, options.block);
    monitor = std::make_unique<Monitor>(*mixer, rate_hz);
}

void Player::State::open_device(const PlaybackOptions& options) {
    device = std::make_unique<AudioDevice>(
        options.device, rate_hz, channel_count(options.output), options.block,
        [this](std::span<float* const> outputs, int samples) { mixer->render(outputs, samples); },
        [this](double device_hz) { return follow_rate(device_hz); });
}

/// Has what plays prepared for the sample rate of the device, as a change that continues it.
/// Returns whether it is. Throws Failure if it cannot be prepared. [watching thread]
bool Player::State::follow_rate(double device_hz) {
    const std::lock_guard lock(mutex);
    device_rate_hz = device_hz;
    changes->set_sample_rate(device_hz);
    if (exchanges_auralizer) return false;
    if (rate_hz == device_hz) {
        requested_rate_hz.reset();
        return true;
    }
    if (requested_rate_hz != device_hz) {
        requested_rate_hz = device_hz;
        Scene scene = playing->scene;
        if (playing->room_length_s) scene.simulation.ir_length_s.reset();
        changes->request(std::move(scene), playing->options, false);
        return false;
    }
    const ChangePreparer::Status now = changes->status();
    if (now.preparing) return false;
    requested_rate_hz.reset();
    throw Failure("the scene cannot be played at " + std::to_string(std::lround(device_hz)) +
                  " Hz: " + now.error);
}

/// Starts the frames of the auralizer.
void Player::State::start() {
    auralizer->start(
        [this](double time_s) { before_frame(time_s); },
        {.played_s = [this, played = mixer.get()] { return played->time_s() - playing->zero_s; },
         .after_frame = [this](const FrameMaker& maker,
                               double spare_s) { after_frame(maker, spare_s); },
         .scene_begins = [this] { take_next(); },
         .scene_has_begun = [this](const FrameMaker& maker) { take_first(maker); }});
}

/// Switches to a prepared scene, and waits until its first frame has been handed over. False if it
/// has a sample rate that the device no longer has. [preparing thread]
bool Player::State::begin(std::unique_ptr<PreparedScene> prepared, std::uint64_t number) {
    if (prepared->auralizer) return begin_at_other_rate(std::move(prepared), number);
    std::uint64_t scene = 0;
    {
        const std::lock_guard lock(mutex);
        if (stop) return true;
        next = std::move(prepared);
        next_change = number;
        scene = next->number = auralizer->begin(next->built);
    }
    auralizer->wait_for(scene);
    std::unique_ptr<PreparedScene> unused;  // destroyed after the lock
    const std::lock_guard lock(mutex);
    std::swap(unused, replaced);
    return true;
}

/// The scene that is to begin becomes the present one. [propagation thread]
void Player::State::take_next() {
    const std::lock_guard lock(mutex);
    if (next) switch_to_next();
}

/// The mutex is locked.
void Player::State::switch_to_next() {
    if (next->starts_anew) {
        controls = {};
        next->zero_s = mixer->time_s();
    } else {
        next->take_signals(*playing);
        next->zero_s = playing->zero_s;
    }
    load = load_of(*next);
    replaced = std::exchange(playing, std::move(next));
}

/// The first frame of the present scene has been handed over. [propagation thread]
void Player::State::take_first(const FrameMaker& maker) {
    const std::lock_guard lock(mutex);
    if (status.audible_change != next_change) note_begun(maker);
}

/// The mutex is locked.
void Player::State::note_begun(const FrameMaker& maker) {
    if (playing->starts_anew) playing->zero_s = mixer->time_s();
    take_frame(maker);
    status.audible_change = next_change;
    changes->set_begun();
}

/// Exchanges auralizer and mixer, which no device calls, for those of a scene of another sample
/// rate. [preparing thread]
bool Player::State::begin_at_other_rate(std::unique_ptr<PreparedScene> prepared,
                                        std::uint64_t number) {
    LiveAuralizer& other = *prepared->auralizer;
    RoomState state = state_of(*prepared);
    const double time_s = state.time_s;
    other.room().set_listener(state.listeners[0]);
    other.set_state(0, std::move(state));
    const FrameMaker& maker = other.compute_first(time_s);
    {
        const std::lock_guard lock(mutex);
        if (stop) return true;
        if (prepared->options.sample_rate_hz != device_rate_hz) return false;
        exchanges_auralizer = true;
    }
    // No frame uses what plays from here on.
    auralizer->stop();
    std::unique_ptr<LiveAuralizer> old_auralizer;
    std::unique_ptr<LiveMixer> old_mixer;
    std::unique_ptr<PreparedScene> unused;
    const std::lock_guard lock(mutex);
    exchanges_auralizer = false;
    if (stop) return true;
    earlier = frames_so_far();
    next = std::move(prepared);
    next_change = number;
    rate_hz = next->options.sample_rate_hz;
    other.begin_at(std::llround(mixer->time_s() * rate_hz));
    next->playback.follow(
        {.number = playing->start, .zero = std::llround(playing->zero_s * rate_hz)});
    old_auralizer = std::exchange(auralizer, std::move(next->auralizer));
    old_mixer = std::exchange(mixer, std::make_unique<LiveMixer>(*auralizer, next->options.block));
    monitor->follow(*mixer, rate_hz);
    switch_to_next();
    // A pose that has been set meanwhile.
    if (controls.listener) auralizer->room().set_listener(*controls.listener);
    note_begun(maker);
    start();
    std::swap(unused, replaced);
    return true;
}

Reusable Player::State::reusable() {
    const std::lock_guard lock(mutex);
    return {playing->scene.sources, playing->signals, playing->options, playing->start,
            auralizer.get()};
}

/// The state in which a prepared scene would begin now.
RoomState Player::State::state_of(const PreparedScene& prepared) {
    if (prepared.starts_anew) return prepared.state({}, 0);
    const std::lock_guard lock(mutex);
    return prepared.state(controls_of(prepared, load_of(prepared)),
                          mixer->time_s() - playing->zero_s);
}

void Player::State::before_frame(double time_s) {
    const std::lock_guard lock(mutex);
    RoomState state = playing->state(controls_of(*playing, *load), time_s);
    // A pose of the user is set by place_listener() only, so that no older one follows a newer one.
    if (!controls.listener) auralizer->room().set_listener(state.listeners[0]);
    auralizer->set_state(playing->number, std::move(state));
}

void Player::State::after_frame(const FrameMaker& maker, double spare_s) {
    {
        const std::lock_guard lock(mutex);
        take_frame(maker);
    }
    const double took_ms = auralizer->room().status().frame_ms;
    compute_time.add(static_cast<std::int64_t>(1e6 * took_ms));
    keep_up(took_ms / 1000);
    show(maker, spare_s);
}

/// Copies the newest frame's data for the status. The mutex is locked, or nothing plays yet.
void Player::State::take_frame(const FrameMaker& maker) {
    status.listener = maker.listener(0);
    status.sources = maker.source_positions();
    status.frame = maker.statistics();
}

/// Reduces rays or response length if frames take too long, and increases them if there is room. A
/// response of another length requires a prepared change.
void Player::State::keep_up(double took_s) {
    const std::optional<double> length_s = other_length_s(took_s);
    if (!length_s) return;
    // Copied without the lock: a scene can be large.
    Scene scene = playing->scene;
    scene.simulation.ir_length_s.reset();
    PlaybackOptions options = playing->options;
    options.longest_response_s = length_s;
    const std::lock_guard lock(mutex);
    if (changes->request_if_idle(std::move(scene), std::move(options)) > 0)
        longest_response_s = length_s;
}

/// Adds a frame to the load, which may change the rays. Returns another length of the response if
/// the load needs or allows one.
std::optional<double> Player::State::other_length_s(double took_s) {
    const std::lock_guard lock(mutex);
    // Preparation slows down the present frames.
    if (changes->status().preparing) {
        load->restart();
        return {};
    }
    load->add(took_s, 1.0 / static_cast<double>(playing->scene.simulation.frame_rate_hz),
              rays_fall(*playing));
    const double length_s = load->length_s();
    const double present_s = playing->response_length_s();
    if (length_s == present_s) return {};
    // Until the change begins the length is the present one. If the change fails, the load is
    // measured again.
    load->change(load->full(), load->rays(), present_s);
    return length_s;
}

/// Copies the frame for display if there is time until it is due, or if the last copy is old.
void Player::State::show(const FrameMaker& maker, double spare_s) {
    constexpr double kEnough_s = 0.004;
    constexpr std::chrono::milliseconds kLong{250};
    std::optional<ViewRequest> wanted_view;
    std::uint64_t frame = 0;
    std::uint64_t change = 0;
    {
        const std::lock_guard lock(mutex);
        wanted_view = request;
        frame = frames_so_far().frames;
        change = status.audible_change;
    }
    if (!wanted_view || (spare_s < kEnough_s && Clock::now() < shown + kLong)) return;
    auto made = std::make_shared<FrameView>(maker.view(*wanted_view));
    made->frame = frame;
    made->change = change;
    shown = Clock::now();
    std::shared_ptr<const FrameView> replaced_view = std::move(made);
    const std::lock_guard lock(mutex);
    std::swap(view, replaced_view);
}

/// The frames of all auralizers so far. The mutex is locked.
AuralizerStatus Player::State::frames_so_far() const {
    AuralizerStatus all = auralizer->room().status();
    const double sum_ms = earlier.frame_mean_ms * static_cast<double>(earlier.frames) +
                          all.frame_mean_ms * static_cast<double>(all.frames);
    all.frames += earlier.frames;
    all.late_frames += earlier.late_frames;
    all.skipped_frames += earlier.skipped_frames;
    all.muted_samples += earlier.muted_samples;
    all.frame_mean_ms = sum_ms / static_cast<double>(all.frames);
    all.frame_worst_ms = std::max(all.frame_worst_ms, earlier.frame_worst_ms);
    return all;
}

/// What the player knows without its device and its mixer. The mutex is locked.
PlayStatus Player::State::status_so_far() const {
    PlayStatus all = status;
    static_cast<AuralizerStatus&>(all) = frames_so_far();
    all.full_rays = rays_fall(*playing) ? load->full().rays : all.rays;
    all.full_response_length_s = load->full().length_s;
    return all;
}

/// Whether the player may change the number of rays. The mutex is locked.
bool Player::State::rays_fall(const PreparedScene& prepared) const {
    return prepared.options.rays_fall && !controls.rays && !controls.frame_share;
}

/// The controls of a prepared scene, with the number of rays that keeps its frames in time. The
/// mutex is locked.
PlayControls Player::State::controls_of(const PreparedScene& prepared, const LiveLoad& with) const {
    PlayControls now = controls;
    if (rays_fall(prepared)) now.rays = with.rays();
    return now;
}

/// Rays and response length of a prepared scene, as in the previous one if it continues.
LiveLoad Player::State::load_of(const PreparedScene& prepared) const {
    const double length_s = prepared.response_length_s();
    const LiveLoad::Full full{.rays = live_rays(prepared.scene.simulation),
                              .length_s = prepared.room_length_s.value_or(length_s),
                              .rays_fall = prepared.options.rays_fall,
                              .length_falls = prepared.room_length_s.has_value()};
    // A first frame of many rays takes seconds; the rays increase while there is time.
    if (!load || prepared.starts_anew)
        return {full, full.rays_fall ? std::min(full.rays, Simulation::kRays) : full.rays,
                length_s};
    LiveLoad next = *load;
    next.change(full, full.rays_fall ? std::min(load->rays(), full.rays) : full.rays, length_s);
    return next;
}

/// Sets the listener's pose from the user. The mutex is locked.
void Player::State::place_listener(const Pose& pose) {
    controls.listener = pose;
    auralizer->room().set_listener(pose);
}

/// The mutex is held.
void Player::State::take_controls(PlayControls next) {
    const bool placed =
        next.listener && !(controls.listener && same_pose(*controls.listener, *next.listener));
    controls = std::move(next);
    if (placed) place_listener(*controls.listener);
}

PoseLatency Player::State::latency(double frame_period_ms) const {
    const LatencyCounts& frames = mixer->frame_latency();
    const LatencyCounts& heads = mixer->head_latency();
    return {.frame_period_ms = frame_period_ms,
            .compute_p50_ms = compute_time.quantile_ms(0.5),
            .compute_p99_ms = compute_time.quantile_ms(0.99),
            .sound_p50_ms = frames.quantile_ms(0.5),
            .sound_p99_ms = frames.quantile_ms(0.99),
            .head_p50_ms = heads.quantile_ms(0.5),
            .head_p99_ms = heads.quantile_ms(0.99),
            .call_p99_ms = mixer->call_interval().quantile_ms(0.99)};
}

}  // namespace aula
