// Compiled once for each instruction set: see spectral_loops.h.
#pragma once

#include <cstddef>

#include "audio/convolution/spectral_kernels.h"
#include "audio/convolution/spectral_vector.h"

namespace aula {

namespace {

struct Twiddle {
    float re;
    float im;
};

/// (re, im) times w, or times its conjugate.
template <typename V>
void multiply(V& re, V& im, const Twiddle& w) {
    const V old_re = re;
    re = old_re * w.re - im * w.im;
    im = old_re * w.im + im * w.re;
}
template <typename V>
void multiply_conjugate(V& re, V& im, const Twiddle& w) {
    const V old_re = re;
    re = old_re * w.re + im * w.im;
    im = im * w.re - old_re * w.im;
}

/// y_m = sum over p of a_p (-i)^(m p), in place.
template <typename V>
void butterfly_4(V (&re)[4], V (&im)[4]) {
    const V sum_0_re = re[0] + re[2], sum_0_im = im[0] + im[2];
    const V difference_0_re = re[0] - re[2], difference_0_im = im[0] - im[2];
    const V sum_1_re = re[1] + re[3], sum_1_im = im[1] + im[3];
    const V difference_1_re = im[1] - im[3], difference_1_im = re[3] - re[1];
    re[0] = sum_0_re + sum_1_re, im[0] = sum_0_im + sum_1_im;
    re[1] = difference_0_re + difference_1_re, im[1] = difference_0_im + difference_1_im;
    re[2] = sum_0_re - sum_1_re, im[2] = sum_0_im - sum_1_im;
    re[3] = difference_0_re - difference_1_re, im[3] = difference_0_im - difference_1_im;
}

/// The same with +i: swapping real and imaginary parts conjugates the coefficients.
template <typename V>
void butterfly_4_inverse(V (&re)[4], V (&im)[4]) {
    butterfly_4(im, re);
}

/// cos and -sin of 2 pi t / 16.
constexpr float kCos_8 = 0.923879532511286756F;
constexpr float kSin_8 = 0.382683432365089772F;
constexpr float kHalfRoot = 0.707106781186547524F;
constexpr Twiddle kSixteenth[10] = {
    {1, 0},  {kCos_8, -kSin_8},  {kHalfRoot, -kHalfRoot},  {kSin_8, -kCos_8},
    {0, -1}, {-kSin_8, -kCos_8}, {-kHalfRoot, -kHalfRoot}, {-kCos_8, -kSin_8},
    {-1, 0}, {-kCos_8, kSin_8}};

/// Transform of kSize <= 16 vectors, lane by lane, decimated in frequency. The results are in
/// digit-reversed order, which inverse_small expects.
template <std::size_t kSize, typename V>
[[gnu::always_inline]] inline void forward_small(V* re, V* im) {
    if constexpr (kSize == 2) {
        const V re_1 = re[0] - re[1], im_1 = im[0] - im[1];
        re[0] += re[1], im[0] += im[1];
        re[1] = re_1, im[1] = im_1;
    } else if constexpr (kSize >= 4) {
        constexpr std::size_t kQuarter = kSize / 4;
#pragma GCC unroll 4
        for (std::size_t j = 0; j < kQuarter; ++j) {
            V a[4] = {re[j], re[j + kQuarter], re[j + 2 * kQuarter], re[j + 3 * kQuarter]};
            V b[4] = {im[j], im[j + kQuarter], im[j + 2 * kQuarter], im[j + 3 * kQuarter]};
            butterfly_4(a, b);
#pragma GCC unroll 4
            for (std::size_t m = 0; m < 4; ++m) {
                if (m * j > 0) multiply(a[m], b[m], kSixteenth[m * j * 16 / kSize]);
                re[j + m * kQuarter] = a[m];
                im[j + m * kQuarter] = b[m];
            }
        }
#pragma GCC unroll 4
        for (std::size_t m = 0; m < 4; ++m) {
            forward_small<kQuarter>(re + m * kQuarter, im + m * kQuarter);
        }
    }
}

template <std::size_t kSize, typename V>
[[gnu::always_inline]] inline void inverse_small(V* re, V* im) {
    if constexpr (kSize == 2) {
        forward_small<2>(re, im);
    } else if constexpr (kSize >= 4) {
        constexpr std::size_t kQuarter = kSize / 4;
#pragma GCC unroll 4
        for (std::size_t m = 0; m < 4; ++m) {
            inverse_small<kQuarter>(re + m * kQuarter, im + m * kQuarter);
        }
#pragma GCC unroll 4
        for (std::size_t j = 0; j < kQuarter; ++j) {
            V a[4];
            V b[4];
#pragma GCC unroll 4
            for (std::size_t m = 0; m < 4; ++m) {
                a[m] = re[j + m * kQuarter];
                b[m] = im[j + m * kQuarter];
                if (m * j > 0) multiply_conjugate(a[m], b[m], kSixteenth[m * j * 16 / kSize]);
            }
            butterfly_4_inverse(a, b);
#pragma GCC unroll 4
            for (std::size_t m = 0; m < 4; ++m) {
                re[j + m * kQuarter] = a[m];
                im[j + m * kQuarter] = b[m];
            }
        }
    }
}

Vector<4> interleave_low(const Vector<4>& a, const Vector<4>& b) {
    return __builtin_shufflevector(a, b, 0, 4, 1, 5);
}
Vector<4> interleave_high(const Vector<4>& a, const Vector<4>& b) {
    return __builtin_shufflevector(a, b, 2, 6, 3, 7);
}
#if defined(__AVX2__)
Vector<8> interleave_low(const Vector<8>& a, const Vector<8>& b) {
    return __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11);
}
Vector<8> interleave_high(const Vector<8>& a, const Vector<8>& b) {
    return __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
}
#endif
#if defined(__AVX512F__)
Vector<16> interleave_low(const Vector<16>& a, const Vector<16>& b) {
    return __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
}
Vector<16> interleave_high(const Vector<16>& a, const Vector<16>& b) {
    return __builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15,
                                   31);
}
#endif

/// Transposes a square of lanes. Each round rotates the bits of the index (row, lane) left by one;
/// after log2(kLanes) rounds row and lane are swapped.
template <std::size_t kLanes>
[[gnu::always_inline]] inline void transpose(Vector<kLanes>* v) {
#pragma GCC unroll 4
    for (std::size_t round = 1; round < kLanes; round *= 2) {
        Vector<kLanes> rotated[kLanes];
#pragma GCC unroll 16
        for (std::size_t i = 0; i < kLanes / 2; ++i) {
            rotated[2 * i] = interleave_low(v[i], v[i + kLanes / 2]);
            rotated[2 * i + 1] = interleave_high(v[i], v[i + kLanes / 2]);
        }
#pragma GCC unroll 16
        for (std::size_t i = 0; i < kLanes; ++i) v[i] = rotated[i];
    }
}

/// Offset of a vector's real parts, floats; its imaginary parts follow kChunk_bins floats later.
template <std::size_t kLanes>
constexpr std::size_t vector_offset(std::size_t vector, std::size_t stride = kChunk_floats) {
    const std::size_t bin = vector * kLanes;
    return bin / kChunk_bins * stride + bin % kChunk_bins;
}

/// Twiddle factors of a radix-4 butterfly are stored as w^j, w^2j, w^3j, each real and imaginary.
Twiddle twiddle(const float* twiddles, std::size_t j, std::size_t m) {
    return {twiddles[6 * j + 2 * (m - 1)], twiddles[6 * j + 2 * (m - 1) + 1]};
}

template <std::size_t kLanes>
struct Transform {
    using V = Vector<kLanes>;

    struct Window {
        const float* older;
        const float* newer;  ///< null: zeros
        const float* weights;

        // (older + i newer) w
        [[gnu::always_inline]] void get(std::size_t vector, V& re, V& im) const {
            const float* const w = weights + vector_offset<kLanes>(vector);
            const V w_re = load<kLanes>(w);
            const V w_im = load<kLanes>(w + kChunk_bins);
            const V a = load_unaligned<kLanes>(older + vector * kLanes);
            re = a * w_re;
            im = a * w_im;
            if (newer == nullptr) return;
            const V b = load_unaligned<kLanes>(newer + vector * kLanes);
            re -= b * w_im;
            im += b * w_re;
        }
    };

    static void get(const float* p, V& re, V& im) {
        re = load<kLanes>(p);
        im = load<kLanes>(p + kChunk_bins);
    }
    static void put(const V& re, const V& im, float* p) {
        store<kLanes>(re, p);
        store<kLanes>(im, p + kChunk_bins);
    }

    static void forward_first(const float* older, const float* newer, const float* weights,
                              const float* twiddles, std::size_t vectors, bool radix_2,
                              std::size_t first, std::size_t last,
                              float* work) noexcept AULA_NONBLOCKING {
        if (newer == nullptr) {
            forward_first({older, nullptr, weights}, twiddles, vectors, radix_2, first, last, work);
        } else {
            forward_first({older, newer, weights}, twiddles, vectors, radix_2, first, last, work);
        }
    }

    [[gnu::always_inline]] static void forward_first(const Window& window, const float* twiddles,
                                                     std::size_t vectors, bool radix_2,
                                                     std::size_t first, std::size_t last,
                                                     float* work) {
        if (radix_2) {
            const std::size_t half = vectors / 2;
            for (std::size_t j = first; j < last; ++j) {
                V a_re, a_im, b_re, b_im;
                window.get(j, a_re, a_im);
                window.get(j + half, b_re, b_im);
                V re = a_re - b_re, im = a_im - b_im;
                multiply(re, im, Twiddle{twiddles[2 * j], twiddles[2 * j + 1]});
                put(a_re + b_re, a_im + b_im, work + vector_offset<kLanes>(j));
                put(re, im, work + vector_offset<kLanes>(j + half));
            }
            return;
        }
        const std::size_t quarter = vectors / 4;
        for (std::size_t j = first; j < last; ++j) {
            V re[4];
            V im[4];
#pragma GCC unroll 4
            for (std::size_t m = 0; m < 4; ++m) window.get(j + m * quarter, re[m], im[m]);
            butterfly_4(re, im);
#pragma GCC unroll 4
            for (std::size_t m = 0; m < 4; ++m) {
                if (m > 0) multiply(re[m], im[m], twiddle(twiddles, j, m));
                put(re[m], im[m], work + vector_offset<kLanes>(j + m * quarter));
            }
        }
    }

    /// The butterflies that begin at the vectors j, j + span, ... and have equal twiddle factors.
    template <bool kInverse, bool kTwiddled>
    [[gnu::always_inline]] static void butterflies(const float* twiddles, std::size_t j,
                                                   std::size_t vectors, std::size_t span,
                                                   float* work) {
        const std::size_t quarter = span / 4;
        for (std::size_t first = j; first < vectors; first += span) {
            V re[4];
            V im[4];
#pragma GCC unroll 4
            for (std::size_t m = 0; m < 4; ++m) {
                get(work + vector_offset<kLanes>(first + m * quarter), re[m], im[m]);
                if (kInverse && kTwiddled && m > 0) {
                    multiply_conjugate(re[m], im[m], twiddle(twiddles, j, m));
                }
            }
            if constexpr (kInverse) {
                butterfly_4_inverse(re, im);
            } else {
                butterfly_4(re, im);
            }
#pragma GCC unroll 4
            for (std::size_t m = 0; m < 4; ++m) {
                if (!kInverse && kTwiddled && m > 0)
                    multiply(re[m], im[m], twiddle(twiddles, j, m));
                put(re[m], im[m], work + vector_offset<kLanes>(first + m * quarter));
            }
        }
    }

    template <bool kInverse>
    static void middle(const float* twiddles, std::size_t vectors, std::size_t span,
                       std::size_t first, std::size_t last, float* work) noexcept AULA_NONBLOCKING {
        if (first == 0) butterflies<kInverse, false>(twiddles, first++, vectors, span, work);
        for (std::size_t j = first; j < last; ++j) {
            butterflies<kInverse, true>(twiddles, j, vectors, span, work);
        }
    }

    static void forward_last(const float* work, const float* twiddles, std::size_t vectors,
                             float* spectrum, std::size_t stride) noexcept AULA_NONBLOCKING {
        for (std::size_t first = 0; first < vectors; first += kLanes) {
            V re[kLanes];
            V im[kLanes];
#pragma GCC unroll 16
            for (std::size_t i = 0; i < kLanes; ++i) {
                const std::size_t p = vector_offset<kLanes>(first + i);
                const V a = load<kLanes>(work + p), b = load<kLanes>(work + p + kChunk_bins);
                const V w_re = load<kLanes>(twiddles + p);
                const V w_im = load<kLanes>(twiddles + p + kChunk_bins);
                re[i] = a * w_re - b * w_im;
                im[i] = a * w_im + b * w_re;
            }
            transpose<kLanes>(re);
            transpose<kLanes>(im);
            forward_small<kLanes>(re, im);
#pragma GCC unroll 16
            for (std::size_t i = 0; i < kLanes; ++i) {
                put(re[i], im[i], spectrum + vector_offset<kLanes>(first + i, stride));
            }
        }
    }

    static void inverse_first(const float* spectrum, std::size_t stride, const float* twiddles,
                              std::size_t vectors, float* work) noexcept AULA_NONBLOCKING {
        for (std::size_t first = 0; first < vectors; first += kLanes) {
            V re[kLanes];
            V im[kLanes];
#pragma GCC unroll 16
            for (std::size_t i = 0; i < kLanes; ++i) {
                get(spectrum + vector_offset<kLanes>(first + i, stride), re[i], im[i]);
            }
            inverse_small<kLanes>(re, im);
            transpose<kLanes>(re);
            transpose<kLanes>(im);
#pragma GCC unroll 16
            for (std::size_t i = 0; i < kLanes; ++i) {
                const std::size_t p = vector_offset<kLanes>(first + i);
                const V w_re = load<kLanes>(twiddles + p);
                const V w_im = load<kLanes>(twiddles + p + kChunk_bins);
                put(re[i] * w_re + im[i] * w_im, im[i] * w_re - re[i] * w_im, work + p);
            }
        }
    }

    /// Writes the imaginary part of z w, the newer half of the window.
    [[gnu::always_inline]] static void put_newer(const V& re, const V& im, const float* weights,
                                                 std::size_t vector, float* out) {
        const float* const w = weights + vector_offset<kLanes>(vector);
        store<kLanes>(re * load<kLanes>(w + kChunk_bins) + im * load<kLanes>(w),
                      out + vector * kLanes);
    }

    static void inverse_last(const float* weights, const float* twiddles, std::size_t vectors,
                             bool radix_2, std::size_t first, std::size_t last, const float* work,
                             float* out) noexcept AULA_NONBLOCKING {
        if (radix_2) {
            const std::size_t half = vectors / 2;
            for (std::size_t j = first; j < last; ++j) {
                const float* const a = work + vector_offset<kLanes>(j);
                const float* const b = work + vector_offset<kLanes>(j + half);
                const V a_re = load<kLanes>(a), a_im = load<kLanes>(a + kChunk_bins);
                V re = load<kLanes>(b), im = load<kLanes>(b + kChunk_bins);
                multiply_conjugate(re, im, Twiddle{twiddles[2 * j], twiddles[2 * j + 1]});
                put_newer(a_re + re, a_im + im, weights, j, out);
                put_newer(a_re - re, a_im - im, weights, j + half, out);
            }
            return;
        }
        const std::size_t quarter = vectors / 4;
        for (std::size_t j = first; j < last; ++j) {
            V re[4];
            V im[4];
#pragma GCC unroll 4
            for (std::size_t m = 0; m < 4; ++m) {
                get(work + vector_offset<kLanes>(j + m * quarter), re[m], im[m]);
                if (m > 0) multiply_conjugate(re[m], im[m], twiddle(twiddles, j, m));
            }
            butterfly_4_inverse(re, im);
#pragma GCC unroll 4
            for (std::size_t m = 0; m < 4; ++m) {
                put_newer(re[m], im[m], weights, j + m * quarter, out);
            }
        }
    }

    static constexpr SpectralKernels::Passes kPasses{forward_first, middle<false>, forward_last,
                                                     inverse_first, middle<true>,  inverse_last};
};

}  // namespace

}  // namespace aula
