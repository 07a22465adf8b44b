#pragma once

#include <stdexcept>
#include <string>

namespace aula {

/// A requested sound file, HRTF file or device cannot be used; programs exit with 2.
class AudioInputError : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

/// A failure at run time (no device, device lost, disk full); programs exit with 1.
class AudioFailure : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

/// There is no output device.
class NoAudioDevice : public AudioFailure {
 public:
    using AudioFailure::AudioFailure;
};

/// A device does not support the requested sample rate.
class SampleRateRefused : public AudioFailure {
 public:
    SampleRateRefused(const std::string& message, double device_rate_hz)
        : AudioFailure(message), device_rate_hz_(device_rate_hz) {}

    double device_rate_hz() const { return device_rate_hz_; }

 private:
    double device_rate_hz_;
};

}  // namespace aula
