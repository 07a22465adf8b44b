#include "aula/engine/medium.h"

#include <cmath>

#include "engine/scene/air.h"

namespace aula {

float Medium::speed_of_sound_m_s() const {
    return 343.2F * std::sqrt((temperature_c + 273.15F) / 293.15F);
}

// ISO 9613-1, equations (3) to (5).
double air_attenuation_per_m(const Medium& medium, double frequency_hz) {
    if (!medium.air_absorption) return 0;
    const double f = frequency_hz;
    const double t = double{medium.temperature_c} + 273.15;
    const double t_ratio = t / 293.15;
    const double p_ratio = double{medium.pressure_kpa} / 101.325;
    // Molar concentration of water vapour in percent, Annex B.
    const double c = -6.8346 * std::pow(273.16 / t, 1.261) + 4.6151;
    const double h = double{medium.humidity_percent} * std::pow(10.0, c) / p_ratio;
    // Relaxation frequencies of oxygen and nitrogen, (3) and (4).
    const double fr_o = p_ratio * (24 + 4.04e4 * h * (0.02 + h) / (0.391 + h));
    const double fr_n = p_ratio / std::sqrt(t_ratio) *
                        (9 + 280 * h * std::exp(-4.170 * (std::pow(t_ratio, -1.0 / 3) - 1)));
    const double oxygen = 0.01275 * std::exp(-2239.1 / t) / (fr_o + f * f / fr_o);
    const double nitrogen = 0.1068 * std::exp(-3352.0 / t) / (fr_n + f * f / fr_n);
    const double classical = 1.84e-11 / p_ratio * std::sqrt(t_ratio);
    // (5): pressure attenuation in dB/m.
    const double a_db = 8.686 * f * f * (classical + std::pow(t_ratio, -2.5) * (oxygen + nitrogen));
    // Energy decays by a_db decibels per metre: exp(-m) = 10^(-a_db / 10).
    return a_db * std::log(10.0) / 10;
}

// At the exact octave centres 1000 * 10^(3k/10) Hz.
Bands Medium::attenuation_per_m() const {
    Bands m;
    for (std::size_t b = 0; b < kBandCount; ++b)
        m[b] = static_cast<float>(air_attenuation_per_m(
            *this, 1000 * std::pow(10.0, 0.3 * (static_cast<double>(b) - 4))));
    return m;
}

}  // namespace aula
