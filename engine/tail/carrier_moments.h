#pragma once

#include <cstdint>
#include <span>

namespace aula {

/// Sums over the samples c of a carrier, in steps of its quantisation: of c^2, c^2 t and c^2 t^2,
/// and of the product with another carrier. t is the time in the unit of the envelope.
struct CarrierMoments {
    double zeroth = 0, first = 0, second = 0, product = 0;

    /// Adds samples; t is `begin` at the first one and rises by `step`.
    void add(std::span<const std::int16_t> carrier, const std::int16_t* other, float begin,
             float step);
};

}  // namespace aula
