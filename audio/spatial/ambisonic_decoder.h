#pragma once

#include <cstddef>

#include "audio/spatial/head_responses.h"
#include "audio/spatial/hrtf.h"

namespace aula {

/// Additional delay of decoded sound re sound filtered by the head responses directly. The
/// decoder's filters ring before their peak, too.
std::size_t decoder_lead_samples(double sample_rate_hz);

/// Error criterion of the decoder.
enum class DecoderDesign {
    /// Complex least squares at all frequencies: loses treble and interaural differences. For
    /// comparison.
    least_squares,
    /// Complex least squares below a cutoff frequency, magnitude least squares (MagLS) above it,
    /// and the diffuse-field covariance of the ears equalised to that of the head responses.
    magnitudes
};

/// Designs the binaural decoder of an ambisonic field of order 1 to 3 (ACN, SN3D, head axes) after
/// Schoerkhuber, Zaunschirm and Hoeldrich, "Binaural Rendering of Ambisonic Signals via Magnitude
/// Least Squares", DAGA 2018. The filters are 1.5 times as long as the head responses. Their delay
/// re the centre of the head is centre_delay_s() plus the lead. Takes about 0.2 s.
AmbisonicDecoder design_decoder(const HeadResponses& head, int order,
                                DecoderDesign design = DecoderDesign::magnitudes);

}  // namespace aula
