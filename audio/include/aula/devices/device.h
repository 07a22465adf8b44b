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

/// There is no output device: neither a sound server nor a sound card that ALSA is configured for.
class NoAudioDevice : public Failure {
 public:
    /// The error, with its message.
    NoAudioDevice()
        : Failure(
              "no audio output device (no sound server, no card, or none in ALSA's "
              "configuration)") {}
};

/// A device does not support the requested sample rate. Try again with device_rate_hz().
class SampleRateRefused : public Failure {
 public:
    /// An error with that message, and the rate that the device supports.
    SampleRateRefused(const std::string& message, double device_rate_hz)
        : Failure(message), device_rate_hz_(device_rate_hz) {}

    /// The sample rate of the device.
    double device_rate_hz() const { return device_rate_hz_; }

 private:
    double device_rate_hz_;
};

/// An output device.
struct DeviceInfo {
    int index = 0;              ///< place in the result of list_output_devices(), from 0
    std::string name;           ///< name of the JACK client, or PortAudio's name of the device
    std::string host_api;       ///< sound system: "JACK", "ALSA", ...
    int output_channels = 0;    ///< largest number of channels
    double sample_rate_hz = 0;  ///< rate of the JACK server, or preferred by the device; 0: any
    double latency_s = 0;       ///< from the end of a callback to the sound; 0: unknown
    bool is_default = false;    ///< true for the device that an empty name selects
};

/// All output devices: those of JACK if a server is running, then those of PortAudio. Empty if
/// there is neither server nor sound card, or no configuration of ALSA that names the card.
/// Messages of the libraries are suppressed.
std::vector<DeviceInfo> list_output_devices();

/// A function that overwrites outputs[channel][sample] with `samples` samples for each channel; the
/// number differs between calls on some sound systems. It runs on the device's thread with
/// denormals flushed and must not allocate, lock or wait.
using AudioCallback = std::function<void(std::span<float* const> outputs, int samples)>;

/// A function that a lost device calls before it plays again, with its sample rate, which may be
/// another one. It returns true if the next call of the AudioCallback gives samples of that rate,
/// and false while they are being prepared: it is then called again later. It throws if there can
/// be none. After it has returned false the AudioCallback is not called before it returns true.
using RateCallback = std::function<bool(double sample_rate_hz)>;

/// State of an audio device.
enum class DeviceState {
    playing,     ///< also before start()
    lost,        ///< server or card disappeared; silent until it is available again
    unavailable  ///< stopped, or not available again within AudioDevice::kReconnectTimeout_s
};

/// An output device that requests samples by a callback. A lost device is reopened: an attempt is
/// made every second for kReconnectTimeout_s, to which the time is added for which a RateCallback
/// returns false. After a reconnection the signal fades in.
class AudioDevice {
 public:
    /// Time for which attempts are made to reopen a lost device.
    static constexpr double kReconnectTimeout_s = 30;

    /// Name of a device that is always available: it requests samples in real time and discards
    /// them.
    static constexpr const char* kNone = "none";

    /// Opens a device without starting it. `wanted` is an index, a name or a part of one (case is
    /// ignored), kNone, or empty for the default device. `block` is the preferred number of samples
    /// per callback; a JACK server determines its own. Without `rate_callback` a device that
    /// returns from a loss with another sample rate stays lost.
    ///
    /// Throws InputError if `wanted` matches no or several devices (the message lists the
    /// candidates), NoAudioDevice if there is none, SampleRateRefused if the device has another
    /// sample rate, and Failure if it has fewer channels or cannot be opened.
    AudioDevice(const std::string& wanted, double sample_rate_hz, std::size_t channels, int block,
                AudioCallback callback, RateCallback rate_callback = {});
    /// Calls stop().
    ~AudioDevice();
    AudioDevice(const AudioDevice&) = delete;
    AudioDevice& operator=(const AudioDevice&) = delete;

    /// Starts the callbacks. Does nothing after the first call. Throws Failure.
    void start();

    /// Ends the callbacks; none runs after it returns. The device cannot be started again.
    void stop();

    /// The selected device, as it was when it was opened. Its latency is measured by start().
    const DeviceInfo& info() const;

    /// Whether the device plays, is lost or is unavailable. [any thread]
    DeviceState state() const;
    /// True if the state is DeviceState::playing. [any thread]
    bool active() const { return state() == DeviceState::playing; }
    /// Why a device that is lost or unavailable, but has been found again, could not be reopened;
    /// empty otherwise. [any thread]
    std::string problem() const;
    /// Number of reconnections after losses. [any thread]
    std::uint64_t reconnects() const;

    /// Underruns and load since start(). [any thread]
    const OutputMeter& meter() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
