#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "aula/audio/realtime.h"
#include "aula/devices/device.h"

namespace aula {

/// One channel of audio input. It records while the object exists. An adaptive buffer compensates
/// for the difference between the clocks of input and output.
class Microphone {
 public:
    /// Opens the input that matches an output. For a JACK output that is the first physical input
    /// of the JACK server; otherwise the input of the device of the same name, or the default
    /// input. `block` is the largest number of samples per read(). Throws Failure if there is no
    /// input, or none of this sample rate.
    Microphone(const DeviceInfo& output, double sample_rate_hz, int block);
    ~Microphone();
    Microphone(const Microphone&) = delete;
    Microphone& operator=(const Microphone&) = delete;

    /// Reads the samples of the output block that starts at sample `position` >= 0, at most a
    /// block. Repeated calls for the same position give the same samples. Missing samples are
    /// silent. [audio thread, wait-free]
    void read(std::int64_t position, std::span<float> out) noexcept AULA_NONBLOCKING;

    /// Name of the input in its sound system.
    const std::string& name() const;

    /// False if the device or server has disappeared.
    bool alive() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
