#pragma once

#include <optional>

#include "aula/engine/energy_response.h"

namespace aula {

/// The modulation transfer function of a band at a modulation frequency, 0..1: the magnitude of the
/// Fourier transform of the energy response over its total (Schroeder 1981). For an exponential
/// decay of reverberation time T it is 1 / sqrt(1 + (2 pi F T / (6 ln 10))^2). Requires energy.
double modulation_transfer(const EnergyResponse& response, std::size_t band, double modulation_hz);

/// The speech transmission index by IEC 60268-16:2011, 0..1, male weights, with auditory masking
/// and the reception threshold. `speech_db` are sound pressure levels at 1 m in free field, of an
/// omnidirectional source of the same power; `noise_db` are levels at the receiver, absent: no
/// noise. The band of 63 Hz is not used. Empty if an octave from 125 Hz on has no energy.
std::optional<double> speech_transmission_index(const EnergyResponse& response,
                                                const Bands& speech_db,
                                                const std::optional<Bands>& noise_db);

}  // namespace aula
