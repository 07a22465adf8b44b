#pragma once

#include <array>
#include <optional>

#include "aula/engine/energy_response.h"
#include "aula/engine/medium.h"
#include "aula/engine/third_octaves.h"

namespace aula {

/// ISO 3382-1 parameters of one octave band. A parameter is empty if the decay of the response is
/// not sufficient for it (see room_parameters()). No value is NaN or infinite.
struct BandParameters {
    std::optional<double> t20_s;   ///< T20: reverberation time by the decay from -5 to -25 dB
    std::optional<double> t30_s;   ///< T30: reverberation time by the decay from -5 to -35 dB
    std::optional<double> edt_s;   ///< early decay time: by the decay from 0 to -10 dB
    std::optional<double> c50_db;  ///< clarity C50: energy of the first 50 ms re that after them
    std::optional<double> c80_db;  ///< clarity C80: energy of the first 80 ms re that after them
    std::optional<double> d50;     ///< definition D50: energy of the first 50 ms re the total, 0..1
    std::optional<double> ts_s;    ///< centre time Ts: mean time, weighted with the energy
    std::optional<double> g_db;    ///< strength G: total re the free field at 10 m, 1/(400 pi) 1/m2
};

/// The parameters of a response, [band].
using RoomParameters = std::array<BandParameters, kBandCount>;

/// The parameters of an energy response by ISO 3382-1. Time zero is the arrival of the direct
/// sound, also around edges, if it is among the paths, otherwise the first arrival. The decay curve
/// is Schroeder's backward integral. The tail after the end of the response is estimated from the
/// late slope and included. A decay time is empty unless the curve at -25 dB (T20), -35 dB (T30) or
/// -10 dB (EDT) is 10 dB above the tail. The other parameters are empty unless the total is 10 dB
/// above the tail.
RoomParameters room_parameters(const EnergyResponse& response);

/// The parameters of a response, [third octave].
using ThirdOctaveParameters = std::array<BandParameters, kThirdOctaveCount>;

/// The same in third octaves, from the octaves of the response and its medium: the loss by surfaces
/// in dB is interpolated linearly in the logarithm of the frequency, that by air is exact. The
/// energy of a third octave is the mean over it.
ThirdOctaveParameters third_octave_parameters(const EnergyResponse& response, const Medium& medium);

/// Strength in dB below which a source is not audible: 60 dB below its level at 1 m. A voice of
/// 60 dB at 1 m (ISO 9921, normal effort) then has 0 dB, the threshold of hearing.
inline constexpr double kAudible_g_db = -40;

/// True if the strength of any octave band is at least kAudible_g_db.
bool is_audible(const EnergyResponse& response);

/// Sabine's reverberation time of each band in s: 6 ln(10) / (c (m + a / l)), infinite without
/// loss. l is `mean_free_path_m`, 4 V / S in a diffuse field (Kuttruff, Room Acoustics), a
/// `mean_absorption` (0..1), m `attenuation_per_m` (see Medium), c `speed_of_sound_m_s`. l and c
/// are above 0.
Bands sabine_time_s(double mean_free_path_m, const Bands& mean_absorption,
                    const Bands& attenuation_per_m, double speed_of_sound_m_s);

/// Eyring's reverberation time of each band in s: 6 ln(10) / (c (m - ln(1 - a) / l)), infinite
/// without loss, with the symbols of sabine_time_s().
Bands eyring_time_s(double mean_free_path_m, const Bands& mean_absorption,
                    const Bands& attenuation_per_m, double speed_of_sound_m_s);

}  // namespace aula
