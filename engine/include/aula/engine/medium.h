#pragma once

#include "aula/engine/bands.h"

namespace aula {

/// The air of a scene. A scene file limits each value to the range that is given here.
struct Medium {
    float temperature_c = 20;       ///< degrees Celsius, -100 to 100
    float humidity_percent = 50;    ///< relative humidity, 0 to 100
    float pressure_kpa = 101.325F;  ///< static pressure, 1 to 1000
    bool air_absorption = true;     ///< false: the air does not attenuate sound

    /// Speed of sound in m/s, 343.2 sqrt((t + 273.15) / 293.15) at t degrees Celsius (ISO 9613-1).
    float speed_of_sound_m_s() const;

    /// Energy attenuation coefficient m of each octave band in 1/m: over the length r the energy
    /// decays as exp(-m r). By ISO 9613-1 at the exact centre of the band; 0 without air
    /// absorption.
    Bands attenuation_per_m() const;
};

}  // namespace aula
