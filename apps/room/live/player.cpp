#include "apps/room/live/player.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/room/live/player_state.h"
#include "aula/exception.h"

namespace aula {

Player::Player(const Scene& scene, const PlaybackOptions& options)
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

std::uint64_t Player::change(const Scene& scene, const PlaybackOptions& options, bool starts_anew) {
    PlaybackOptions kept = options;
    {
        const std::lock_guard lock(state_->mutex);
        const PlaybackOptions& now = state_->playing->options;
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
    auto signals = playing.playback.signals().reclaim();
    if (!signals) signals = std::make_unique<SignalSet>();
    unused = std::exchange(*signals, playing.signals);
    playing.playback.signals().publish(std::move(signals));
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
    double end_s = 0;
    {
        const std::lock_guard lock(state_->mutex);
        status = state_->status_so_far();
        // Includes the number of the audible change, which is set before the change counts as
        // begun.
        const ChangePreparer::Status changes = state_->changes->status();
        status.preparing = changes.preparing;
        status.failed_changes = changes.failed;
        status.change_error = changes.error;
        const double begin_s = state_->playing->zero_s;
        end_s = begin_s + state_->playing->timeline.end_s;
        LiveMixer& mixer = *state_->mixer;
        status.time_s = std::min(mixer.time_s(), end_s);
        status.scene_time_s = status.time_s - begin_s;
        status.sample_rate_hz = state_->rate_hz;
        status.latency = state_->latency(status.frame_period_ms);
        status.peak = mixer.take_peak();
        status.limiter_gain = mixer.take_limiter_gain();
    }
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
    status.finished = status.time_s >= end_s;
    if (!status.finished && status.device == DeviceState::unavailable) {
        const std::string problem = device.problem();
        if (!problem.empty())
            throw Failure("the output device is back, but cannot play: " + problem);
        throw Failure("the output device \"" + device.info().name +
                      "\" or its server went away and did not come back within " +
                      std::to_string(std::lround(AudioDevice::kReconnectTimeout_s)) + " s");
    }
    return status;
}

const DeviceInfo& Player::device() const { return state_->device->info(); }

double Player::sample_rate_hz() const {
    const std::lock_guard lock(state_->mutex);
    return state_->rate_hz;
}

const std::vector<std::string>& Player::warnings() const { return state_->warnings; }

}  // namespace aula
