#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "aula/audio/realtime.h"
#include "aula/devices/device.h"

namespace aula {

/// One channel of audio input. It records while the object exists.
class Microphone {
 public:
    /// Opens the input that matches an output: the first physical input of the JACK server for a
    /// JACK output, otherwise that of the device of the same name, or the default input. Throws
    /// Failure if there is no input, or none of this sample rate.
    Microphone(const DeviceInfo& output, double sample_rate_hz, int block);
    ~Microphone();
    Microphone(const Microphone&) = delete;
    Microphone& operator=(const Microphone&) = delete;

    /// Reads the samples of the output block that starts at sample `position`, at most a block.
    /// Repeated calls for the same position give the same samples. [audio thread, wait-free]
    void read(std::int64_t position, std::span<float> out) noexcept AULA_NONBLOCKING;

    const std::string& name() const;

    /// False if the device or server has disappeared.
    bool alive() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
