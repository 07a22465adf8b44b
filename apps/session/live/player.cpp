#include "apps/session/live/player.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <future>
#include <mutex>
#include <optional>
#include <thread>

#include "apps/session/auralizer/frame_clock.h"
#include "apps/session/live/change_preparer.h"
#include "apps/session/live/live_load.h"
#include "apps/session/live/live_mixer.h"
#include "apps/session/live/prepared_scene.h"
#include "aula/audio/realtime.h"
#include "aula/exception.h"

namespace aula {

struct Player::State {
    using Clock = FrameClock::Clock;

    State(const Scene& scene, const SessionOptions& options);
    ~State();

    void build(const Scene& scene, const SessionOptions& options);
    void open_device(const SessionOptions& options);

    void fade_out();
    void propagate();
    PoseLatency latency(double frame_s) const;
    static std::int64_t to_ns(Clock::time_point time) { return time.time_since_epoch().count(); }
    void turn_head(const Pose& pose, std::int64_t given_ns);
    void place_listener(const Pose& pose, std::int64_t given_ns);
    void take_controls(PlayControls next, std::int64_t given_ns);
    void compute();
    bool rays_fall(const PlayControls& with) const;
    LiveLoad load_of(const PreparedScene& prepared) const;
    void keep_up(double took_s);
    void publish();
    void begin_prepared();
    void show(double spare_s);
    ChangePreparer::Playing what_plays();
    double scene_time_s() const { return clock.time_s() - playing->zero_s; }

    double rate_hz = 0;
    std::vector<std::string> warnings;
    std::unique_ptr<LiveMixer> mixer;
    std::unique_ptr<Monitor> monitor;

    // Of the propagation thread.
    Clock::time_point shown;  ///< when the last view was made
    FrameClock clock{Clock::now()};
    std::unique_ptr<RenderFrame> computed;  ///< waits for its time to be published
    Pose computed_pose;
    std::int64_t pose_ns = 0;  ///< when the pose of the frame in hand was given
    LatencyCounts compute_time;
    std::optional<LiveLoad> load;      ///< of what plays
    std::uint64_t shorter_change = 0;  ///< the number of the last change that shortens responses

    std::mutex mutex;  ///< of what follows
    std::condition_variable stopping;
    bool stop = false;
    std::unique_ptr<PreparedScene> playing;  ///< exchanged and used by the propagation thread
    PlayControls controls;
    PlayStatus status;
    std::optional<ViewRequest> request;
    std::shared_ptr<const FrameView> view;
    Clock::time_point published = Clock::now();
    double frame_sum_ms = 0;
    std::optional<double> longest_response_s;  ///< with which it keeps up; empty: any
    std::optional<std::int64_t> unheard_ns;    ///< when the first pose came that no frame knows yet
    std::exception_ptr failure;

    std::unique_ptr<AudioDevice> device;  ///< ends before the mixer that it calls
    std::unique_ptr<ChangePreparer> changes;
    std::thread thread;
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
    compute();
    pose_ns = 0;  // it waits for the device to be started
    publish();
    mixer->playbacks().publish(std::move(playing->playback));
    device->start();
    changes = std::make_unique<ChangePreparer>(rate_hz, [this] { return what_plays(); });
    thread = std::thread([this] {
        lower_priority(kPropagationNice);
        try {
            propagate();
        } catch (...) {
            const std::lock_guard lock(mutex);
            failure = std::current_exception();
        }
    });
}

Player::State::~State() {
    {
        const std::lock_guard lock(mutex);
        stop = true;
    }
    stopping.notify_all();
    // The sound and its recording end first: a frame that is being computed may take long.
    fade_out();
    device->stop();
    monitor.reset();
    thread.join();
    changes.reset();
}

/// Waits until a last fade is played, if anything plays.
void Player::State::fade_out() {
    constexpr int kMaxTurns = 50;
    constexpr std::chrono::milliseconds kTurn{5};
    mixer->pause(true);
    for (int turn = 0; turn < kMaxTurns && device->active() && !mixer->silent(); ++turn)
        std::this_thread::sleep_for(kTurn);
}

/// Everything but the device: what is wrong with the input is said before a device is opened.
void Player::State::build(const Scene& scene, const SessionOptions& options) {
    // The threads that trace its paths have the priority of the thread that begins them.
    playing = std::async(std::launch::async, [&] {
                  lower_priority(kPropagationNice);
                  return std::make_unique<PreparedScene>(scene, options, rate_hz, false);
              }).get();
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

/// Wakes at each frame time: publishes the frame computed since the one before, begins a change
/// that is prepared, then computes the next frame for the newest poses. [propagation thread]
void Player::State::propagate() {
    const auto wait_until = [this](Clock::time_point time) {
        std::unique_lock lock(mutex);
        return !stopping.wait_until(lock, time, [this] { return stop; });
    };
    clock = FrameClock(Clock::now());
    for (;;) {
        clock.next(playing->maker.config().frame_s);
        if (!wait_until(clock.due())) return;
        publish();
        if (const std::uint64_t missed = clock.skip_missed(Clock::now()); missed > 0) {
            const std::lock_guard lock(mutex);
            status.late_frames += missed;
        }
        begin_prepared();
        if (!wait_until(clock.begin())) return;
        compute();
        keep_up(status.frame_ms / 1000);
        show(std::chrono::duration<double>(clock.end() - Clock::now()).count());
        clock.follow(mixer->time_s(), Clock::now());
    }
}

PoseLatency Player::State::latency(double frame_s) const {
    const LatencyCounts& frames = mixer->frame_latency();
    const LatencyCounts& heads = mixer->head_latency();
    return {.frame_period_ms = 1000 * frame_s,
            .compute_p50_ms = compute_time.quantile_ms(0.5),
            .compute_p99_ms = compute_time.quantile_ms(0.99),
            .sound_p50_ms = frames.quantile_ms(0.5),
            .sound_p99_ms = frames.quantile_ms(0.99),
            .head_p50_ms = heads.quantile_ms(0.5),
            .head_p99_ms = heads.quantile_ms(0.99),
            .call_p99_ms = mixer->call_interval().quantile_ms(0.99)};
}

void Player::State::compute() {
    const Clock::time_point begin = Clock::now();
    PlayControls with;
    {
        const std::lock_guard lock(mutex);
        with = controls;
        // A path's pose is that of the frame's time; one by hand has been waiting since it came,
        // if there is a new one: 0 is not counted.
        pose_ns = with.listener ? unheard_ns.value_or(0) : to_ns(clock.due());
        unheard_ns.reset();
    }
    const bool falls = rays_fall(with);
    if (falls) with.rays = load->rays();
    const double at_s = scene_time_s();
    computed_pose = with.listener_at(playing->scene, at_s);
    computed = playing->frames.reclaim();
    if (!computed) computed = playing->maker.make_frame();
    playing->maker.fill(with.applied_to(playing->scene, at_s), {&computed, 1});

    const double took_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    clock.took(took_ms / 1000);
    compute_time.add(static_cast<std::int64_t>(1e6 * took_ms));
    const std::lock_guard lock(mutex);
    frame_sum_ms += took_ms;
    ++status.frames;
    status.frame_ms = took_ms;
    status.frame_mean_ms = frame_sum_ms / static_cast<double>(status.frames);
    status.frame_worst_ms = std::max(status.frame_worst_ms, took_ms);
    status.frame = playing->maker.statistics();
    status.sources = playing->maker.source_positions();
    status.rays = playing->maker.rays();
    status.full_rays = falls ? load->full().rays : status.rays;
    status.response_length_s = playing->maker.response_length_s();
    status.full_response_length_s = load->full().length_s;
}

/// Whether the number of rays is left to the player.
bool Player::State::rays_fall(const PlayControls& with) const {
    return playing->options.rays_fall && !with.rays && !with.frame_share;
}

/// As much of what a prepared scene would have as the one before kept up with.
LiveLoad Player::State::load_of(const PreparedScene& prepared) const {
    LiveLoad::Full full{.rays = prepared.scene.simulation.rays,
                        .length_s = prepared.maker.response_length_s(),
                        .rays_fall = prepared.options.rays_fall,
                        .length_falls = !prepared.length_given};
    const bool shortened = full.length_falls && prepared.options.longest_response_s;
    const double length_s = full.length_s;
    if (shortened && load) full.length_s = load->full().length_s;
    const bool goes_on = load && !prepared.starts_anew && full.rays_fall;
    return {full, goes_on ? std::min(load->rays(), full.rays) : full.rays, length_s};
}

/// Lowers what plays if its frames take too long. A shorter response is a change that is prepared.
void Player::State::keep_up(double took_s) {
    PlayControls with;
    {
        const std::lock_guard lock(mutex);
        with = controls;
    }
    // What is prepared slows down what plays.
    if (changes->status().preparing) return load->restart();
    load->add(took_s, playing->maker.config().frame_s, rays_fall(with));
    if (load->length_s() >= playing->maker.response_length_s() || shorter_change > 0) return;
    Scene scene = playing->scene;
    scene.simulation.ir_length_s.reset();
    SessionOptions options = playing->options;
    options.longest_response_s = load->length_s();
    const std::lock_guard lock(mutex);
    shorter_change = changes->ask_if_idle(scene, options);
    if (shorter_change > 0) longest_response_s = options.longest_response_s;
}

void Player::State::publish() {
    if (!computed) return;
    computed->stamp = pose_ns;
    playing->frames.publish(std::move(computed));
    const std::lock_guard lock(mutex);
    // A head moved by hand has gone ahead.
    if (!controls.listener) turn_head(computed_pose, clock_ns());
    status.listener = computed_pose;
    published = Clock::now();
}

/// The mutex is held: the mailbox has one writer at a time.
void Player::State::turn_head(const Pose& pose, std::int64_t given_ns) {
    auto head = mixer->head_poses().reclaim();
    if (!head) head = std::make_unique<HeadPose>();
    *head = {pose, given_ns};
    mixer->head_poses().publish(std::move(head));
}

/// By hand. The mutex is held.
void Player::State::place_listener(const Pose& pose, std::int64_t given_ns) {
    controls.listener = pose;
    if (!unheard_ns) unheard_ns = given_ns;
    turn_head(pose, given_ns);
}

/// The mutex is held.
void Player::State::take_controls(PlayControls next, std::int64_t given_ns) {
    const bool placed =
        next.listener && !(controls.listener && same_pose(*controls.listener, *next.listener));
    controls = std::move(next);
    if (placed) place_listener(*controls.listener, given_ns);
}

/// Copies what is to be looked at, if there is time until the next frame, or was none for long.
void Player::State::show(double spare_s) {
    constexpr double kEnough_s = 0.004;
    constexpr std::chrono::milliseconds kLong{250};
    std::optional<ViewRequest> wanted_view;
    std::uint64_t frame = 0;
    std::uint64_t change_heard = 0;
    {
        const std::lock_guard lock(mutex);
        wanted_view = request;
        frame = status.frames;
        change_heard = status.heard_change;
    }
    if (!wanted_view || (spare_s < kEnough_s && Clock::now() < shown + kLong)) return;
    auto made = std::make_shared<FrameView>(playing->maker.view(*wanted_view));
    made->frame = frame;
    made->change = change_heard;
    shown = Clock::now();
    std::shared_ptr<const FrameView> replaced = std::move(made);
    const std::lock_guard lock(mutex);
    std::swap(view, replaced);
}

/// Goes over to what has been prepared, if there is something: its first frame is computed at once
/// and goes to the mixer with its playback.
void Player::State::begin_prepared() {
    while (auto playback = mixer->playbacks().reclaim()) changes->retire(std::move(playback));
    std::unique_ptr<PreparedScene> before;
    {
        const std::lock_guard lock(mutex);
        auto [prepared, number] = changes->take();
        if (!prepared) return;
        if (!prepared->starts_anew) prepared->take_signals(*playing);
        prepared->zero_s = prepared->starts_anew ? clock.time_s() : playing->zero_s;
        if (prepared->starts_anew) controls = {};
        load = load_of(*prepared);
        shorter_change = 0;
        before = std::exchange(playing, std::move(prepared));
        status.heard_change = number;
    }
    changes->retire(std::move(before));
    compute();
    publish();
    mixer->playbacks().publish(std::move(playing->playback));
}

ChangePreparer::Playing Player::State::what_plays() {
    const std::lock_guard lock(mutex);
    PlayControls with = controls;
    if (rays_fall(with)) with.rays = status.rays;
    return {playing->reusable(), with, mixer->time_s() - playing->zero_s};
}

Player::Player(const Scene& scene, const SessionOptions& options)
    : state_(std::make_unique<State>(scene, options)) {}

Player::~Player() = default;

void Player::move_listener(const Pose& pose) {
    const std::int64_t given_ns = clock_ns();
    const std::lock_guard lock(state_->mutex);
    if (!state_->playing->scene.listener.path) state_->place_listener(pose, given_ns);
}

void Player::control(const PlayControls& controls) {
    const std::int64_t given_ns = clock_ns();
    const std::lock_guard lock(state_->mutex);
    state_->take_controls(controls, given_ns);
}

PlayControls Player::controls() const {
    const std::lock_guard lock(state_->mutex);
    return state_->controls;
}

void Player::adjust(const std::function<void(PlayControls&, const Pose&)>& change) {
    const std::int64_t given_ns = clock_ns();
    const std::lock_guard lock(state_->mutex);
    PlayControls next = state_->controls;
    change(next, state_->status.listener);
    state_->take_controls(std::move(next), given_ns);
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
    return state_->changes->ask(scene, kept, starts_anew);
}

void Player::play_signal(std::size_t source, std::shared_ptr<const Signal> signal) {
    SignalSet unused;  // ends after the lock: a microphone takes a while to be closed
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
    double frame_s = 0;
    {
        const std::lock_guard lock(state_->mutex);
        if (state_->failure) std::rethrow_exception(state_->failure);
        status = state_->status;
        // With the number of the change that is heard, which is noted when it is taken.
        const ChangePreparer::Status changes = state_->changes->status();
        status.preparing = changes.preparing;
        status.failed_changes = changes.failed;
        status.change_error = changes.error;
        frame_s = state_->playing->maker.config().frame_s;
        status.response_age_s =
            std::chrono::duration<double>(State::Clock::now() - state_->published).count();
        begin_s = state_->playing->zero_s;
        end_s = begin_s + state_->playing->timeline.end_s;
    }
    status.latency = state_->latency(frame_s);
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
