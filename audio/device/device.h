#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "audio/device/output_meter.h"

namespace aula {

/// An output device as it was found.
struct DeviceInfo {
    int index = 0;              ///< in the list that it was found in
    std::string name;           ///< of a JACK client, or as PortAudio calls it
    std::string host_api;       ///< "JACK", "ALSA", ..
    int output_channels = 0;    ///< the most it takes
    double sample_rate_hz = 0;  ///< that JACK's server runs at, or the device prefers; 0: any
    double latency_s = 0;       ///< from the end of a call for sound to the sound; 0: not known
    bool is_default = false;
};

/// Output devices: JACK's where a server runs, then what PortAudio knows; the libraries' own
/// messages are silenced. Empty where there is neither server nor card.
std::vector<DeviceInfo> list_output_devices();

/// Fills planar outputs with `samples` each, as many as the device asks for. Runs on the device's
/// thread with denormals flushed. Must not allocate, lock or wait.
using AudioCallback = std::function<void(std::span<float* const> outputs, int samples)>;

/// How an audio device fares.
enum class DeviceState {
    playing,
    lost,  ///< its server or card went away; silence until it is back
    gone   ///< it did not come back in time
};

/// An output device that calls back for sound. When it or its server vanishes it is tried again
/// each second for kPatience_s; when it is back the sound rises from silence. Throws
/// AudioInputError if `wanted` matches no or several devices (the message lists the candidates),
/// SampleRateRefused if the device plays at another rate, AudioFailure if there is no device or it
/// cannot be opened.
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

    /// Sound flows from here on. Throws AudioFailure.
    void start();

    /// No call for sound comes after it.
    void stop();

    /// The device that was chosen, its latency measured once it is started.
    const DeviceInfo& info() const;
    DeviceState state() const;  ///< [any thread]
    bool active() const { return state() == DeviceState::playing; }
    std::uint64_t reconnects() const;  ///< how often it came back

    /// Underruns and load since start.
    const OutputMeter& meter() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
