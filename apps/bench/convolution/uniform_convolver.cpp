#include "apps/bench/convolution/uniform_convolver.h"

#include <algorithm>
#include <cassert>

namespace aula::bench {

UniformConvolver::UniformConvolver(const FftLibrary& library, std::size_t inputs,
                                   std::size_t outputs, std::size_t block, std::size_t taps)
    : inputs_(inputs),
      outputs_(outputs),
      block_(block),
      partitions_((taps + block - 1) / block),
      fft_(library.plan(2 * block)),
      windows_(inputs, AlignedVector<float>(2 * block, 0)),
      history_(inputs * partitions_, Spectrum(block + 1)),
      filters_(inputs * outputs * partitions_, Spectrum(block + 1)),
      sum_(block + 1),
      signal_(2 * block) {}

void UniformConvolver::set_filter(std::size_t input, std::size_t output,
                                  std::span<const float> taps) {
    assert(taps.size() <= partitions_ * block_);
    for (std::size_t p = 0; p < partitions_; ++p) {
        std::fill(signal_.begin(), signal_.end(), 0.0F);
        for (std::size_t n = p * block_; n < std::min(taps.size(), (p + 1) * block_); ++n) {
            signal_[n - p * block_] = taps[n] / static_cast<float>(2 * block_);
        }
        fft_.forward(signal_.data(), filters_[(output * inputs_ + input) * partitions_ + p].data());
    }
}

void UniformConvolver::process(std::span<const float* const> inputs,
                               std::span<float* const> outputs) {
    newest_ = (newest_ + partitions_ - 1) % partitions_;
    for (std::size_t i = 0; i < inputs_; ++i) {
        AlignedVector<float>& window = windows_[i];
        std::copy(window.begin() + static_cast<std::ptrdiff_t>(block_), window.end(),
                  window.begin());
        std::copy_n(inputs[i], block_, window.begin() + static_cast<std::ptrdiff_t>(block_));
        fft_.forward(window.data(), history_[i * partitions_ + newest_].data());
    }
    for (std::size_t o = 0; o < outputs_; ++o) {
        std::fill(sum_.begin(), sum_.end(), 0.0F);
        for (std::size_t i = 0; i < inputs_; ++i) {
            for (std::size_t p = 0; p < partitions_; ++p) {
                const Spectrum& x = history_[i * partitions_ + (newest_ + p) % partitions_];
                const Spectrum& h = filters_[(o * inputs_ + i) * partitions_ + p];
                for (std::size_t k = 0; k < sum_.size(); ++k) {
                    // Written out: the operator of std::complex also handles infinities.
                    sum_[k] +=
                        std::complex<float>(x[k].real() * h[k].real() - x[k].imag() * h[k].imag(),
                                            x[k].real() * h[k].imag() + x[k].imag() * h[k].real());
                }
            }
        }
        fft_.inverse(sum_.data(), signal_.data());
        // The first half contains circular aliasing: overlap-save keeps the second half.
        std::copy_n(signal_.begin() + static_cast<std::ptrdiff_t>(block_), block_, outputs[o]);
    }
}

}  // namespace aula::bench
