#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "aula/audio/realtime.h"

namespace aula {

/// Look-ahead true-peak limiter with a ceiling of -1 dBTP and one gain for all channels. The gain
/// falls before a peak and recovers after it. The signal is delayed by latency_samples().
/// [audio thread, except the constructor]
class Limiter {
 public:
    /// process() takes at most `max_block` samples.
    Limiter(double sample_rate_hz, std::size_t channels, int max_block);
    ~Limiter();

    /// Limits the constructor's number of channels, channels[channel][sample], in place. The
    /// samples are finite.
    void process(std::span<float* const> channels, int samples) noexcept AULA_NONBLOCKING;
    int latency_samples() const;

    /// The smallest gain in the last process(). [audio thread]
    float min_gain() const noexcept AULA_NONBLOCKING;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
