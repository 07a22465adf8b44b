#include "audio/device/capture_buffer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace aula {

namespace {

constexpr double kRoom_s = 1;
constexpr double kMaxReserve_s = 0.2;
constexpr double kFade_s = 0.005;

}  // namespace

CaptureBuffer::CaptureBuffer(double sample_rate_hz, int block)
    : ring_(std::max(static_cast<std::size_t>(kRoom_s * sample_rate_hz),
                     4 * static_cast<std::size_t>(block))),
      observation_(static_cast<std::size_t>(sample_rate_hz)),
      max_reserve_(static_cast<std::size_t>(kMaxReserve_s * sample_rate_hz)),
      reserve_(static_cast<std::size_t>(block)),
      fade_step_(static_cast<float>(1 / (kFade_s * sample_rate_hz))),
      scratch_(static_cast<std::size_t>(block)) {}

void CaptureBuffer::read(std::span<float> out) noexcept {
    const std::size_t available = ring_.size();
    if (!running_) {
        if (available < reserve_ + out.size()) {
            std::fill(out.begin(), out.end(), 0.0F);
            return;
        }
        running_ = true;
        gain_ = 0;
        observed_ = 0;
        lowest_fill_ = std::numeric_limits<std::size_t>::max();
    }
    if (available < out.size()) return underrun(out);
    ring_.read(out);
    lowest_fill_ = std::min(lowest_fill_, available - out.size());
    observed_ += out.size();
    if (observed_ >= observation_) drop_surplus(out);
    for (std::size_t i = 0; i < out.size() && gain_ < 1; ++i) {
        gain_ = std::min(1.0F, gain_ + fade_step_);
        out[i] *= gain_;
    }
    last_ = out.back();
}

/// Outputs the remaining samples, repeats the last one and fades out within the block.
void CaptureBuffer::underrun(std::span<float> out) noexcept {
    const std::size_t count = ring_.read(out);
    if (count > 0) last_ = out[count - 1];
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(count), out.end(), last_);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] *= gain_ * (1 - static_cast<float>(i + 1) / static_cast<float>(out.size()));
    last_ = 0;
    running_ = false;
    reserve_ = std::min(max_reserve_, reserve_ + out.size());
}

/// Drops samples that exceeded the reserve throughout the observation time, with a crossfade over
/// the block.
void CaptureBuffer::drop_surplus(std::span<float> out) noexcept {
    const std::size_t surplus = lowest_fill_ > reserve_ ? lowest_fill_ - reserve_ : 0;
    observed_ = 0;
    lowest_fill_ = std::numeric_limits<std::size_t>::max();
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
