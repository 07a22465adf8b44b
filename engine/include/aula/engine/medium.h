#pragma once

#include "aula/engine/bands.h"

namespace aula {

/// The air of a scene.
struct Medium {
    float temperature_c = 20;
    float humidity_percent = 50;
    float pressure_kpa = 101.325F;
    bool air_absorption = true;

    /// Speed of sound in m/s, 343.2 sqrt((t + 273.15) / 293.15).
    float speed_of_sound_m_s() const;

    /// Energy attenuation coefficient m of each octave band in 1/m: energy decays as exp(-m
    /// length). ISO 9613-1 at the band's exact centre; zero without air absorption.
    Bands attenuation_per_m() const;
};

}  // namespace aula
