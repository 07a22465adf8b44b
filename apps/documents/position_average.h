#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "aula/measurement.h"

namespace aula {

/// Mean and standard deviation over positions, as ISO 3382-2 asks of a room: over pairs of a source
/// and a receiver. Values that are not known are left out; levels are averaged in dB.
struct PositionAverage {
    /// Without standard errors: the pairs of a source share its rays, and are not independent.
    PairParameters mean;
    PairParameters deviation;  ///< standard deviations of the sample; none of a single value
    PairParameters counts;     ///< numbers of pairs that have the value; empty: none
    std::size_t positions = 0;
};

PositionAverage average_over_positions(std::span<const PairParameters* const> all);

/// The parameters of all audible pairs of which `in_room`, [pair], is not 0.
std::vector<const PairParameters*> audible_parameters(const Measurement& measurement,
                                                      std::span<const char> in_room);

}  // namespace aula
