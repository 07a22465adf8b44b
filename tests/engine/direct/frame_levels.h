#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <numbers>

#include "engine/direct/direct_sound.h"

namespace aula::test {

/// Levels of the next frame's direct sound relative to free field, dB.
inline std::array<double, kBandCount> frame_levels_db(DirectSound& direct_sound, PairMemory& memory,
                                                      const Vec3& source, const Vec3& listener) {
    direct_sound.begin_frame(false);
    direct_sound.search(source, listener, memory);
    Bands sum;
    for (const SoundPath& path : direct_sound.find(source, listener, {}, Bands{}, memory)) {
        sum += path.energy;
    }
    const double distance_m = double{glm::distance(source, listener)};
    std::array<double, kBandCount> levels;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        levels[b] =
            10 *
            std::log10(4 * std::numbers::pi * distance_m * distance_m * double{sum[b]} + 1e-20);
    }
    return levels;
}

}  // namespace aula::test
