#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "aula/engine/energy_response.h"
#include "engine/response/decay_curve.h"

namespace aula {

/// The modulation transfer function of a band at a modulation frequency, 0..1: the magnitude of the
/// Fourier transform of the energy response over its total (Schroeder 1981). For an exponential
/// decay of reverberation time T it is 1 / sqrt(1 + (2 pi F T / (6 ln 10))^2). Requires energy.
double modulation_transfer(const EnergyResponse& response, std::size_t band, double modulation_hz);

/// The same of a measured decay, with its tail.
double modulation_transfer(const SampledDecay& decay, double modulation_hz);

/// Sound pressure levels in dB at the receiver, of speech with its reverberation and of noise.
struct ReceivedLevels {
    Bands speech_db;
    std::optional<Bands> noise_db;  ///< absent: no noise
};

/// The levels in dB at the receiver of a source that has `source_db` at 1 m in free field, or that
/// an omnidirectional source of the same power has; -infinite without energy.
Bands received_db(const EnergyResponse& response, const Bands& source_db);

/// The octaves of the speech transmission index, from that of 125 Hz on.
inline constexpr std::size_t kSpeechOctaves = 7;

/// The modulation frequencies of the speech transmission index, Hz.
inline constexpr std::array<double, 14> kModulations_hz{0.63, 0.8, 1, 1.25, 1.6, 2,  2.5,
                                                        3.15, 4,   5, 6.3,  8,   10, 12.5};

/// Modulation transfer functions, [octave from 125 Hz on][modulation frequency], 0..1.
using ModulationTransfers = std::array<std::array<double, kModulations_hz.size()>, kSpeechOctaves>;

/// The speech transmission index by IEC 60268-16:2011, 0..1, male weights. With levels auditory
/// masking, noise and the reception threshold count; without them the modulation transfer of the
/// response alone does.
double speech_transmission_index(const ModulationTransfers& transfers,
                                 const std::optional<ReceivedLevels>& levels);

/// The qualification band of a speech transmission index (IEC 60268-16:2011, annex F): "A+", "A" to
/// "J", "U".
std::string_view speech_class(double index);

/// The rating of a speech transmission index (ISO 9921, annex F): "bad", "poor", "fair", "good" or
/// "excellent".
std::string_view speech_rating(double index);

/// Half of the last digit of an index with two decimals.
inline constexpr double kSpeechIndexRounding = 0.005;

/// What `name_of`, speech_class or speech_rating, gives of all indices within `margin` of one, such
/// as "fair" or "poor to fair".
std::string speech_name(double index, double margin, std::string_view (*name_of)(double));

/// The speech transmission index by IEC 60268-16:2011, 0..1, male weights, with auditory masking
/// and the reception threshold. `speech_db` are sound pressure levels at 1 m in free field, of an
/// omnidirectional source of the same power; `noise_db` are levels at the receiver, absent: no
/// noise. The band of 63 Hz is not used. Empty if an octave from 125 Hz on has no energy.
std::optional<double> speech_transmission_index(const EnergyResponse& response,
                                                const Bands& speech_db,
                                                const std::optional<Bands>& noise_db);

}  // namespace aula
