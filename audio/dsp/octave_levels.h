#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "audio/base/aligned.h"

namespace aula {

/// Gives short filters the energies of their gains in the low octaves, which are narrow beside the
/// resolution of the filters: sample rate / taps. [one thread]
class OctaveLevels {
 public:
    OctaveLevels(double sample_rate_hz, std::size_t taps);

    /// Changes the response, `taps` samples, as little as possible until the mean of its squared
    /// magnitude over each narrow octave is the squared gain. Gains below -60 dB re the greatest
    /// are raised to it. Returns the largest error of a narrow octave that is left, dB.
    float correct(const std::array<float, 8>& gains, std::span<float> response);

 private:
    struct Octave {
        std::size_t first_row;
        std::size_t end_row;
    };

    /// Sets energies and gradients; returns the largest error, dB.
    float measure(const std::array<float, 8>& energies, std::span<const float> response);
    void step(std::span<float> response);

    std::size_t taps_;
    std::vector<Octave> octaves_;  ///< the narrow ones, from the lowest
    /// [row][tap] Weighted cosines and sines: the energy of an octave is the sum over its rows of
    /// the squared products with the response.
    AlignedVector<float> rows_;
    std::vector<double> wanted_;      ///< [octave] natural logarithms of wanted over present
    std::vector<double> energy_;      ///< [octave]
    AlignedVector<float> gradients_;  ///< [octave][tap] half of the gradient of the energy
    AlignedVector<float> best_;       ///< the response of the smallest error
    std::vector<double> normal_;      ///< [octave][octave], normal equations of a step
};

}  // namespace aula
