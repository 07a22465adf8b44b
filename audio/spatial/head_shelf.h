#pragma once

#include <span>

#include "aula/audio/realtime.h"

namespace aula {

/// A first-order shelf: what a near source changes at an ear of a rigid sphere, re a source at a
/// reference distance that has the same level at the centre of the head.
struct HeadShelf {
    float low_db = 0;   ///< gain at low frequencies
    float high_db = 0;  ///< gain at high frequencies
    float corner_hz = 1000;

    /// The shelf of a source at `distance_m` from the centre, by the cosine of the angle between
    /// source and ear. 0 dB from the reference on; nearer than 0.12 m that of 0.12 m.
    static HeadShelf at(float distance_m, float reference_m,
                        float cosine) noexcept AULA_NONBLOCKING;

    /// Filters a response in place. [audio thread, wait-free]
    void apply(double sample_rate_hz, std::span<float> response) const noexcept AULA_NONBLOCKING;
};

}  // namespace aula
