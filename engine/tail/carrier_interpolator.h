#pragma once

#include <cstddef>
#include <vector>

namespace aula {

/// Interpolates the sum of the low noise carriers to the full sample rate, by a windowed sinc of
/// kTaps samples per sample. Images are below -78 dB. Immutable.
class CarrierInterpolator {
 public:
    static constexpr std::size_t kTaps = 16;

    /// Samples that the input has before the first sample of the output, and after its last one.
    static constexpr std::size_t kBefore = kTaps / 2 - 1;
    static constexpr std::size_t kAfter = kTaps / 2;

    /// `decimation` is a power of two.
    explicit CarrierInterpolator(std::size_t decimation);

    /// Writes `count` times `decimation` samples. Sample n is at the time n / `decimation` of the
    /// input, counted from in[kBefore]; the input has `count` + kTaps - 1 samples.
    void process(const float* in, std::size_t count, float* out) const;

 private:
    std::size_t decimation_;
    std::size_t groups_;          ///< of phases that are computed together
    std::vector<float> weights_;  ///< [group][tap][phase]
};

}  // namespace aula
