#include "audio/device/capture_buffer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace aula {

namespace {

constexpr double kRoom_s = 1;
constexpr double kMostReserve_s = 0.2;
constexpr double kFade_s = 0.005;

}  // namespace

CaptureBuffer::CaptureBuffer(double sample_rate_hz, int block)
    : ring_(std::max(static_cast<std::size_t>(kRoom_s * sample_rate_hz),
                     4 * static_cast<std::size_t>(block))),
      second_(static_cast<std::size_t>(sample_rate_hz)),
      most_reserve_(static_cast<std::size_t>(kMostReserve_s * sample_rate_hz)),
      reserve_(static_cast<std::size_t>(block)),
      fade_step_(static_cast<float>(1 / (kFade_s * sample_rate_hz))),
      scratch_(static_cast<std::size_t>(block)) {}

void CaptureBuffer::read(std::span<float> out) noexcept {
    const std::size_t there = ring_.size();
    if (!flowing_) {
        if (there < reserve_ + out.size()) {
            std::fill(out.begin(), out.end(), 0.0F);
            return;
        }
        flowing_ = true;
        gain_ = 0;
        watched_ = 0;
        least_ = std::numeric_limits<std::size_t>::max();
    }
    if (there < out.size()) return run_dry(out);
    ring_.read(out);
    least_ = std::min(least_, there - out.size());
    watched_ += out.size();
    if (watched_ >= second_) leave_out_surplus(out);
    for (std::size_t i = 0; i < out.size() && gain_ < 1; ++i) {
        gain_ = std::min(1.0F, gain_ + fade_step_);
        out[i] *= gain_;
    }
    last_ = out.back();
}

/// Plays what is left and holds its last sample, all of it fading within the block.
void CaptureBuffer::run_dry(std::span<float> out) noexcept {
    const std::size_t count = ring_.read(out);
    if (count > 0) last_ = out[count - 1];
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(count), out.end(), last_);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] *= gain_ * (1 - static_cast<float>(i + 1) / static_cast<float>(out.size()));
    last_ = 0;
    flowing_ = false;
    reserve_ = std::min(most_reserve_, reserve_ + out.size());
}

/// Goes over, within the block, to what came later: what was never needed is held back no longer.
void CaptureBuffer::leave_out_surplus(std::span<float> out) noexcept {
    const std::size_t surplus = least_ > reserve_ ? least_ - reserve_ : 0;
    watched_ = 0;
    least_ = std::numeric_limits<std::size_t>::max();
    if (surplus < 2 * out.size()) return;
    ring_.skip(surplus - out.size());
    const std::span<float> later = std::span(scratch_).first(out.size());
    ring_.read(later);
    for (std::size_t i = 0; i < out.size(); ++i) {
        const float weight = static_cast<float>(i + 1) / static_cast<float>(out.size());
        out[i] += weight * (later[i] - out[i]);
    }
}

}  // namespace aula
