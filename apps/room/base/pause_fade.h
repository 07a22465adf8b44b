#pragma once

#include <atomic>
#include <span>
#include <vector>

#include "audio/dsp/fade.h"

namespace aula {

/// Fades the sound out before a pause and in after it. Sample time stops after the fade-out, until
/// the end of the pause. [rendering thread, except set_paused() and silent()]
class PauseFade {
 public:
    /// `block`: the largest number of samples of a part.
    PauseFade(double sample_rate_hz, int block);

    /// [any thread]
    void set_paused(bool paused) { paused_.store(paused); }

    /// Whether the fade-out is complete. [any thread]
    bool silent() const { return silent_.load(); }

    /// The number of the next `samples` samples to render: all, so that blocks stay whole, or 0 in
    /// a pause: the outputs are zero from sample `done` on.
    int advance(std::span<float* const> outputs, int done, int samples) noexcept AULA_NONBLOCKING;

    /// `samples`, or as many as the fade-out still has: time stops with its last sample.
    int until_silence(int samples) const noexcept AULA_NONBLOCKING;

    /// The weights of the next part; 0 after a fade-out. Of inputs and outputs: no sound from
    /// before a pause is audible after it. Of outputs alone: it continues. Empty without a fade.
    std::span<const float> weights(int samples) noexcept AULA_NONBLOCKING;

 private:
    std::atomic<bool> paused_ = false;
    std::atomic<bool> silent_ = false;
    Fade fade_;
    bool fading_out_ = false;  ///< otherwise fading in
    std::vector<float> weights_;
};

}  // namespace aula
