#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "audio/base/assume_nonblocking.h"
#include "aula/devices/device.h"
#include "aula/devices/output_meter.h"

namespace aula {

/// Parameters of an output.
struct OutputSettings {
    double sample_rate_hz = 48000;
    std::size_t channels = 2;
    int block = 256;  ///< preferred; JACK's server determines its own
    AudioCallback callback;
    OutputMeter* meter = nullptr;

    /// Calls the callback, which must not block. [audio thread]
    void call(std::span<float* const> outputs, int samples) const noexcept AULA_NONBLOCKING {
        assume_nonblocking([&] { callback(outputs, samples); });
    }
};

/// An open output of a sound system. It plays from start() until destruction.
class Output {
 public:
    Output() = default;
    virtual ~Output() = default;
    Output(const Output&) = delete;
    Output& operator=(const Output&) = delete;

    /// Throws Failure.
    virtual void start() = 0;
    virtual bool alive() const = 0;
    virtual double latency_s() const = 0;  ///< 0: unknown
};

/// JACK without PortAudio, which cannot close a stream after the server has died. Devices are the
/// clients with inputs; empty if no server is running.
std::vector<DeviceInfo> list_jack_outputs();
std::unique_ptr<Output> open_jack_output(const DeviceInfo& device, const OutputSettings& settings);

/// Other devices of PortAudio: ALSA, and PulseAudio through ALSA. Empty if PortAudio cannot be
/// initialised, as without a configuration of ALSA.
std::vector<DeviceInfo> list_port_audio_outputs();
std::unique_ptr<Output> open_port_audio_output(const DeviceInfo& device,
                                               const OutputSettings& settings);

/// Requests samples in real time and discards them.
DeviceInfo silent_output();
std::unique_ptr<Output> open_silent_output(const OutputSettings& settings);

/// Parameters of an input.
struct InputSettings {
    double sample_rate_hz = 48000;
    int block = 256;  ///< preferred
    /// Called on the input's thread with the recorded samples, one channel. Must not allocate, lock
    /// or wait.
    std::function<void(std::span<const float>)> callback;
};

/// An open input of a sound system. It records while it exists.
class Input {
 public:
    Input() = default;
    virtual ~Input() = default;
    Input(const Input&) = delete;
    Input& operator=(const Input&) = delete;

    virtual const std::string& name() const = 0;
    virtual bool alive() const = 0;
};

/// Open the JACK server's first physical input; the input of the device `beside` or the default
/// input. Throw Failure.
std::unique_ptr<Input> open_jack_input(const InputSettings& settings);
std::unique_ptr<Input> open_port_audio_input(const DeviceInfo& beside,
                                             const InputSettings& settings);

/// Throws SampleRateRefused.
[[noreturn]] void refuse_rate(const DeviceInfo& device, double wanted_hz, double device_hz);

}  // namespace aula
