#pragma once

#include <cmath>
#include <cstddef>
#include <span>

#include "aula/audio/realtime.h"

namespace aula {

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
