#pragma once

#include <array>
#include <optional>

#include "aula/engine/energy_response.h"

namespace aula {

/// ISO 3382-1 parameters of one octave band; empty if the decay of the response is insufficient.
struct BandParameters {
    std::optional<double> t20_s, t30_s, edt_s;
    std::optional<double> c50_db, c80_db;
    std::optional<double> d50;   ///< 0..1
    std::optional<double> ts_s;  ///< centre time
    std::optional<double> g_db;  ///< strength re 1/(400 pi) 1/m2
};

using RoomParameters = std::array<BandParameters, kBandCount>;

/// Parameters of an energy response. Time zero is the arrival of the direct sound if it is among
/// the paths, otherwise the first arrival. The decay curve is Schroeder's backward integral; the
/// tail after the end of the response is estimated from the late slope and included. A decay time
/// is empty unless the curve at -25 dB (T20), -35 dB (T30) or -10 dB (EDT) is 10 dB above the tail.
/// The other parameters require a total 10 dB above it. No value is NaN or infinite.
RoomParameters room_parameters(const EnergyResponse& response);

/// Strength below which a source is not audible, dB: 60 dB below its level at 1 m. A voice of 60 dB
/// at 1 m (ISO 9921, normal effort) then has 0 dB, the threshold of hearing.
inline constexpr double kAudible_g_db = -40;

/// Whether the strength of any octave band is at least kAudible_g_db.
bool is_audible(const EnergyResponse& response);

/// Eyring's reverberation time of each band, s: 24 ln(10) V / (c (4 m V - S ln(1 - a))), infinite
/// without loss.
Bands eyring_time_s(double volume_m3, double surface_m2, const Bands& mean_absorption,
                    const Bands& attenuation_per_m, double speed_of_sound_m_s);

}  // namespace aula
