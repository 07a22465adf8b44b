#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "apps/bench/convolution/fft_libraries.h"
#include "audio/base/aligned.h"

namespace aula::bench {

/// Uniformly partitioned convolution (overlap-save) in its plain form, as a baseline: per block one
/// spectrum of each input, one inverse transform of each output, and the sum of products over all
/// inputs and partitions. Each pair of input and output has a filter.
class UniformConvolver {
 public:
    UniformConvolver(const FftLibrary& library, std::size_t inputs, std::size_t outputs,
                     std::size_t block, std::size_t taps);

    /// Sets a filter of at most `taps` samples.
    void set_filter(std::size_t input, std::size_t output, std::span<const float> taps);

    /// Overwrites the outputs; one block.
    void process(std::span<const float* const> inputs, std::span<float* const> outputs);

 private:
    using Spectrum = AlignedVector<std::complex<float>>;

    std::size_t inputs_;
    std::size_t outputs_;
    std::size_t block_;
    std::size_t partitions_;
    FftPair fft_;
    std::vector<AlignedVector<float>> windows_;  ///< [input], the previous block and this one
    std::vector<Spectrum> history_;              ///< [input * partitions + ring index]
    std::vector<Spectrum> filters_;              ///< [(output * inputs + input) * partitions + age]
    std::size_t newest_ = 0;
    Spectrum sum_;
    AlignedVector<float> signal_;
};

}  // namespace aula::bench
