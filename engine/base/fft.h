#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <vector>

namespace aula {

/// Complex discrete Fourier transform of sizes without prime factors above 5, with the same result
/// on every instruction set. Copies share the table of factors. [one thread at a time per object]
class Fft {
 public:
    /// `size` is one that fast_size() returns.
    explicit Fft(std::size_t size);

    /// The smallest multiple of `multiple`, a power of two, that is at least `least` and has no
    /// prime factors above 5.
    static std::size_t fast_size(std::size_t least, std::size_t multiple);

    std::size_t size() const { return twiddles_->size(); }

    /// X[k] = sum over n of x[n] exp(-2 pi i k n / size), in place: size() real parts, and as many
    /// imaginary ones. Of several signals sample n of the signal i is x[n signals + i]; each has
    /// the result that it has alone.
    void forward(std::vector<float>& real, std::vector<float>& imaginary);

    /// The inverse without the factor 1 / size, in place.
    void inverse(std::vector<float>& real, std::vector<float>& imaginary) {
        forward(imaginary, real);
    }

 private:
    std::vector<std::size_t> radices_;
    std::shared_ptr<const std::vector<std::complex<float>>> twiddles_;  ///< exp(-2 pi i k / size)
    std::vector<float> real_, imaginary_;                               ///< work space
};

}  // namespace aula
