#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "audio/base/realtime.h"

namespace aula {

/// Rising half of a raised cosine: the weight that fades in over `samples`, sample by sample.
/// Backwards it is one minus itself.
std::vector<float> raised_cosine(std::size_t samples);

/// A raised cosine that is gone along sample by sample, from 0 to 1; what falls meanwhile has one
/// minus its weight, so that both add up to one. Copies share the curve. [one thread, wait-free but
/// for the construction]
class Fade {
 public:
    /// Is done until it is started.
    explicit Fade(std::size_t samples)
        : curve_(std::make_shared<const std::vector<float>>(raised_cosine(samples))),
          position_(samples) {}

    void start() noexcept AULA_NONBLOCKING { position_ = 0; }

    /// Goes back from where it is: one minus the weight is from now on what the weight was.
    void turn_back() noexcept AULA_NONBLOCKING { position_ = curve_->size() - position_; }

    bool done() const noexcept AULA_NONBLOCKING { return position_ == curve_->size(); }

    /// Of the sample that is `n` ahead; 1 behind the end.
    float weight(std::size_t n) const noexcept AULA_NONBLOCKING {
        const std::size_t at = position_ + n;
        return at < curve_->size() ? (*curve_)[at] : 1.0F;
    }

    void advance(std::size_t samples) noexcept AULA_NONBLOCKING {
        position_ = std::min(curve_->size(), position_ + samples);
    }

    /// Weights the samples in hand: rising, or falling in its stead.
    void rise(std::span<float> samples) const noexcept AULA_NONBLOCKING {
        for (std::size_t n = 0; n < samples.size(); ++n) samples[n] *= weight(n);
    }
    void fall(std::span<float> samples) const noexcept AULA_NONBLOCKING {
        for (std::size_t n = 0; n < samples.size(); ++n) samples[n] *= 1 - weight(n);
    }

    /// Goes over from `old` to the samples in hand.
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
