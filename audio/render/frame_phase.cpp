#include "audio/render/frame_phase.h"

#include <algorithm>

namespace aula {

FramePhase::FramePhase(std::size_t frame_samples, std::size_t block, std::size_t fade_samples)
    : frame_(static_cast<std::int64_t>(frame_samples)),
      is_exact_(fade_samples <= frame_samples && block <= frame_samples),
      latest_(static_cast<std::int64_t>(block)) {
    // Frames that are shorter than a fade are taken at calls, a fade apart.
    if (!is_exact_) latest_ = static_cast<std::int64_t>((fade_samples + block - 1) / block * block);
}

std::int64_t FramePhase::take(std::int64_t now) noexcept {
    const std::int64_t frames = (now - due_) / frame_;
    if (is_first_ || frames < 1) {
        // A frame that is taken earlier than the others was due then, at the latest.
        due_ = now;
    } else {
        due_ = std::max(due_ + frames * frame_, now - latest_);
    }
    is_first_ = false;
    return due_ + latest_ + frame_;
}

}  // namespace aula
