#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aula {

/// The amplitude 0..1 of a flank about a frequency, in power the complement of falling_flank().
inline double rising_flank(double hz, double about_hz, double octaves) {
    if (!(hz > 0)) return 0;
    const double position = std::clamp(0.5 + std::log2(hz / about_hz) / octaves, 0.0, 1.0);
    return std::sin(std::numbers::pi / 2 * position);
}

inline double falling_flank(double hz, double about_hz, double octaves) {
    if (!(hz > 0)) return 1;
    const double position = std::clamp(0.5 + std::log2(hz / about_hz) / octaves, 0.0, 1.0);
    return std::cos(std::numbers::pi / 2 * position);
}

/// The amplitudes with which modes and the reverberation of rays are joined: an octave wide, linear
/// in phase, with squares that add up to 1, so that independent sounds keep their power.
struct WaveMasks {
    double crossover_hz = 0;  ///< where both have equal power

    /// Of the modes.
    double low(double hz) const { return falling_flank(hz, crossover_hz, 1); }
    /// Of the rays.
    double high(double hz) const { return rising_flank(hz, crossover_hz, 1); }
    /// Where low() ends.
    double end_hz() const { return crossover_hz * std::numbers::sqrt2; }
};

}  // namespace aula
