#pragma once

#include <cstddef>
#include <vector>

#include "aula/engine/bands.h"

namespace aula {

/// Pulses are added by linear interpolation at kFiner times the sample rate: at half the sample
/// rate its error is (pi / kFiner)^2 / 8, -46 dB.
constexpr std::size_t kFiner = 16;
/// Length of the filter back to the sample rate, samples: a sinc with a Hann window.
constexpr std::size_t kPulseTaps = 32;

/// Signals at kFiner times the sample rate, filtered to the sample rate. Sample 0 of the result is
/// sample kPulseTaps * kFiner / 2 of the signal.
std::vector<float> coarser(const std::vector<float>& finer, std::size_t samples);
std::vector<Bands> coarser(const std::vector<Bands>& finer, std::size_t samples);

/// The sum of signals in octaves, [sample].
std::vector<float> joined(const std::vector<Bands>& octaves, double sample_rate_hz);

}  // namespace aula
