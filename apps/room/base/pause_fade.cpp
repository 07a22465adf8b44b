#include "apps/room/base/pause_fade.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace aula {

namespace {

constexpr double kPauseFade_s = 0.02;

}  // namespace

PauseFade::PauseFade(double sample_rate_hz, int block)
    : fade_(static_cast<std::size_t>(std::lround(kPauseFade_s * sample_rate_hz))),
      weights_(static_cast<std::size_t>(block)) {}

int PauseFade::advance(std::span<float* const> outputs, int done, int samples) noexcept {
    const bool pausing = paused_.load(std::memory_order_relaxed);
    if (pausing != fading_out_) {
        fading_out_ = pausing;
        fade_.reverse();
    }
    const bool is_silent = fading_out_ && fade_.done();
    silent_.store(is_silent, std::memory_order_relaxed);
    if (is_silent) {
        for (float* const channel : outputs) std::fill_n(channel + done, samples, 0.0F);
        return 0;
    }
    return samples;
}

int PauseFade::until_silence(int samples) const noexcept {
    return fading_out_ ? std::min(samples, static_cast<int>(fade_.remaining())) : samples;
}

std::span<const float> PauseFade::weights(int samples) noexcept {
    if (fade_.done()) return {};
    const auto count = static_cast<std::size_t>(samples);
    for (std::size_t n = 0; n < count; ++n)
        weights_[n] = fading_out_ ? 1 - fade_.weight(n) : fade_.weight(n);
    fade_.advance(count);
    return std::span(weights_).first(count);
}

}  // namespace aula
