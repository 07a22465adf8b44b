#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "audio/output_meter.h"

namespace aula {

struct DeviceInfo {
    int index = 0;
    std::string name;
    std::string host_api;
    int output_channels = 0;
    double sample_rate_hz = 0;
    double latency_s = 0;
    bool is_default = false;
};

/// Output devices: JACK's where a server runs, then what PortAudio knows; the libraries' own
/// messages are silenced. Empty where there is neither server nor card.
std::vector<DeviceInfo> list_output_devices();

/// Fills planar outputs of `samples` each, at most a block. Runs on the device's thread with
/// denormals flushed. Must not allocate, lock or wait.
using AudioCallback = std::function<void(std::span<float* const> outputs, int samples)>;

/// How an audio device fares.
enum class DeviceState {
    playing,
    lost,  ///< its server or card went away; silence until it is back
    gone   ///< it did not come back in time
};

/// An output device that calls back for sound. When it or its server vanishes it is tried again
/// each second for kPatience_s. Throws AudioInputError if `wanted` matches no or several devices
/// (the message lists the candidates), SampleRateRefused if the device plays at another rate,
/// AudioFailure if there is no device or it cannot be opened.
class AudioDevice {
 public:
    static constexpr double kPatience_s = 30;

    /// The name of a device that is always there: it asks for sound in real time and throws it
    /// away.
    static constexpr const char* kNone = "none";

    /// `wanted`: an index, a part of a name, kNone, or empty for the default device.
    AudioDevice(const std::string& wanted, double sample_rate_hz, std::size_t channels, int block,
                AudioCallback callback);
    ~AudioDevice();
    AudioDevice(const AudioDevice&) = delete;
    AudioDevice& operator=(const AudioDevice&) = delete;

    void start();
    void stop();

    const DeviceInfo& info() const;
    DeviceState state() const;
    bool active() const { return state() == DeviceState::playing; }
    std::uint64_t reconnects() const;  ///< how often it came back

    /// Underruns and load since start.
    const OutputMeter& meter() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
