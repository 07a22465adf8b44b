#pragma once

#include <array>
#include <optional>

#include "engine/response/energy_response.h"

namespace aula {

/// ISO 3382-1 parameters of one octave band; empty where the response has not enough decay.
struct BandParameters {
    std::optional<double> t20_s, t30_s, edt_s;
    std::optional<double> c50_db, c80_db;
    std::optional<double> d50;   ///< 0..1
    std::optional<double> ts_s;  ///< centre time
    std::optional<double> g_db;  ///< strength re 1/(400 pi) 1/m2
};

using RoomParameters = std::array<BandParameters, kBandCount>;

/// Parameters from an energy response. Time zero is the direct sound's arrival if it is among the
/// paths, else the first arrival. The decay curve is Schroeder's backward integral; a fit must
/// reach -25 dB (T20), -35 dB (T30) or -10 dB (EDT) 10 dB clear of what the response's end cuts
/// off, else it is empty; the others need a total 10 dB clear of it. What is cut off is estimated
/// from the late slope and counted in. Never NaN or infinite.
RoomParameters room_parameters(const EnergyResponse& response);

/// Strength below which a source is not audible, dB: 60 dB below its level at 1 m. A voice of 60 dB
/// there (ISO 9921, normal effort) falls to 0 dB, the threshold of hearing.
inline constexpr double kAudible_g_db = -40;

/// True if the strength of an octave is at least kAudible_g_db.
bool is_audible(const EnergyResponse& response);

/// Reverberation time in s after Eyring for each band: 24 ln(10) V / (c (4 m V - S ln(1 - a))),
/// infinite without any loss.
Bands eyring_time_s(double volume_m3, double surface_m2, const Bands& mean_absorption,
                    const Bands& attenuation_per_m, double speed_of_sound_m_s);

}  // namespace aula
