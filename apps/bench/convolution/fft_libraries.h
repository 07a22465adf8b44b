#pragma once

#include <complex>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace aula::bench {

/// A real transform of one size and its inverse, without factors. Buffers are aligned to
/// kAlignment_bytes; the inverse may overwrite its input.
struct FftPair {
    std::function<void(const float* signal, std::complex<float>* spectrum)> forward;
    std::function<void(std::complex<float>* spectrum, float* signal)> inverse;
};

/// An FFT library.
struct FftLibrary {
    std::string name;
    std::function<FftPair(std::size_t size)> plan;
};

/// KissFFT, and FFTW if it was found at build time.
std::vector<FftLibrary> fft_libraries();

}  // namespace aula::bench
