#pragma once

#include <cmath>
#include <cstddef>
#include <span>

#include "aula/audio/realtime.h"

namespace aula {

/// Larger magnitudes, 120 dB above full scale, are faults of what made the samples. The bound keeps
/// all sums finite: with the largest gain of a source (1e10), 1e3 sources and the 1.6e4 samples of
/// the largest transform they stay below 1e24, the largest float is 3e38.
inline constexpr float kLargestSample = 1e6F;

/// Whether all samples are finite and at most `largest` in magnitude. [audio thread, wait-free]
inline bool all_within(float largest, std::span<const float> samples) noexcept AULA_NONBLOCKING {
    bool within = true;
    // The comparison fails for NaN, too. Without an early return the loop is vectorised.
    for (const float sample : samples) within &= std::abs(sample) <= largest;
    return within;
}

/// Mutes samples that are not finite or exceed `largest` in magnitude. Returns their number.
/// [audio thread, wait-free]
inline std::size_t mute_beyond(float largest, std::span<float> samples) noexcept AULA_NONBLOCKING {
    std::size_t muted = 0;
    for (float& sample : samples) {
        // False for NaN.
        const bool usable = std::abs(sample) <= largest;
        sample = usable ? sample : 0.0F;
        muted += usable ? 0 : 1;
    }
    return muted;
}

}  // namespace aula
