#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

/// Fade-in weights: the rising half of a raised cosine. Reversed they are one minus themselves.
std::vector<float> raised_cosine(std::size_t samples);

/// Fade-in weights on a straight line with rounded corners. What rises or falls steadily through
/// several fades in sequence nearly does so in one line. Reversed they are one minus themselves.
std::vector<float> rounded_line(std::size_t samples);

/// Multiplies the first samples by the weights.
inline void apply_weights(std::span<const float> weights,
                          float* samples) noexcept AULA_NONBLOCKING {
    for (std::size_t n = 0; n < weights.size(); ++n) samples[n] *= weights[n];
}

/// Position within a fade from 0 to 1. Fade-in and fade-out weights sum to one. Copies share the
/// curve. [one thread; wait-free except the constructors]
class Fade {
 public:
    /// On a raised cosine; done() until start().
    explicit Fade(std::size_t samples) : Fade(raised_cosine(samples)) {}

    /// On a given curve: fade-in weights that reversed are one minus themselves.
    explicit Fade(std::vector<float> weights)
        : curve_(std::make_shared<const std::vector<float>>(std::move(weights))),
          position_(curve_->size()) {}

    void start() noexcept AULA_NONBLOCKING { position_ = 0; }

    /// Reverses direction: the fade continues with one minus the present weight.
    void reverse() noexcept AULA_NONBLOCKING { position_ = curve_->size() - position_; }

    bool done() const noexcept AULA_NONBLOCKING { return position_ == curve_->size(); }

    /// Weight `n` samples after the present position; 1 beyond the end.
    float weight(std::size_t n) const noexcept AULA_NONBLOCKING {
        const std::size_t at = position_ + n;
        return at < curve_->size() ? (*curve_)[at] : 1.0F;
    }

    std::size_t remaining() const noexcept AULA_NONBLOCKING { return curve_->size() - position_; }

    void advance(std::size_t samples) noexcept AULA_NONBLOCKING {
        position_ = std::min(curve_->size(), position_ + samples);
    }

    /// Fades `samples`, starting at the present position, in or out, in place.
    void fade_in(std::span<float> samples) const noexcept AULA_NONBLOCKING {
        for (std::size_t n = 0; n < samples.size(); ++n) samples[n] *= weight(n);
    }
    void fade_out(std::span<float> samples) const noexcept AULA_NONBLOCKING {
        for (std::size_t n = 0; n < samples.size(); ++n) samples[n] *= 1 - weight(n);
    }

    /// Fades the next `samples` of each channel in, in place, and advances.
    void fade_in_next(std::span<float* const> channels,
                      std::size_t samples) noexcept AULA_NONBLOCKING {
        for (float* channel : channels) fade_in({channel, samples});
        advance(samples);
    }

    /// Crossfades from `old` to `samples`, in place.
    void cross(std::span<const float> old,
               std::span<float> samples) const noexcept AULA_NONBLOCKING {
        for (std::size_t n = 0; n < samples.size(); ++n)
            samples[n] = old[n] + weight(n) * (samples[n] - old[n]);
    }

 private:
    std::shared_ptr<const std::vector<float>> curve_;
    std::size_t position_;
};

}  // namespace aula
