#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "audio/base/realtime.h"
#include "audio/device/device.h"

namespace aula {

/// What is heard at the sound system's input, one channel, while this exists.
class Microphone {
 public:
    /// The input that belongs to an output: JACK's first one that is physical beside a JACK output;
    /// else that of the device of the same name, or the default one. Throws AudioFailure where
    /// there is none, or none of this rate.
    Microphone(const DeviceInfo& output, double sample_rate_hz, int block);
    ~Microphone();
    Microphone(const Microphone&) = delete;
    Microphone& operator=(const Microphone&) = delete;

    /// The samples, at most a block, of what is played from `position` on; the same ones when the
    /// same position is asked for again at once. [audio thread, wait-free]
    void read(std::int64_t position, std::span<float> out) noexcept AULA_NONBLOCKING;

    const std::string& name() const;

    /// False once its device or server went away.
    bool alive() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
