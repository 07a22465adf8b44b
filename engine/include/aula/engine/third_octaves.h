#pragma once

#include <cstddef>

namespace aula {

/// Number of the third octaves of parameters, from 50 Hz to 16 kHz.
inline constexpr std::size_t kThirdOctaveCount = 26;

/// The nominal centre of a third octave in Hz: "50" to "16000" (IEC 61260-1). `third` <
/// kThirdOctaveCount is not checked.
const char* third_octave_name(std::size_t third);

}  // namespace aula
