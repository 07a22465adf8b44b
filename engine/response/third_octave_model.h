#pragma once

#include <array>
#include <cstddef>

#include "aula/engine/bands.h"
#include "aula/engine/medium.h"

namespace aula {

/// Divides the energy of octave bands into third octaves from 50 Hz to 20 kHz. The loss by surfaces
/// in dB is linear in the logarithm of the frequency between the centres of the octaves, and
/// constant below 63 Hz and above 8 kHz. The loss by air is that at the centre of each third
/// octave. Immutable.
class ThirdOctaveModel {
 public:
    static constexpr std::size_t kCount = 27;
    using Values = std::array<float, kCount>;

    explicit ThirdOctaveModel(const Medium& medium);

    /// Exact centre of a third octave in Hz, 1000 * 10^(k/10) (IEC 61260-1).
    static double centre_hz(std::size_t third);

    /// The octave that a third octave lies in, or that is the nearest one.
    static std::size_t octave(std::size_t third);

    /// The energies of sound that has travelled `length_m` and has the energy `octaves` in octave
    /// bands, relative to the emitted energy. Between an octave without energy and the next one
    /// third octaves have none.
    Values energies(const Bands& octaves, double length_m) const;

 private:
    /// [third octave] m of the air, less what the interpolation of octaves contains, 1/m.
    Values excess_per_m_{};
};

}  // namespace aula
