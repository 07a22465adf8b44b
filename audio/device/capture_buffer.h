#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/sample_ring.h"
#include "aula/audio/realtime.h"

namespace aula {

/// Adaptive jitter buffer between an input and an output with independent clocks. After an
/// underrun, which fades out, the reserve is increased. Samples that exceed the reserve for a
/// second are dropped with a crossfade.
class CaptureBuffer {
 public:
    /// read() takes at most `block` samples.
    CaptureBuffer(double sample_rate_hz, int block);

    /// Samples that do not fit are lost. [input thread, wait-free]
    void write(std::span<const float> samples) noexcept AULA_NONBLOCKING { ring_.write(samples); }

    /// Fills `out`, with silence if there are not enough samples. [output thread, wait-free]
    void read(std::span<float> out) noexcept AULA_NONBLOCKING;

    /// Samples kept in the buffer against jitter. [output thread]
    std::size_t reserve() const { return reserve_; }

 private:
    void underrun(std::span<float> out) noexcept AULA_NONBLOCKING;
    void drop_surplus(std::span<float> out) noexcept AULA_NONBLOCKING;

    SampleRing ring_;
    std::size_t observation_;  ///< observation time, samples
    std::size_t max_reserve_;
    std::size_t reserve_;
    float fade_step_;
    bool running_ = false;
    float gain_ = 0;  ///< of the fade-in after silence
    float last_ = 0;  ///< last sample output
    std::size_t lowest_fill_ =
        0;                      ///< lowest fill level after read() in the observation time, samples
    std::size_t observed_ = 0;  ///< position within the observation time, samples
    std::vector<float> scratch_;
};

}  // namespace aula
