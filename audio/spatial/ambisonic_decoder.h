#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "audio/spatial/head_responses.h"

namespace aula {

/// Filters from ambisonic channels to the ears: [ear][channel][sample].
using AmbisonicDecoder = std::array<std::vector<std::vector<float>>, 2>;

/// How much later decoded sound comes than sound rendered by the responses: filters without a phase
/// of their own ring before their peak as well as behind it.
std::size_t decoder_lead_samples(double sample_rate_hz);

/// What the ears are given of a field that the order cannot render exactly.
enum class DecoderDesign {
    /// Least squares at all frequencies: loses treble and separation of the ears. For comparison.
    least_squares,
    /// Least squares where the order follows the delays between the ears, of magnitudes above, and
    /// in a diffuse field each ear's level and both ears' coherence as the responses give them.
    magnitudes
};

/// Filters that give both ears of an ambisonic field of an order (1 to 3; ACN, SN3D, head axes)
/// what the responses give them (Schoerkhuber, Zaunschirm and Hoeldrich, "Binaural Rendering of
/// Ambisonic Signals via Magnitude Least Squares", DAGA 2018), half again as long as these. A wave
/// that passes the middle of the head is heard centre_delay_s() and the lead
/// later. Takes a fifth
/// of a second.
AmbisonicDecoder design_decoder(const HeadResponses& head, int order,
                                DecoderDesign design = DecoderDesign::magnitudes);

}  // namespace aula
