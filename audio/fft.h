#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <vector>

#include "audio/aligned.h"
#include "audio/realtime.h"

namespace aula {

/// Real discrete Fourier transform of one size, for the design of filters; the convolver has its
/// own (block_transform.h). Executed without allocating. Buffers must be aligned to
/// kAlignment_bytes. An object may be used by one thread at a time; objects are independent of each
/// other.
class RealFft {
 public:
    /// `size` is one of those that fast_fft_size() gives.
    explicit RealFft(std::size_t size);

    std::size_t size() const { return size_; }
    std::size_t bins() const { return size_ / 2 + 1; }

    /// spectrum[k] = sum over n of signal[n] exp(-2 pi i k n / size), bins() of them.
    void forward(const float* signal, std::complex<float>* spectrum) noexcept AULA_NONBLOCKING;

    /// The inverse without its factor 1 / size; may overwrite parts of `spectrum` as well.
    void inverse(std::complex<float>* spectrum, float* signal) noexcept AULA_NONBLOCKING;

 private:
    struct Pass {
        std::size_t radix;
        std::vector<std::complex<float>> twiddles;
    };
    std::complex<float>* transform_halves() noexcept AULA_NONBLOCKING;

    std::size_t size_;
    std::vector<Pass> passes_;
    std::vector<std::complex<float>> turns_;  ///< exp(-2 pi i k / size), a quarter of them
    std::array<AlignedVector<std::complex<float>>, 2> work_;
};

/// The smallest even number of at least `size` whose prime factors are 2, 3 and 5.
std::size_t fast_fft_size(std::size_t size);

}  // namespace aula
