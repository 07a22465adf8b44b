#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <vector>

namespace aula {

/// Rounds samples to integers of 16 or 24 bits, with triangular dither of two steps' width (TPDF).
/// Mean and variance of the total error are then those of the dither and of a uniform error,
/// whatever the signal (Lipshitz, Wannamaker and Vanderkooy 1992). The
/// same seed gives the same dither. [one thread]
class SampleQuantizer {
 public:
    /// `bits`: 2 to 32, of the integers. An empty seed: rounding without dither.
    SampleQuantizer(int bits, std::optional<std::uint64_t> dither_seed);

    /// Replaces `integers` by the rounded samples, in the upper bits. Full scale is 1; samples
    /// beyond it are clipped. Samples are finite.
    void quantize(std::span<const float> samples, std::vector<int>& integers);

 private:
    double dither_steps();

    double full_scale_steps_;
    int step_;  ///< of the integers
    std::optional<std::mt19937_64> random_;
};

}  // namespace aula
