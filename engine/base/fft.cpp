#include "engine/base/fft.h"

#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
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

/// Values that are computed together.
using Sixteen = float __attribute__((vector_size(16 * sizeof(float))));
using Four = float __attribute__((vector_size(4 * sizeof(float))));

/// The transform of R values, in place.
template <std::size_t R, typename V>
[[gnu::always_inline]] inline void transform(std::array<V, R>& a, std::array<V, R>& b) {
    constexpr float kSine60 = 0.86602540F;
    constexpr float kCosine72 = 0.30901699F, kCosine144 = -0.80901699F;
    constexpr float kSine72 = 0.95105652F, kSine144 = 0.58778525F;
    if constexpr (R == 2) {
        a = {a[0] + a[1], a[0] - a[1]};
        b = {b[0] + b[1], b[0] - b[1]};
    } else if constexpr (R == 3) {
        const V s = a[1] + a[2], t = b[1] + b[2];
        const V m = a[0] - 0.5F * s, n = b[0] - 0.5F * t;
        const V d = kSine60 * (a[1] - a[2]), e = kSine60 * (b[1] - b[2]);
        a = {a[0] + s, m + e, m - e};
        b = {b[0] + t, n - d, n + d};
    } else if constexpr (R == 4) {
        const V s0 = a[0] + a[2], s1 = a[0] - a[2], s2 = a[1] + a[3], s3 = a[1] - a[3];
        const V t0 = b[0] + b[2], t1 = b[0] - b[2], t2 = b[1] + b[3], t3 = b[1] - b[3];
        a = {s0 + s2, s1 + t3, s0 - s2, s1 - t3};
        b = {t0 + t2, t1 - s3, t0 - t2, t1 + s3};
    } else {
        const V s1 = a[1] + a[4], s2 = a[2] + a[3], s3 = a[1] - a[4], s4 = a[2] - a[3];
        const V t1 = b[1] + b[4], t2 = b[2] + b[3], t3 = b[1] - b[4], t4 = b[2] - b[3];
        const V m1 = a[0] + kCosine72 * s1 + kCosine144 * s2;
        const V m2 = a[0] + kCosine144 * s1 + kCosine72 * s2;
        const V n1 = b[0] + kCosine72 * t1 + kCosine144 * t2;
        const V n2 = b[0] + kCosine144 * t1 + kCosine72 * t2;
        const V d1 = kSine72 * s3 + kSine144 * s4, d2 = kSine144 * s3 - kSine72 * s4;
        const V e1 = kSine72 * t3 + kSine144 * t4, e2 = kSine144 * t3 - kSine72 * t4;
        a = {a[0] + s1 + s2, m1 + e1, m2 + e2, m2 - e2, m1 - e1};
        b = {b[0] + t1 + t2, n1 - d1, n2 - d2, n2 + d2, n1 + d1};
    }
}

/// Where the values of a butterfly are: value q of input j at `in` + q + `in_step` j, that of
/// output k at `out` + q + `out_step` k.
struct Places {
    std::size_t in, in_step, out, out_step;
};

/// The butterflies of as many values as V has, from q on, with the factors of the outputs.
template <std::size_t R, typename V>
[[gnu::always_inline]] inline void butterfly(const Parts& in, const Parts& out, const Places& at,
                                             const std::array<std::complex<float>, R>& turn,
                                             std::size_t q) {
    std::array<V, R> a, b;
    for (std::size_t j = 0; j < R; ++j) {
        std::memcpy(&a[j], in.real + at.in + q + at.in_step * j, sizeof(V));
        std::memcpy(&b[j], in.imaginary + at.in + q + at.in_step * j, sizeof(V));
    }
    transform<R>(a, b);
    for (std::size_t k = 0; k < R; ++k) {
        const V real = turn[k].real() * a[k] - turn[k].imag() * b[k];
        const V imaginary = turn[k].real() * b[k] + turn[k].imag() * a[k];
        std::memcpy(out.real + at.out + q + at.out_step * k, &real, sizeof(V));
        std::memcpy(out.imaginary + at.out + q + at.out_step * k, &imaginary, sizeof(V));
    }
}

/// The pass of a Stockham transform by the radix R of several signals: `groups` butterflies of
/// `stride` columns, each of `signals` values.
template <std::size_t R>
[[gnu::always_inline]] inline void pass(const Parts& in, const Parts& out, std::size_t groups,
                                        std::size_t stride, std::size_t signals,
                                        const std::complex<float>* twiddles) {
    const std::size_t width = stride * signals;
    for (std::size_t p = 0; p < groups; ++p) {
        std::array<std::complex<float>, R> turn;
        for (std::size_t k = 0; k < R; ++k) turn[k] = twiddles[stride * p * k];
        const Places at{width * p, width * groups, width * R * p, width};
        std::size_t q = 0;
        for (; q + 16 <= width; q += 16) butterfly<R, Sixteen>(in, out, at, turn, q);
        for (; q + 4 <= width; q += 4) butterfly<R, Four>(in, out, at, turn, q);
        for (; q < width; ++q) butterfly<R, float>(in, out, at, turn, q);
    }
}

AULA_MULTIVERSION
void pass_of(std::size_t radix, const Parts& in, const Parts& out, std::size_t groups,
             std::size_t stride, std::size_t signals, const std::complex<float>* twiddles) {
    switch (radix) {
        case 2:
            pass<2>(in, out, groups, stride, signals, twiddles);
            break;
        case 3:
            pass<3>(in, out, groups, stride, signals, twiddles);
            break;
        case 4:
            pass<4>(in, out, groups, stride, signals, twiddles);
            break;
        default:
            pass<5>(in, out, groups, stride, signals, twiddles);
    }
}

}  // namespace

Fft::Fft(std::size_t size) {
    const std::size_t count = size;
    for (const std::size_t radix : {4U, 2U, 3U, 5U}) {
        for (; size % radix == 0; size /= radix) radices_.push_back(radix);
    }
    assert(size == 1);
    std::vector<std::complex<float>> twiddles(count);
    for (std::size_t k = 0; k < twiddles.size(); ++k) {
        const double angle =
            -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(twiddles.size());
        twiddles[k] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
    }
    twiddles_ = std::make_shared<const std::vector<std::complex<float>>>(std::move(twiddles));
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
    const std::size_t signals = real.size() / size();
    assert(real.size() == signals * size() && imaginary.size() == real.size());
    real_.resize(real.size());
    imaginary_.resize(real.size());
    std::size_t stride = 1;
    for (const std::size_t radix : radices_) {
        best_version<pass_of>(radix, Parts{real.data(), imaginary.data()},
                              Parts{real_.data(), imaginary_.data()}, size() / (stride * radix),
                              stride, signals, twiddles_->data());
        real.swap(real_);
        imaginary.swap(imaginary_);
        stride *= radix;
    }
}

}  // namespace aula
