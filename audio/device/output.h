#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "audio/device/device.h"
#include "audio/device/output_meter.h"

namespace aula {

/// What an output is opened with.
struct OutputSettings {
    double sample_rate_hz = 48000;
    std::size_t channels = 2;
    int block = 256;  ///< wished for; JACK has its own
    AudioCallback callback;
    OutputMeter* meter = nullptr;
};

/// An open output of one sound system; sound flows while it exists.
class Output {
 public:
    Output() = default;
    virtual ~Output() = default;
    Output(const Output&) = delete;
    Output& operator=(const Output&) = delete;

    /// Throws AudioFailure.
    virtual void start() = 0;
    virtual bool alive() const = 0;
    virtual double latency_s() const = 0;  ///< 0: not known
};

/// JACK, spoken to directly: PortAudio cannot let go of a server that died.
/// Devices are the clients that play; empty where no server runs.
std::vector<DeviceInfo> list_jack_outputs();
std::unique_ptr<Output> open_jack_output(const DeviceInfo& device, const OutputSettings& settings);

/// All else that PortAudio knows: ALSA, and PulseAudio through it.
std::vector<DeviceInfo> list_port_audio_outputs();
std::unique_ptr<Output> open_port_audio_output(const DeviceInfo& device,
                                               const OutputSettings& settings);

/// Nobody, in real time.
DeviceInfo silent_output();
std::unique_ptr<Output> open_silent_output(const OutputSettings& settings);

/// What an input is opened with.
struct InputSettings {
    double sample_rate_hz = 48000;
    int block = 256;  ///< wished for
    /// Called on the input's thread with what was heard, one channel. Must not allocate, lock or
    /// wait.
    std::function<void(std::span<const float>)> callback;
};

/// An open input of one sound system; it hears while it exists.
class Input {
 public:
    Input() = default;
    virtual ~Input() = default;
    Input(const Input&) = delete;
    Input& operator=(const Input&) = delete;

    virtual const std::string& name() const = 0;
    virtual bool alive() const = 0;
};

/// The server's first physical input; beside a device, its own input or the default one. Throw
/// AudioFailure.
std::unique_ptr<Input> open_jack_input(const InputSettings& settings);
std::unique_ptr<Input> open_port_audio_input(const DeviceInfo& beside,
                                             const InputSettings& settings);

/// How a rate that a device does not play at is refused.
[[noreturn]] void refuse_rate(const DeviceInfo& device, double wanted_hz, double device_hz);

}  // namespace aula
