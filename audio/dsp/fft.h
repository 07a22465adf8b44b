#pragma once

#include <complex>
#include <cstddef>
#include <memory>

namespace aula {

/// Real discrete Fourier transform of one size, for the design of filters; the convolver has its
/// own (block_transform.h). An object may be used by one thread at a time; objects are independent
/// of each other.
class RealFft {
 public:
    /// `size` is one of those that fast_fft_size() gives.
    explicit RealFft(std::size_t size);
    ~RealFft();

    std::size_t size() const { return size_; }
    std::size_t bins() const { return size_ / 2 + 1; }

    /// spectrum[k] = sum over n of signal[n] exp(-2 pi i k n / size), bins() of them.
    void forward(const float* signal, std::complex<float>* spectrum);

    /// The inverse without its factor 1 / size.
    void inverse(const std::complex<float>* spectrum, float* signal);

 private:
    struct Plans;

    std::size_t size_;
    std::unique_ptr<Plans> plans_;
};

/// The smallest number of at least `size` that is twice one whose prime factors are 2, 3 and 5.
std::size_t fast_fft_size(std::size_t size);

}  // namespace aula
