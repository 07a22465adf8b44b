#pragma once

#include <array>
#include <cstddef>

#include "aula/engine/bands.h"
#include "aula/engine/medium.h"

namespace aula {

/// Divides the energy of octave bands into third octaves from 50 Hz to 20 kHz. The loss by surfaces
/// in dB is linear in the logarithm of the frequency between the centres of the octaves, and
/// constant below 63 Hz and above 8 kHz. The loss by air is that of each frequency. Immutable.
class ThirdOctaveModel {
 public:
    static constexpr std::size_t kCount = 27;  ///< 50 Hz to 20 kHz
    using Values = std::array<float, kCount>;

    explicit ThirdOctaveModel(const Medium& medium);

    /// Exact centre of a third octave in Hz, 1000 * 10^(k/10) (IEC 61260-1).
    static double centre_hz(std::size_t third);

    /// The octave that a third octave lies in, or that is the nearest one.
    static std::size_t octave(std::size_t third);

    /// The energies at the centres of third octaves, of sound that has travelled `length_m` and has
    /// the energy `octaves` in octave bands, relative to the emitted energy. Between an octave
    /// without energy and the next one there is none.
    Values at_centres(const Bands& octaves, double length_m) const;

    /// The same as means over each third octave (ISO 9613-1, annex D), whose level has the slope
    /// between its edges. Late in a steep spectrum they decay more slowly than the centres: the low
    /// frequencies remain.
    Values energies(const Bands& octaves, double length_m) const;

 private:
    /// The lower edge of each third octave, its centre, and the upper edge of the last one.
    static constexpr std::size_t kPoints = 2 * kCount + 1;

    float level(const Bands& octave_levels, double length_m, std::size_t point) const;

    /// [point] m of the air, less what the interpolation of octaves contains, 1/m.
    std::array<float, kPoints> excess_per_m_{};
};

}  // namespace aula
