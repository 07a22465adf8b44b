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
    playing->apply(controls_of(*playing, *load), 0, true);
    take_frame(playing->auralizer.compute_first(0));
    sounding.push_back(&playing->auralizer);
    mixer->playbacks().publish(std::move(playing->playback));
    changes = std::make_unique<ChangePreparer>(
        rate_hz,
        ChangePreparer::Hooks{
            .reusable = [this] { return reusable(); },
            .apply_controls = [this](PreparedScene& next) { apply_controls(next); },
            .begin = [this](std::unique_ptr<PreparedScene> prepared,
                            std::uint64_t number) { return begin(std::move(prepared), number); }});
    device->start();
    start(*playing);
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
    playing->auralizer.stop();
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
    warn_of_patch_size(scene.simulation, playing->auralizer.room().patch_size_m(), warnings);
    monitor.reset();
    mixer = std::make_unique<LiveMixer>(rate_hz, options.block, channel_count(options.output));
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

/// Starts the frames of the playback in the mixer.
void Player::State::start(PreparedScene& prepared) {
    prepared.auralizer.start(
        {.played_s = [playing_mixer = mixer.get(),
                      &prepared] { return playing_mixer->time_s() - prepared.zero_s; },
         .before_frame = [this, &prepared](double time_s) { before_frame(prepared, time_s); },
         .after_frame = [this, &prepared](
                            const FrameMaker& maker,
                            double spare_s) { after_frame(prepared, maker, spare_s); }});
}

/// Switches to a prepared scene: its first frame goes to the mixer with its playback. False if it
/// has a sample rate that the device no longer has. [preparing thread]
bool Player::State::begin(std::unique_ptr<PreparedScene> prepared, std::uint64_t number) {
    PreparedScene& next = *prepared;
    const FrameMaker& maker = next.auralizer.compute_first(apply_controls(next));
    std::unique_ptr<PreparedScene> before;
    std::unique_ptr<LiveMixer> other_rate;  ///< the mixer of another sample rate before
    {
        const std::lock_guard lock(mutex);
        if (stop) return true;
        const bool has_other_rate = next.options.sample_rate_hz != rate_hz;
        if (has_other_rate && next.options.sample_rate_hz != device_rate_hz) return false;
        earlier = frames_so_far();
        if (next.starts_anew) {
            controls = {};
            next.zero_s = mixer->time_s();
        } else {
            next.take_signals(*playing);
            next.zero_s = playing->zero_s;
        }
        // A pose that has been set meanwhile.
        if (controls.listener) next.auralizer.room().set_listener(*controls.listener);
        load = load_of(next);
        // publish() frees playbacks that circulate too long; `sounding` must not name them then.
        retire_used_playbacks();
        if (has_other_rate) other_rate = exchange_mixer(next);
        sounding.push_back(&next.auralizer);
        mixer->playbacks().publish(std::move(next.playback));
        before = std::exchange(playing, std::move(prepared));
        take_frame(maker);
        status.audible_change = number;
        changes->set_begun();
    }
    before->auralizer.stop();
    start(next);
    return true;
}

/// Replaces the mixer, which no device calls, by one of another sample rate, in which a scene goes
/// on at the present time. Returns the mixer before it, with all playbacks before this one. The
/// mutex is locked.
std::unique_ptr<LiveMixer> Player::State::exchange_mixer(const PreparedScene& next) {
    const SignalStart before{.number = playing->start,
                             .zero = std::llround(playing->zero_s * next.options.sample_rate_hz)};
    auto made = std::make_unique<LiveMixer>(next.options.sample_rate_hz, next.options.block,
                                            mixer->channels(), mixer->time_s(), before);
    rate_hz = next.options.sample_rate_hz;
    sounding.clear();
    monitor->follow(*made, rate_hz);
    return std::exchange(mixer, std::move(made));
}

Reusable Player::State::reusable() {
    const std::lock_guard lock(mutex);
    return playing->reusable();
}

/// Gives a prepared scene the controls with which it would begin now. Returns its time.
double Player::State::apply_controls(PreparedScene& next) {
    PlayControls with;
    double time_s = 0;
    if (!next.starts_anew) {
        const std::lock_guard lock(mutex);
        with = controls_of(next, load_of(next));
        time_s = mixer->time_s() - playing->zero_s;
    }
    next.apply(with, time_s, true);
    return time_s;
}

void Player::State::before_frame(PreparedScene& prepared, double time_s) {
    const std::lock_guard lock(mutex);
    if (playing.get() == &prepared) prepared.apply(controls_of(prepared, *load), time_s);
}

void Player::State::after_frame(PreparedScene& prepared, const FrameMaker& maker, double spare_s) {
    {
        const std::lock_guard lock(mutex);
        if (playing.get() != &prepared) return;
        take_frame(maker);
        // A pose set by the user has already turned all heads.
        if (!controls.listener) turn_ringing_heads(maker.listener(0));
    }
    const double took_ms = prepared.auralizer.room().status().frame_ms;
    compute_time.add(static_cast<std::int64_t>(1e6 * took_ms));
    keep_up(prepared, took_ms / 1000);
    show(prepared, maker, spare_s);
    reclaim_playbacks();
}

/// Copies the newest frame's data for the status. The mutex is locked, or nothing plays yet.
void Player::State::take_frame(const FrameMaker& maker) {
    status.listener = maker.listener(0);
    status.sources = maker.source_positions();
    status.frame = maker.statistics();
}

/// Reduces rays or response length if frames take too long, and increases them if there is room. A
/// response of another length requires a prepared change.
void Player::State::keep_up(PreparedScene& prepared, double took_s) {
    const std::optional<double> length_s = other_length_s(prepared, took_s);
    if (!length_s) return;
    // Copied without the lock: a scene can be large.
    Scene scene = prepared.scene;
    scene.simulation.ir_length_s.reset();
    PlaybackOptions options = prepared.options;
    options.longest_response_s = length_s;
    const std::lock_guard lock(mutex);
    if (playing.get() != &prepared) return;
    if (changes->request_if_idle(std::move(scene), std::move(options)) > 0)
        longest_response_s = length_s;
}

/// Adds a frame to the load, which may change the rays. Returns another length of the response if
/// the load needs or allows one.
std::optional<double> Player::State::other_length_s(const PreparedScene& prepared, double took_s) {
    const std::lock_guard lock(mutex);
    if (playing.get() != &prepared) return {};
    // Preparation slows down the present frames.
    if (changes->status().preparing) {
        load->restart();
        return {};
    }
    load->add(took_s, 1.0 / static_cast<double>(prepared.scene.simulation.frame_rate_hz),
              rays_fall(prepared));
    const double length_s = load->length_s();
    const double present_s = prepared.auralizer.room().response_length_s();
    if (length_s == present_s) return {};
    // Until the change begins the length is the present one. If the change fails, the load is
    // measured again.
    load->change(load->full(), load->rays(), present_s);
    return length_s;
}

/// Copies the frame for display if there is time until it is due, or if the last copy is old.
void Player::State::show(const PreparedScene& prepared, const FrameMaker& maker, double spare_s) {
    constexpr double kEnough_s = 0.004;
    constexpr std::chrono::milliseconds kLong{250};
    std::optional<ViewRequest> wanted_view;
    std::uint64_t frame = 0;
    std::uint64_t change = 0;
    {
        const std::lock_guard lock(mutex);
        // The view of a replaced scene must not carry the number of the new change.
        if (playing.get() != &prepared) return;
        wanted_view = request;
        frame = frames_so_far().frames;
        change = status.audible_change;
    }
    if (!wanted_view || (spare_s < kEnough_s && Clock::now() < shown + kLong)) return;
    auto made = std::make_shared<FrameView>(maker.view(*wanted_view));
    made->frame = frame;
    made->change = change;
    shown = Clock::now();
    std::shared_ptr<const FrameView> replaced = std::move(made);
    const std::lock_guard lock(mutex);
    std::swap(view, replaced);
}

void Player::State::reclaim_playbacks() {
    const std::lock_guard lock(mutex);
    retire_used_playbacks();
}

/// Destroys playbacks that the mixer no longer renders, on the preparing thread. The mutex is
/// locked.
void Player::State::retire_used_playbacks() {
    while (auto playback = mixer->playbacks().reclaim()) {
        std::erase(sounding, &playback->auralizer());
        changes->retire(std::move(playback));
    }
}

/// The frames of all auralizers so far. The mutex is locked.
AuralizerStatus Player::State::frames_so_far() const {
    AuralizerStatus all = playing->auralizer.room().status();
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
    const double length_s = prepared.auralizer.room().response_length_s();
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
    playing->auralizer.room().set_listener(pose);
    turn_ringing_heads(pose);
}

/// The mutex is held.
void Player::State::turn_ringing_heads(const Pose& pose) {
    for (LiveAuralizer* const auralizer : sounding)
        if (auralizer != &playing->auralizer) auralizer->turn_head(pose);
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
