#pragma once

#include <cstddef>
#include <cstdint>

#include "aula/audio/realtime.h"

namespace aula {

/// The times at which frames are due, from the times at which they are taken. A frame is taken at
/// the start of a call, up to a block after it is due. Motion that reaches each frame's state at a
/// fixed time after the frame is due is uniform, although calls and frames have different periods.
/// [audio thread, wait-free]
class FramePhase {
 public:
    /// A frame is due every `frame_samples`. It is taken at the start of a call of at most `block`
    /// samples. If it is not exact, frames are taken when a fade has ended.
    FramePhase(std::size_t frame_samples, std::size_t block, std::size_t fade_samples);

    /// Takes a frame at sample `now` of the output. Returns the sample at which the motion reaches
    /// its state: not before the next frame takes effect, if that is in time.
    std::int64_t take(std::int64_t now) noexcept AULA_NONBLOCKING;

    /// Whether a frame takes effect when the fade to the previous one has ended, within a call:
    /// fades and blocks are no longer than a frame.
    bool is_exact() const noexcept AULA_NONBLOCKING { return is_exact_; }

 private:
    std::int64_t frame_;
    bool is_exact_;
    std::int64_t latest_;   ///< longest time from due to taken
    std::int64_t due_ = 0;  ///< time of the last frame
    bool is_first_ = true;
};

}  // namespace aula
