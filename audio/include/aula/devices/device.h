#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "aula/devices/output_meter.h"
#include "aula/exception.h"

namespace aula {

/// There is no output device.
class NoAudioDevice : public Failure {
 public:
    using Failure::Failure;
};

/// A device does not support the requested sample rate.
class SampleRateRefused : public Failure {
 public:
    SampleRateRefused(const std::string& message, double device_rate_hz)
        : Failure(message), device_rate_hz_(device_rate_hz) {}

    double device_rate_hz() const { return device_rate_hz_; }

 private:
    double device_rate_hz_;
};

/// An output device.
struct DeviceInfo {
    int index = 0;              ///< in the list of output devices
    std::string name;           ///< of the JACK client, or PortAudio's name
    std::string host_api;       ///< "JACK", "ALSA", ..
    int output_channels = 0;    ///< largest number
    double sample_rate_hz = 0;  ///< of the JACK server, or preferred by the device; 0: any
    double latency_s = 0;       ///< from the end of a callback to the sound; 0: unknown
    bool is_default = false;
};

/// Output devices: those of JACK if a server is running, then those of PortAudio. Messages of the
/// libraries are suppressed. Empty if there is neither server nor sound card.
std::vector<DeviceInfo> list_output_devices();

/// Fills outputs[channel][sample] with `samples` samples each. Runs on the device's thread with
/// denormals flushed. Must not allocate, lock or wait.
using AudioCallback = std::function<void(std::span<float* const> outputs, int samples)>;

/// State of an audio device.
enum class DeviceState {
    playing,
    lost,  ///< server or card disappeared; silent until it is available again
    gone   ///< stopped, or not available again within kPatience_s
};

/// An output device that requests samples by a callback. A lost device is reopened every second for
/// kPatience_s; after a reconnection the signal fades in. The constructor throws InputError if
/// `wanted` matches no or several devices (the message lists the candidates), SampleRateRefused if
/// the device has another sample rate, Failure if there is no device or it cannot be opened.
class AudioDevice {
 public:
    static constexpr double kPatience_s = 30;

    /// Name of a device that is always available: it requests samples in real time and discards
    /// them.
    static constexpr const char* kNone = "none";

    /// `wanted`: an index, a part of a name, kNone, or empty for the default device.
    AudioDevice(const std::string& wanted, double sample_rate_hz, std::size_t channels, int block,
                AudioCallback callback);
    ~AudioDevice();
    AudioDevice(const AudioDevice&) = delete;
    AudioDevice& operator=(const AudioDevice&) = delete;

    /// Starts the callbacks. Throws Failure.
    void start();

    /// Ends the callbacks. None runs after it returns.
    void stop();

    /// The selected device; its latency is measured by start().
    const DeviceInfo& info() const;
    DeviceState state() const;  ///< [any thread]
    bool active() const { return state() == DeviceState::playing; }
    std::uint64_t reconnects() const;  ///< number of reconnections [any thread]

    /// Underruns and load since start.
    const OutputMeter& meter() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
