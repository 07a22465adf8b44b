#include "engine/base/fft.h"

#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "process/multiversion.h"

namespace aula {
namespace {

/// Real and imaginary parts of a signal.
struct Parts {
    float* __restrict real;
    float* __restrict imaginary;
};

/// The pass of a Stockham transform by the radix R: `groups` butterflies of `stride` columns. The
/// column q of input j of butterfly p is at q + stride (p + groups j), that of output k at
/// q + stride (R p + k). `root` is exp(-2 pi i / R).
template <std::size_t R>
[[gnu::always_inline]] inline void pass(const Parts& in, const Parts& out, std::size_t groups,
                                        std::size_t stride, const std::complex<float>* twiddles) {
    std::array<std::complex<float>, R> root;
    for (std::size_t k = 0; k < R; ++k)
        root[k] = std::polar(1.0F, -2 * std::numbers::pi_v<float> * static_cast<float>(k) / R);
    for (std::size_t p = 0; p < groups; ++p) {
        std::array<std::complex<float>, R> turn;
        for (std::size_t k = 0; k < R; ++k) turn[k] = twiddles[stride * p * k];
        for (std::size_t q = 0; q < stride; ++q) {
            std::array<float, R> a, b;
            for (std::size_t j = 0; j < R; ++j) {
                a[j] = in.real[q + stride * (p + groups * j)];
                b[j] = in.imaginary[q + stride * (p + groups * j)];
            }
            std::array<float, R> c, d;
            if constexpr (R == 4) {
                const float s0 = a[0] + a[2], s1 = a[0] - a[2], s2 = a[1] + a[3], s3 = a[1] - a[3];
                const float t0 = b[0] + b[2], t1 = b[0] - b[2], t2 = b[1] + b[3], t3 = b[1] - b[3];
                c = {s0 + s2, s1 + t3, s0 - s2, s1 - t3};
                d = {t0 + t2, t1 - s3, t0 - t2, t1 + s3};
            } else {
                for (std::size_t k = 0; k < R; ++k) {
                    c[k] = a[0];
                    d[k] = b[0];
                    for (std::size_t j = 1; j < R; ++j) {
                        const std::complex<float> w = root[j * k % R];
                        c[k] += w.real() * a[j] - w.imag() * b[j];
                        d[k] += w.real() * b[j] + w.imag() * a[j];
                    }
                }
            }
            for (std::size_t k = 0; k < R; ++k) {
                const std::size_t to = q + stride * (R * p + k);
                out.real[to] = turn[k].real() * c[k] - turn[k].imag() * d[k];
                out.imaginary[to] = turn[k].real() * d[k] + turn[k].imag() * c[k];
            }
        }
    }
}

AULA_MULTIVERSION
void pass_of(std::size_t radix, const Parts& in, const Parts& out, std::size_t groups,
             std::size_t stride, const std::complex<float>* twiddles) {
    switch (radix) {
        case 2:
            pass<2>(in, out, groups, stride, twiddles);
            break;
        case 3:
            pass<3>(in, out, groups, stride, twiddles);
            break;
        case 4:
            pass<4>(in, out, groups, stride, twiddles);
            break;
        default:
            pass<5>(in, out, groups, stride, twiddles);
    }
}

}  // namespace

Fft::Fft(std::size_t size) : twiddles_(size), real_(size), imaginary_(size) {
    for (const std::size_t radix : {4U, 2U, 3U, 5U}) {
        for (; size % radix == 0; size /= radix) radices_.push_back(radix);
    }
    assert(size == 1);
    for (std::size_t k = 0; k < twiddles_.size(); ++k) {
        const double angle =
            -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(twiddles_.size());
        twiddles_[k] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
    }
}

std::size_t Fft::fast_size(std::size_t least, std::size_t multiple) {
    for (std::size_t size = (least + multiple - 1) / multiple * multiple;; size += multiple) {
        std::size_t rest = size;
        for (const std::size_t factor : {2U, 3U, 5U}) {
            while (rest % factor == 0) rest /= factor;
        }
        if (rest == 1) return size;
    }
}

void Fft::forward(std::vector<float>& real, std::vector<float>& imaginary) {
    assert(real.size() == size() && imaginary.size() == size());
    std::size_t stride = 1;
    for (const std::size_t radix : radices_) {
        best_version<pass_of>(radix, Parts{real.data(), imaginary.data()},
                              Parts{real_.data(), imaginary_.data()}, size() / (stride * radix),
                              stride, twiddles_.data());
        real.swap(real_);
        imaginary.swap(imaginary_);
        stride *= radix;
    }
}

}  // namespace aula
