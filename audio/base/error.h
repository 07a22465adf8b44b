#pragma once

#include <stdexcept>
#include <string>

namespace aula {

/// A sound file, HRTF file or device that was asked for and cannot be used; programs exit with 2.
class AudioInputError : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

/// Failed while running: no device at all, a device lost, a disk full; programs exit with 1.
class AudioFailure : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

/// There is nothing to play on.
class NoAudioDevice : public AudioFailure {
 public:
    using AudioFailure::AudioFailure;
};

/// A device that does not play at the sample rate asked for, but at its own.
class SampleRateRefused : public AudioFailure {
 public:
    SampleRateRefused(const std::string& message, double device_rate_hz)
        : AudioFailure(message), device_rate_hz_(device_rate_hz) {}

    double device_rate_hz() const { return device_rate_hz_; }

 private:
    double device_rate_hz_;
};

}  // namespace aula
