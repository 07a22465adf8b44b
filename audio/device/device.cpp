#include "aula/devices/device.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "audio/device/output.h"
#include "audio/dsp/fade.h"
#include "aula/exception.h"

namespace aula {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kWatchInterval{100};
constexpr std::chrono::seconds kRetryInterval{1};

/// Fade-in of the signal after a reconnection.
constexpr double kRise_s = 0.02;

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::string listed(const std::vector<DeviceInfo>& devices) {
    std::string text;
    for (const DeviceInfo& device : devices) {
        if (!text.empty()) text += ", ";
        text += std::to_string(device.index) + " \"" + device.name + "\" (" + device.host_api + ")";
    }
    return text;
}

DeviceInfo choose(const std::vector<DeviceInfo>& devices, const std::string& wanted) {
    if (wanted == AudioDevice::kNone) return silent_output();
    if (devices.empty()) throw NoAudioDevice("no audio output device (no sound server or card)");
    if (wanted.empty()) {
        const auto found = std::find_if(devices.begin(), devices.end(),
                                        [](const DeviceInfo& d) { return d.is_default; });
        return found == devices.end() ? devices.front() : *found;
    }
    std::vector<DeviceInfo> matches;
    for (const DeviceInfo& device : devices) {
        if (wanted == std::to_string(device.index)) return device;
    }
    // A complete name takes precedence over parts of names.
    for (const bool whole : {true, false}) {
        for (const DeviceInfo& device : devices) {
            const std::string name = lower(device.name);
            const bool match =
                whole ? name == lower(wanted) : name.find(lower(wanted)) != std::string::npos;
            if (match) matches.push_back(device);
        }
        if (!matches.empty()) break;
    }
    if (matches.empty()) {
        throw InputError("audio device \"" + wanted +
                         "\": no such output; expected the index or a part of the name of " +
                         listed(devices));
    }
    if (matches.size() > 1) {
        throw InputError("audio device \"" + wanted +
                         "\": matches several outputs; expected one of " + listed(matches));
    }
    return matches.front();
}

std::string hertz(double rate_hz) { return std::to_string(std::lround(rate_hz)) + " Hz"; }

}  // namespace

void refuse_rate(const DeviceInfo& device, double wanted_hz, double device_hz) {
    throw SampleRateRefused("audio device \"" + device.name + "\": plays at " + hertz(device_hz) +
                                ", not at " + hertz(wanted_hz),
                            device_hz);
}

std::vector<DeviceInfo> list_output_devices() {
    std::vector<DeviceInfo> devices = list_jack_outputs();
    const bool jack = std::any_of(devices.begin(), devices.end(),
                                  [](const DeviceInfo& d) { return d.is_default; });
    for (DeviceInfo& device : list_port_audio_outputs()) {
        device.is_default = device.is_default && !jack;
        devices.push_back(std::move(device));
    }
    int index = 0;
    for (DeviceInfo& device : devices) device.index = index++;
    // The first default is the only one.
    bool found = false;
    for (DeviceInfo& device : devices) {
        device.is_default = device.is_default && !std::exchange(found, found || device.is_default);
    }
    return devices;
}

struct AudioDevice::State {
    explicit State(const OutputSettings& wanted)
        : settings(wanted),
          meter(settings.sample_rate_hz),
          rise(static_cast<std::size_t>(std::lround(kRise_s * settings.sample_rate_hz))) {
        settings.meter = &meter;
        settings.callback = [this, fill = wanted.callback](std::span<float* const> outputs,
                                                           int samples) {
            fill(outputs, samples);
            if (rise.done()) return;
            const auto count = static_cast<std::size_t>(samples);
            for (float* channel : outputs) rise.fade_in({channel, count});
            rise.advance(count);
        };
    }

    OutputSettings settings;
    OutputMeter meter;
    Fade rise;  ///< used by the output's thread while there is one
    DeviceInfo info;
    std::unique_ptr<Output> output;  ///< null while lost; used by the watcher once started
    std::atomic<DeviceState> state{DeviceState::playing};
    std::atomic<std::uint64_t> reconnects{0};

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

    /// Tries once to reopen the same device. Only its sound system is queried.
    bool reopen() {
        try {
            const std::vector<DeviceInfo> devices =
                info.host_api == "JACK" ? list_jack_outputs() : list_port_audio_outputs();
            const auto same = std::find_if(devices.begin(), devices.end(), [&](const auto& d) {
                return d.name == info.name && d.host_api == info.host_api;
            });
            if (same == devices.end()) return false;
            meter.restart();
            rise.start();
            output = open(*same);
            output->start();
            return true;
        } catch (const std::exception&) {
            output.reset();
            return false;
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
            const Clock::time_point lost = Clock::now();
            output.reset();
            do {
                if (std::chrono::duration<double>(Clock::now() - lost).count() >
                    kReconnectTimeout_s) {
                    state = DeviceState::unavailable;
                    return;
                }
                if (stopped_after(kRetryInterval)) return;
            } while (!reopen());
            ++reconnects;
            state = DeviceState::playing;
        }
    }
};

AudioDevice::AudioDevice(const std::string& wanted, double sample_rate_hz, std::size_t channels,
                         int block, AudioCallback callback)
    : state_(std::make_unique<State>(
          OutputSettings{sample_rate_hz, channels, block, std::move(callback), nullptr})) {
    State& s = *state_;
    s.info = wanted == kNone ? silent_output() : choose(list_output_devices(), wanted);
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

std::uint64_t AudioDevice::reconnects() const { return state_->reconnects; }

const OutputMeter& AudioDevice::meter() const { return state_->meter; }

}  // namespace aula
