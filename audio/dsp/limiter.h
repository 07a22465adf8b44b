#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "audio/base/realtime.h"

namespace aula {

/// Keeps the peaks of all channels together, those between samples too, below a ceiling (-1 dBTP)
/// by looking ahead; the gain falls before a peak and recovers after it. Delays the sound by
/// latency_samples().
/// [audio thread, but for the constructor]
class Limiter {
 public:
    /// For calls of at most `max_block` samples.
    Limiter(double sample_rate_hz, std::size_t channels, int max_block);
    ~Limiter();

    /// Limits, in place, as many channels as the constructor was told. Samples that are not numbers
    /// or beyond +-1e6 are muted: no peak could be found among them.
    void process(std::span<float* const> channels, int samples) noexcept AULA_NONBLOCKING;
    int latency_samples() const;

    /// The least gain in the last process(). [audio thread]
    float least_gain() const noexcept AULA_NONBLOCKING;

    /// Samples of all channels that were muted in the last process(). [audio thread]
    std::size_t muted_samples() const noexcept AULA_NONBLOCKING;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
