#include "aula/devices/device.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "audio/device/device_list.h"
#include "audio/device/output.h"
#include "audio/dsp/fade.h"
#include "aula/exception.h"

namespace aula {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kWatchInterval{100};
constexpr std::chrono::seconds kRetryInterval{1};

/// Fade-in of the signal after a reconnection.
constexpr double kOnsetFade_s = 0.02;

/// A fade at its end.
Fade onset_fade_at(double rate_hz) {
    return Fade(static_cast<std::size_t>(std::lround(kOnsetFade_s * rate_hz)));
}

std::string hertz(double rate_hz) { return std::to_string(std::lround(rate_hz)) + " Hz"; }

}  // namespace

void refuse_rate(const DeviceInfo& device, double wanted_hz, double device_hz) {
    throw SampleRateRefused("audio device \"" + device.name + "\": plays at " + hertz(device_hz) +
                                ", not at " + hertz(wanted_hz),
                            device_hz);
}

std::vector<DeviceInfo> list_output_devices() {
    return merge_outputs(list_jack_outputs(), list_port_audio_outputs());
}

struct AudioDevice::State {
    State(const OutputSettings& wanted, RateCallback prepares_rate)
        : settings(wanted),
          rate_callback(std::move(prepares_rate)),
          meter(settings.sample_rate_hz),
          onset_fade(onset_fade_at(settings.sample_rate_hz)) {
        settings.meter = &meter;
        settings.callback = [this, fill = wanted.callback](std::span<float* const> outputs,
                                                           int samples) {
            fill(outputs, samples);
            if (!onset_fade.done())
                onset_fade.fade_in_next(outputs, static_cast<std::size_t>(samples));
        };
    }

    OutputSettings settings;
    RateCallback rate_callback;  ///< may be empty
    OutputMeter meter;
    Fade onset_fade;  ///< used by the output's thread while there is one
    DeviceInfo info;
    std::unique_ptr<Output> output;  ///< null while lost; used by the watcher once started
    std::atomic<DeviceState> state{DeviceState::playing};
    std::atomic<std::uint64_t> reconnects{0};

    mutable std::mutex problem_mutex;  ///< protects `problem`
    std::string problem;

    std::mutex mutex;  ///< protects `stop`
    std::condition_variable stopping;
    bool stop = false;
    std::thread watcher;

    std::unique_ptr<Output> open(const DeviceInfo& device) const {
        if (static_cast<std::size_t>(device.output_channels) < settings.channels) {
            throw Failure("audio device \"" + device.name + "\": has " +
                          std::to_string(device.output_channels) + " output channels; needed " +
                          std::to_string(settings.channels));
        }
        if (device.name == AudioDevice::kNone) return open_silent_output(settings);
        return device.host_api == "JACK" ? open_jack_output(device, settings)
                                         : open_port_audio_output(device, settings);
    }

    void set_problem(const std::string& text) {
        const std::lock_guard lock(problem_mutex);
        problem = text;
    }

    enum class Attempt {
        opened,
        failed,
        preparing,  ///< the samples of another rate are being prepared
    };

    bool is_prepared(double rate_hz) const { return !rate_callback || rate_callback(rate_hz); }

    /// Opens and starts the same device at the present rate. Only its sound system is queried.
    Attempt open_same() {
        const std::vector<DeviceInfo> devices =
            info.host_api == "JACK" ? list_jack_outputs() : list_port_audio_outputs();
        const auto same = std::find_if(devices.begin(), devices.end(), [&](const auto& d) {
            return d.name == info.name && d.host_api == info.host_api;
        });
        if (same == devices.end()) return Attempt::failed;
        meter.restart(settings.sample_rate_hz);
        onset_fade.start();
        output = open(*same);
        // Another rate may have been prepared since, for a device that has gone again.
        if (!is_prepared(settings.sample_rate_hz)) {
            output.reset();
            return Attempt::preparing;
        }
        output->start();
        return Attempt::opened;
    }

    /// Tries once to reopen the device, at another sample rate if it has one now.
    Attempt reopen() {
        try {
            try {
                return open_same();
            } catch (const SampleRateRefused& refused) {
                const double rate_hz = refused.device_rate_hz();
                if (!rate_callback || rate_hz == settings.sample_rate_hz) throw;
                if (!is_prepared(rate_hz)) return Attempt::preparing;
                settings.sample_rate_hz = rate_hz;
                onset_fade = onset_fade_at(rate_hz);
                return open_same();
            }
        } catch (const std::exception& error) {
            output.reset();
            set_problem(error.what());
            return Attempt::failed;
        }
    }

    /// Monitors the device until it is stopped or unavailable. [watcher thread]
    void watch() {
        std::unique_lock lock(mutex);
        const auto stopped_after = [&](auto time) {
            return stopping.wait_for(lock, time, [&] { return stop; });
        };
        for (;;) {
            if (stopped_after(kWatchInterval)) return;
            if (output->alive()) continue;
            state = DeviceState::lost;
            Clock::time_point lost = Clock::now();
            Clock::time_point tried = lost;
            output.reset();
            for (Attempt attempt = Attempt::failed; attempt != Attempt::opened;) {
                const Clock::time_point now = Clock::now();
                // The time of preparation is added to the timeout.
                if (attempt == Attempt::preparing) lost += now - tried;
                tried = now;
                if (std::chrono::duration<double>(now - lost).count() > kReconnectTimeout_s) {
                    state = DeviceState::unavailable;
                    return;
                }
                if (stopped_after(kRetryInterval)) return;
                set_problem("");
                attempt = reopen();
            }
            ++reconnects;
            state = DeviceState::playing;
        }
    }
};

AudioDevice::AudioDevice(const std::string& wanted, double sample_rate_hz, std::size_t channels,
                         int block, AudioCallback callback, RateCallback rate_callback)
    : state_(std::make_unique<State>(
          OutputSettings{sample_rate_hz, channels, block, std::move(callback), nullptr},
          std::move(rate_callback))) {
    State& s = *state_;
    s.info = wanted == kNone ? silent_output() : choose_output(list_output_devices(), wanted);
    s.output = s.open(s.info);
}

AudioDevice::~AudioDevice() { stop(); }

void AudioDevice::start() {
    State& s = *state_;
    if (s.watcher.joinable() || !s.output) return;
    s.output->start();
    if (const double latency_s = s.output->latency_s(); latency_s > 0) {
        s.info.latency_s = latency_s;
    }
    s.watcher = std::thread([&s] { s.watch(); });
}

void AudioDevice::stop() {
    State& s = *state_;
    if (!s.watcher.joinable()) return;
    {
        const std::lock_guard lock(s.mutex);
        s.stop = true;
    }
    s.stopping.notify_all();
    s.watcher.join();
    s.output.reset();
    s.state = DeviceState::unavailable;
}

const DeviceInfo& AudioDevice::info() const { return state_->info; }

DeviceState AudioDevice::state() const { return state_->state; }

std::string AudioDevice::problem() const {
    const std::lock_guard lock(state_->problem_mutex);
    return state_->problem;
}

std::uint64_t AudioDevice::reconnects() const { return state_->reconnects; }

const OutputMeter& AudioDevice::meter() const { return state_->meter; }

}  // namespace aula
