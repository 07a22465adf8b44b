#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "audio/base/aligned.h"

namespace aula::bench {

inline constexpr double kConvolutionRate_hz = 48000;

/// A convolution of every source into every channel.
struct ConvolutionCase {
    std::size_t sources = 1;
    std::size_t channels = 1;
    double response_s = 1;
    std::size_t block = 128;

    std::size_t taps() const { return static_cast<std::size_t>(response_s * kConvolutionRate_hz); }
};

using ConvolutionFilters = std::vector<std::vector<std::vector<float>>>;  // [source][channel][tap]

/// One block of noise per source, and one block of output per channel.
struct ConvolutionSignals {
    ConvolutionSignals(const ConvolutionCase& c, std::uint64_t seed);

    std::vector<AlignedVector<float>> input_samples;
    std::vector<AlignedVector<float>> output_samples;
    std::vector<const float*> inputs;
    std::vector<float*> outputs;
};

/// Unrelated responses: noise that decays by 60 dB over its length.
ConvolutionFilters decaying_noise(const ConvolutionCase& c, std::uint64_t seed);

}  // namespace aula::bench
