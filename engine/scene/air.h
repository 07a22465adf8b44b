#pragma once

#include "aula/engine/medium.h"

namespace aula {

/// Energy attenuation coefficient m of a medium in 1/m at a frequency > 0 in Hz, see
/// Medium::attenuation_per_m().
double air_attenuation_per_m(const Medium& medium, double frequency_hz);

}  // namespace aula
