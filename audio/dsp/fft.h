#pragma once

#include <complex>
#include <cstddef>
#include <memory>

namespace aula {

/// Real discrete Fourier transform of a fixed size, for filter design (the convolver uses
/// block_transform.h). [one thread at a time per object]
class RealFft {
 public:
    /// `size` is one that fast_fft_size() returns.
    explicit RealFft(std::size_t size);
    ~RealFft();

    std::size_t size() const { return size_; }
    std::size_t bins() const { return size_ / 2 + 1; }

    /// spectrum[k] = sum over n of signal[n] exp(-2 pi i k n / size), k < bins().
    void forward(const float* signal, std::complex<float>* spectrum);

    /// The inverse without the factor 1 / size.
    void inverse(const std::complex<float>* spectrum, float* signal);

 private:
    struct Plans;

    std::size_t size_;
    std::unique_ptr<Plans> plans_;
};

/// The smallest even number >= `size` whose half has no prime factors other than 2, 3 and 5.
std::size_t fast_fft_size(std::size_t size);

}  // namespace aula
