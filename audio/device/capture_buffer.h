#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/realtime.h"
#include "audio/base/sample_ring.h"

namespace aula {

/// What an input hears, on its way to an output that asks for it at its own pace. As little is held
/// back as keeps it flowing: when it runs dry it fades, and more is held back from then on; what
/// has gathered for a second beyond need is left out in a crossfade.
class CaptureBuffer {
 public:
    /// `block`: samples that are read at a time, at most.
    CaptureBuffer(double sample_rate_hz, int block);

    /// What finds no room, as nobody reads, is lost. [input's thread, wait-free]
    void write(std::span<const float> samples) noexcept AULA_NONBLOCKING { ring_.write(samples); }

    /// Silence where nothing is there. [output's thread, wait-free]
    void read(std::span<float> out) noexcept AULA_NONBLOCKING;

    /// Samples held back for what comes late. [output's thread]
    std::size_t reserve() const { return reserve_; }

 private:
    void run_dry(std::span<float> out) noexcept AULA_NONBLOCKING;
    void leave_out_surplus(std::span<float> out) noexcept AULA_NONBLOCKING;

    SampleRing ring_;
    std::size_t second_;  ///< samples
    std::size_t most_reserve_;
    std::size_t reserve_;
    float fade_step_;
    bool flowing_ = false;
    float gain_ = 0;           ///< of the fade after silence
    float last_ = 0;           ///< sample
    std::size_t least_ = 0;    ///< that was left after a reading, of late
    std::size_t watched_ = 0;  ///< samples since `least_` began
    std::vector<float> scratch_;
};

}  // namespace aula
