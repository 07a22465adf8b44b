#include "apps/session/live/player.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "apps/session/live/change_preparer.h"
#include "apps/session/live/live_load.h"
#include "apps/session/live/live_mixer.h"
#include "apps/session/live/prepared_scene.h"
#include "aula/exception.h"

namespace aula {

struct Player::State {
    using Clock = std::chrono::steady_clock;

    State(const Scene& scene, const SessionOptions& options);
    ~State();

    void build(const Scene& scene, const SessionOptions& options);
    void open_device(const SessionOptions& options);
    void fade_out();

    void start(PreparedScene& prepared);
    void begin(std::unique_ptr<PreparedScene> prepared, std::uint64_t number);
    Reusable reusable();
    double apply_controls(PreparedScene& next);
    void before_frame(PreparedScene& prepared, double time_s);
    void after_frame(PreparedScene& prepared, const FrameMaker& maker, double spare_s);
    void take_frame(const FrameMaker& maker);
    void keep_up(PreparedScene& prepared, double took_s);
    std::optional<double> shorter_response_s(const PreparedScene& prepared, double took_s);
    void show(const PreparedScene& prepared, const FrameMaker& maker, double spare_s);
    void reclaim_playbacks();
    void retire_used_playbacks();

    AuralizerStatus frames_so_far() const;
    bool rays_fall(const PreparedScene& prepared) const;
    PlayControls controls_of(const PreparedScene& prepared, const LiveLoad& with) const;
    LiveLoad load_of(const PreparedScene& prepared) const;
    void place_listener(const Pose& pose);
    void turn_ringing_heads(const Pose& pose);
    void take_controls(PlayControls next);
    PoseLatency latency(double frame_period_ms) const;

    double rate_hz = 0;
    std::vector<std::string> warnings;
    std::unique_ptr<LiveMixer> mixer;
    std::unique_ptr<Monitor> monitor;
    LatencyCounts compute_time;

    std::mutex mutex;  ///< protects the following members
    bool stop = false;
    std::unique_ptr<PreparedScene> playing;  ///< its auralizer's thread may use it without the lock
    std::vector<LiveAuralizer*>
        sounding;  ///< auralizers of all playbacks that the mixer may render
    PlayControls controls;
    PlayStatus status;
    AuralizerStatus earlier;  ///< frames and times of earlier auralizers
    std::optional<ViewRequest> request;
    std::shared_ptr<const FrameView> view;
    Clock::time_point shown;                   ///< when the last view was made
    std::optional<LiveLoad> load;              ///< of what plays
    std::optional<double> longest_response_s;  ///< with which frames are in time; empty: any

    std::unique_ptr<AudioDevice> device;  ///< destroyed before the mixer that it calls
    std::unique_ptr<ChangePreparer> changes;
};

Player::State::State(const Scene& scene, const SessionOptions& options) {
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
    load = load_of(*playing);
    playing->apply(controls, 0, true);
    take_frame(playing->auralizer.compute_first(0));
    sounding.push_back(&playing->auralizer);
    mixer->playbacks().publish(std::move(playing->playback));
    device->start();
    changes = std::make_unique<ChangePreparer>(
        rate_hz,
        ChangePreparer::Hooks{
            .reusable = [this] { return reusable(); },
            .apply_controls = [this](PreparedScene& next) { apply_controls(next); },
            .begin = [this](std::unique_ptr<PreparedScene> prepared,
                            std::uint64_t number) { begin(std::move(prepared), number); }});
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
void Player::State::build(const Scene& scene, const SessionOptions& options) {
    playing = std::make_unique<PreparedScene>(scene, options, rate_hz, false);
    warnings = warnings_of(playing->signals);
    monitor.reset();
    mixer = std::make_unique<LiveMixer>(rate_hz, options.block, channel_count(options.output));
    monitor = std::make_unique<Monitor>(*mixer, rate_hz);
}

void Player::State::open_device(const SessionOptions& options) {
    device = std::make_unique<AudioDevice>(
        options.device, rate_hz, channel_count(options.output), options.block,
        [this](std::span<float* const> outputs, int samples) { mixer->render(outputs, samples); });
}

/// Starts the frames of the playback in the mixer.
void Player::State::start(PreparedScene& prepared) {
    prepared.auralizer.start(
        {.played_s = [this, &prepared] { return mixer->time_s() - prepared.zero_s; },
         .before_frame = [this, &prepared](double time_s) { before_frame(prepared, time_s); },
         .after_frame = [this, &prepared](
                            const FrameMaker& maker,
                            double spare_s) { after_frame(prepared, maker, spare_s); }});
}

/// Switches to a prepared scene: its first frame goes to the mixer with its playback. [preparing
/// thread]
void Player::State::begin(std::unique_ptr<PreparedScene> prepared, std::uint64_t number) {
    PreparedScene& next = *prepared;
    const FrameMaker& maker = next.auralizer.compute_first(apply_controls(next));
    std::unique_ptr<PreparedScene> before;
    {
        const std::lock_guard lock(mutex);
        if (stop) return;
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
        sounding.push_back(&next.auralizer);
        mixer->playbacks().publish(std::move(next.playback));
        before = std::exchange(playing, std::move(prepared));
        take_frame(maker);
        status.audible_change = number;
        changes->set_begun();
    }
    before->auralizer.stop();
    start(next);
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
    status.rays = maker.rays();
    status.full_rays = rays_fall(*playing) ? load->full().rays : status.rays;
    status.response_length_s = maker.response_length_s();
    status.full_response_length_s = load->full().length_s;
}

/// Reduces rays or response length if frames take too long. A shorter response requires a prepared
/// change.
void Player::State::keep_up(PreparedScene& prepared, double took_s) {
    const std::optional<double> shorter_s = shorter_response_s(prepared, took_s);
    if (!shorter_s) return;
    // Copied without the lock: a scene can be large.
    Scene scene = prepared.scene;
    scene.simulation.ir_length_s.reset();
    SessionOptions options = prepared.options;
    options.longest_response_s = shorter_s;
    const std::lock_guard lock(mutex);
    if (playing.get() != &prepared) return;
    if (changes->request_if_idle(std::move(scene), std::move(options)) > 0)
        longest_response_s = shorter_s;
}

/// Adds a frame to the load, which may reduce the rays. Returns a shorter length of the response if
/// one is needed.
std::optional<double> Player::State::shorter_response_s(const PreparedScene& prepared,
                                                        double took_s) {
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
    if (length_s >= present_s) return {};
    // Until the change begins the length is the present one. If the change fails, the load is
    // measured again.
    load = LiveLoad(load->full(), load->rays(), present_s);
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
    all.frame_mean_ms = sum_ms / static_cast<double>(all.frames);
    all.frame_worst_ms = std::max(all.frame_worst_ms, earlier.frame_worst_ms);
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

/// Rays and response length of a prepared scene, reduced as in the previous one.
LiveLoad Player::State::load_of(const PreparedScene& prepared) const {
    LiveLoad::Full full{.rays = prepared.scene.simulation.rays,
                        .length_s = prepared.auralizer.room().response_length_s(),
                        .rays_fall = prepared.options.rays_fall,
                        .length_falls = !prepared.length_given};
    const bool shortened = full.length_falls && prepared.options.longest_response_s;
    const double length_s = full.length_s;
    if (shortened && load) full.length_s = load->full().length_s;
    const bool goes_on = load && !prepared.starts_anew && full.rays_fall;
    return {full, goes_on ? std::min(load->rays(), full.rays) : full.rays, length_s};
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

Player::Player(const Scene& scene, const SessionOptions& options)
    : state_(std::make_unique<State>(scene, options)) {}

Player::~Player() = default;

void Player::move_listener(const Pose& pose) {
    const std::lock_guard lock(state_->mutex);
    if (!state_->playing->scene.listener.path) state_->place_listener(pose);
}

void Player::control(const PlayControls& controls) {
    const std::lock_guard lock(state_->mutex);
    state_->take_controls(controls);
}

PlayControls Player::controls() const {
    const std::lock_guard lock(state_->mutex);
    return state_->controls;
}

void Player::adjust(const std::function<void(PlayControls&, const Pose&)>& change) {
    const std::lock_guard lock(state_->mutex);
    PlayControls next = state_->controls;
    change(next, state_->status.listener);
    state_->take_controls(std::move(next));
}

std::vector<Vec3> Player::source_positions() const {
    const std::lock_guard lock(state_->mutex);
    return state_->status.sources;
}

std::uint64_t Player::change(const Scene& scene, const SessionOptions& options, bool starts_anew) {
    SessionOptions kept = options;
    {
        const std::lock_guard lock(state_->mutex);
        const SessionOptions& now = state_->playing->options;
        kept.sample_rate_hz = now.sample_rate_hz;
        kept.block = now.block;
        kept.output = now.output;
        kept.device = now.device;
        if (starts_anew) state_->longest_response_s.reset();
        kept.longest_response_s = state_->longest_response_s;
    }
    return state_->changes->request(scene, std::move(kept), starts_anew);
}

void Player::play_signal(std::size_t source, std::shared_ptr<const Signal> signal) {
    SignalSet unused;  // destroyed after the lock: closing a microphone takes time
    const std::lock_guard lock(state_->mutex);
    PreparedScene& playing = *state_->playing;
    if (source >= playing.signals.size()) return;
    std::swap(playing.signals[source], signal);
    auto signals = playing.other_signals.reclaim();
    if (!signals) signals = std::make_unique<SignalSet>();
    unused = std::exchange(*signals, playing.signals);
    playing.other_signals.publish(std::move(signals));
}

void Player::watch(const std::optional<ViewRequest>& request) {
    const std::lock_guard lock(state_->mutex);
    state_->request = request;
}

std::shared_ptr<const FrameView> Player::view() const {
    const std::lock_guard lock(state_->mutex);
    return state_->view;
}

void Player::measure_loudness() { state_->monitor->start(); }

void Player::record(const std::filesystem::path& file) { state_->monitor->record(file); }

void Player::stop_recording() { state_->monitor->stop_recording(); }

MonitorStatus Player::monitor_status() { return state_->monitor->status(); }

PlayStatus Player::status() {
    PlayStatus status;
    double begin_s = 0;
    double end_s = 0;
    double frame_period_ms = 0;
    {
        const std::lock_guard lock(state_->mutex);
        status = state_->status;
        const AuralizerStatus frames = state_->frames_so_far();
        status.frames = frames.frames;
        status.late_frames = frames.late_frames;
        status.skipped_frames = frames.skipped_frames;
        status.frame_ms = frames.frame_ms;
        status.frame_mean_ms = frames.frame_mean_ms;
        status.frame_worst_ms = frames.frame_worst_ms;
        status.response_age_s = frames.frame_age_s;
        frame_period_ms = frames.frame_period_ms;
        // Includes the number of the audible change, which is set before the change counts as
        // begun.
        const ChangePreparer::Status changes = state_->changes->status();
        status.preparing = changes.preparing;
        status.failed_changes = changes.failed;
        status.change_error = changes.error;
        begin_s = state_->playing->zero_s;
        end_s = begin_s + state_->playing->timeline.end_s;
    }
    status.latency = state_->latency(frame_period_ms);
    status.time_s = std::min(state_->mixer->time_s(), end_s);
    status.scene_time_s = status.time_s - begin_s;
    const AudioDevice& device = *state_->device;
    status.load = device.meter().load();
    status.mean_load = device.meter().mean_load();
    status.worst_load = device.meter().worst_load();
    status.underruns = device.meter().underruns();
    status.rendering_underruns = device.meter().rendering_underruns();
    status.first_underruns = device.meter().first_underruns();
    status.realtime = device.meter().realtime();
    status.device = device.state();
    status.reconnects = device.reconnects();
    status.muted_samples = state_->mixer->muted_samples();
    status.peak = state_->mixer->take_peak();
    status.limiter_gain = state_->mixer->take_limiter_gain();
    status.finished = status.time_s >= end_s;
    if (!status.finished && status.device == DeviceState::unavailable)
        throw Failure("the output device \"" + device.info().name +
                      "\" or its server went away and did not come back within " +
                      std::to_string(std::lround(AudioDevice::kReconnectTimeout_s)) + " s");
    return status;
}

const DeviceInfo& Player::device() const { return state_->device->info(); }

double Player::sample_rate_hz() const { return state_->rate_hz; }

const std::vector<std::string>& Player::warnings() const { return state_->warnings; }

}  // namespace aula
