#include "audio/fft.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace aula {

namespace {

using Complex = std::complex<float>;

[[maybe_unused]] bool is_aligned(const void* p) {
    return reinterpret_cast<std::uintptr_t>(p) % kAlignment_bytes == 0;
}

/// exp(-2 pi i numerator / denominator)
Complex root(std::size_t numerator, std::size_t denominator) {
    return Complex(
        std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(numerator % denominator) /
                            static_cast<double>(denominator)));
}

// The operators of std::complex look after infinities, which costs more than the products.
Complex times(const Complex& a, const Complex& b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// Of transforms of kRadix points the one of a[0], a[1], ...
template <std::size_t kRadix>
void transform(std::array<Complex, kRadix>& a, const std::array<Complex, kRadix>& roots) {
    if constexpr (kRadix == 2) {
        a = {a[0] + a[1], a[0] - a[1]};
    } else if constexpr (kRadix == 4) {
        const Complex sum_0 = a[0] + a[2], difference_0 = a[0] - a[2];
        const Complex sum_1 = a[1] + a[3], difference_1 = a[1] - a[3];
        const Complex turned(difference_1.imag(), -difference_1.real());
        a = {sum_0 + sum_1, difference_0 + turned, sum_0 - sum_1, difference_0 - turned};
    } else {
        std::array<Complex, kRadix> sums;
        for (std::size_t k = 0; k < kRadix; ++k) {
            sums[k] = a[0];
            for (std::size_t j = 1; j < kRadix; ++j) sums[k] += times(a[j], roots[j * k % kRadix]);
        }
        a = sums;
    }
}

/// One pass of Stockham's transform, which sorts itself on the way: `stride` transforms of
/// `size` points each, of which the factor kRadix is done.
template <std::size_t kRadix>
void pass(const Complex* in, const Complex* twiddles, std::size_t size, std::size_t stride,
          Complex* out) {
    std::array<Complex, kRadix> roots;
    for (std::size_t k = 0; k < kRadix; ++k) roots[k] = root(k, kRadix);
    const std::size_t part = size / kRadix;
    for (std::size_t p = 0; p < part; ++p) {
        const Complex* const w = twiddles + p * (kRadix - 1);
        for (std::size_t q = 0; q < stride; ++q) {
            std::array<Complex, kRadix> a;
            for (std::size_t j = 0; j < kRadix; ++j) a[j] = in[q + stride * (p + part * j)];
            transform(a, roots);
            Complex* const to = out + q + stride * kRadix * p;
            to[0] = a[0];
            for (std::size_t k = 1; k < kRadix; ++k) to[stride * k] = times(a[k], w[k - 1]);
        }
    }
}

}  // namespace

RealFft::RealFft(std::size_t size)
    : size_(size), work_{AlignedVector<Complex>(size / 2), AlignedVector<Complex>(size / 2)} {
    assert(size >= 2 && size % 2 == 0);
    std::size_t left = size / 2;
    for (const std::size_t radix : {4U, 2U, 3U, 5U}) {
        while (left > 1 && left % radix == 0) {
            Pass next{radix, {}};
            for (std::size_t p = 0; p < left / radix; ++p) {
                for (std::size_t k = 1; k < radix; ++k) {
                    next.twiddles.push_back(root(p * k, left));
                }
            }
            passes_.push_back(std::move(next));
            left /= radix;
        }
    }
    assert(left == 1);
    for (std::size_t k = 0; k <= size / 4; ++k) turns_.push_back(root(k, size));
}

/// The transform of the size / 2 points in work_[0]; where the result lies.
Complex* RealFft::transform_halves() noexcept {
    Complex* in = work_[0].data();
    Complex* out = work_[1].data();
    std::size_t size = size_ / 2;
    std::size_t stride = 1;
    for (const Pass& next : passes_) {
        const Complex* const w = next.twiddles.data();
        switch (next.radix) {
            case 2:
                pass<2>(in, w, size, stride, out);
                break;
            case 3:
                pass<3>(in, w, size, stride, out);
                break;
            case 4:
                pass<4>(in, w, size, stride, out);
                break;
            default:
                pass<5>(in, w, size, stride, out);
        }
        size /= next.radix;
        stride *= next.radix;
        std::swap(in, out);
    }
    return in;
}

// With Z the transform of z[n] = signal[2n] + i signal[2n + 1], M = size / 2 and Z[M] = Z[0]: the
// even samples have E[k] = (Z[k] + conj Z[M - k]) / 2, the odd ones O[k] = (Z[k] - conj Z[M - k]) /
// 2i, and spectrum[k] = E[k] + w^k O[k], w = exp(-2 pi i / size). With conj it is that of M - k.
void RealFft::forward(const float* signal, Complex* spectrum) noexcept {
    assert(is_aligned(signal) && is_aligned(spectrum));
    const std::size_t half = size_ / 2;
    for (std::size_t n = 0; n < half; ++n) work_[0][n] = {signal[2 * n], signal[2 * n + 1]};
    const Complex* const z = transform_halves();
    for (std::size_t k = 0; k <= half / 2; ++k) {
        const Complex a = z[k];
        const Complex b = std::conj(z[k == 0 ? 0 : half - k]);
        const Complex even = 0.5F * (a + b);
        const Complex difference = 0.5F * (a - b);
        const Complex odd = times({difference.imag(), -difference.real()}, turns_[k]);
        spectrum[half - k] = std::conj(even - odd);
        spectrum[k] = even + odd;
    }
}

// Backwards: Z[k] = E[k] + i O[k], each twice as large here; the inverse transform is the forward
// one between conjugations.
void RealFft::inverse(Complex* spectrum, float* signal) noexcept {
    assert(is_aligned(signal) && is_aligned(spectrum));
    const std::size_t half = size_ / 2;
    // What has no imaginary part in the spectrum of real samples.
    spectrum[0] = spectrum[0].real();
    spectrum[half] = spectrum[half].real();
    for (std::size_t k = 0; k <= half / 2; ++k) {
        const Complex a = spectrum[k];
        const Complex b = std::conj(spectrum[half - k]);
        const Complex even = a + b;
        const Complex odd = times(a - b, std::conj(turns_[k]));
        const Complex turned(-odd.imag(), odd.real());
        if (k > 0) work_[0][half - k] = even - turned;
        work_[0][k] = std::conj(even + turned);
    }
    const Complex* const z = transform_halves();
    for (std::size_t n = 0; n < half; ++n) {
        signal[2 * n] = z[n].real();
        signal[2 * n + 1] = -z[n].imag();
    }
}

std::size_t fast_fft_size(std::size_t size) {
    for (std::size_t n = size + size % 2;; n += 2) {
        std::size_t rest = n;
        for (const std::size_t factor : {2U, 3U, 5U}) {
            while (rest > 1 && rest % factor == 0) rest /= factor;
        }
        if (rest == 1) return n;
    }
}

}  // namespace aula
