#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

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

/// Output devices (PortAudio); the libraries' own messages are silenced. Empty where no sound
/// server runs.
std::vector<DeviceInfo> list_output_devices();

/// An open output device that calls back for sound. Throws AudioInputError if `wanted` matches no
/// or several devices (the message lists the candidates), SampleRateRefused if the device plays at
/// another rate, AudioFailure if there is no device or it cannot be opened.
class AudioDevice {
 public:
    /// Fills `channels` planar outputs of `samples` each, at most `block`. Runs on the device's
    /// thread with denormals flushed. Must not allocate, lock or wait.
    using Callback = std::function<void(std::span<float* const> outputs, int samples)>;

    /// `wanted`: an index, a part of a name, or empty for the default device.
    AudioDevice(const std::string& wanted, double sample_rate_hz, std::size_t channels, int block,
                Callback callback);
    ~AudioDevice();
    AudioDevice(const AudioDevice&) = delete;
    AudioDevice& operator=(const AudioDevice&) = delete;

    void start();
    void stop();

    const DeviceInfo& info() const;
    bool active() const;              ///< false once the device or its server is gone
    std::uint64_t underruns() const;  ///< output underflow flags since start
    double load() const;              ///< share of the block's time spent in the callback, smoothed
    double worst_load() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
