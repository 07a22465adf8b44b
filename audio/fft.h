#pragma once

#include <complex>
#include <cstddef>
#include <memory>

#include "audio/realtime.h"

namespace aula {

/// Real discrete Fourier transform of one size, planned in the constructor and executed without
/// allocating. Buffers must be aligned to kAlignment_bytes. An object may be used by one thread at
/// a time; objects are independent of each other.
class RealFft {
 public:
    /// `size` is even; fast_fft_size() gives sizes that transform quickly and never allocate.
    explicit RealFft(std::size_t size);
    ~RealFft();
    RealFft(RealFft&&) noexcept;
    RealFft& operator=(RealFft&&) noexcept;

    std::size_t size() const { return size_; }
    std::size_t bins() const { return size_ / 2 + 1; }

    /// spectrum[k] = sum over n of signal[n] exp(-2 pi i k n / size), bins() of them.
    void forward(const float* signal, std::complex<float>* spectrum) noexcept AULA_NONBLOCKING;

    /// The inverse without its factor 1 / size; overwrites `spectrum` as well.
    void inverse(std::complex<float>* spectrum, float* signal) noexcept AULA_NONBLOCKING;

 private:
    struct Plans;
    std::size_t size_;
    std::unique_ptr<Plans> plans_;
};

/// The smallest even number of at least `size` whose prime factors are 2, 3 and 5.
std::size_t fast_fft_size(std::size_t size);

}  // namespace aula
