// Compiled once for each instruction set: see spectral_loops.h.
#pragma once

#include <cstddef>
#include <cstdint>

#if defined(__F16C__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace aula {

namespace {

template <std::size_t kLanes>
struct VectorOf {
    using Type [[gnu::vector_size(4 * kLanes), gnu::may_alias]] = float;
    using Unaligned [[gnu::vector_size(4 * kLanes), gnu::may_alias, gnu::aligned(4)]] = float;
};

template <std::size_t kLanes>
using Vector = typename VectorOf<kLanes>::Type;

template <std::size_t kLanes>
Vector<kLanes> load(const float* p) {
    return *reinterpret_cast<const Vector<kLanes>*>(p);
}

template <std::size_t kLanes>
Vector<kLanes> load_unaligned(const float* p) {
    return *reinterpret_cast<const typename VectorOf<kLanes>::Unaligned*>(p);
}

template <std::size_t kLanes>
void store(const Vector<kLanes>& v, float* p) {
    *reinterpret_cast<Vector<kLanes>*>(p) = v;
}

// Half precision: 1 bit of sign, 5 of exponent (bias 15), 10 of fraction.

#if defined(__AVX512F__)
constexpr std::size_t kWidest = 16;

Vector<16> load_half(const std::uint16_t* p) {
    return _mm512_maskz_cvtph_ps(0xffff, _mm256_load_si256(reinterpret_cast<const __m256i*>(p)));
}
void store_half(const Vector<16>& v, std::uint16_t* p) {
    _mm256_store_si256(
        reinterpret_cast<__m256i*>(p),
        _mm512_maskz_cvtps_ph(0xffff, v, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC));
}
#elif defined(__F16C__)
constexpr std::size_t kWidest = 8;

Vector<8> load_half(const std::uint16_t* p) {
    return _mm256_cvtph_ps(_mm_load_si128(reinterpret_cast<const __m128i*>(p)));
}
void store_half(const Vector<8>& v, std::uint16_t* p) {
    _mm_store_si128(reinterpret_cast<__m128i*>(p),
                    _mm256_cvtps_ph(v, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC));
}
#elif defined(__aarch64__)
constexpr std::size_t kWidest = 4;

Vector<4> load_half(const std::uint16_t* p) {
    return vcvt_f32_f16(vreinterpret_f16_u16(vld1_u16(p)));
}
void store_half(const Vector<4>& v, std::uint16_t* p) {
    vst1_u16(p, vreinterpret_u16_f16(vcvt_f16_f32(v)));
}
#else
constexpr std::size_t kWidest = 4;

// Shifting the fields to their positions in a float, whose exponent has the bias 127 instead of 15,
// gives the value times 2^-112.
Vector<4> load_half(const std::uint16_t* p) {
    using Halves [[gnu::vector_size(8), gnu::may_alias]] = std::uint16_t;
    using Bits [[gnu::vector_size(16), gnu::may_alias]] = std::uint32_t;
    const Bits bits = __builtin_convertvector(*reinterpret_cast<const Halves*>(p), Bits);
    const Bits moved = ((bits & 0x7fffU) << 13) | ((bits & 0x8000U) << 16);
    return reinterpret_cast<Vector<4> >(moved) * 0x1p112F;
}
void store_half(const Vector<4>& v, std::uint16_t* p) {
    for (std::size_t i = 0; i < 4; ++i) {
        const float x = v[i];
        const auto bits = __builtin_bit_cast(std::uint32_t, x);
        const float size = x < 0 ? -x : x;
        // Rounded to even. Numbers below 2^-14 are subnormal: the exponent is fixed.
        const std::uint32_t rounded = bits + 0xfffU + ((bits >> 13) & 1U);
        const std::uint32_t magnitude = size < 0x1p-14F
                                            ? static_cast<std::uint32_t>(size * 0x1p24F + 0.5F)
                                            : ((rounded & 0x7fffffffU) >> 13) - (112U << 10);
        p[i] = static_cast<std::uint16_t>((bits >> 16 & 0x8000U) | magnitude);
    }
}
#endif

void to_half(const float* in, std::size_t count, float scale,
             std::uint16_t* out) noexcept AULA_NONBLOCKING {
    for (std::size_t n = 0; n < count; n += kWidest) {
        store_half(scale * load<kWidest>(in + n), out + n);
    }
}

}  // namespace

}  // namespace aula
