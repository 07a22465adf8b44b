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
    /// samples, and not before `fade_samples` after the last one.
    FramePhase(std::size_t frame_samples, std::size_t block, std::size_t fade_samples);

    /// Takes a frame at sample `now` of the output. Returns the number of samples after which the
    /// motion reaches its state: not before the next frame is taken, if that is in time.
    std::size_t take(std::int64_t now) noexcept AULA_NONBLOCKING;

 private:
    std::int64_t frame_;
    std::int64_t latest_;   ///< longest time from due to taken
    std::int64_t due_ = 0;  ///< time of the last frame
    bool is_first_ = true;
};

}  // namespace aula
