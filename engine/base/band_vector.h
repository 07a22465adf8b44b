#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "aula/engine/bands.h"
#include "aula/engine/direction_moments.h"

// GCC warns that the calling convention of such vectors depends on version and options. All
// functions that take them are inline.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace aula {

static_assert(kBandCount == 8);

/// All bands in one vector, for the inner loops. The compiler splits it if registers are shorter.
using BandVector = float __attribute__((vector_size(32)));
using BandIntegers = std::int32_t __attribute__((vector_size(32)));
using BandDoubles = double __attribute__((vector_size(64)));

inline BandVector load_bands(const float* from) {
    BandVector v;
    std::memcpy(&v, from, sizeof v);
    return v;
}

inline BandVector load_bands(const Bands& from) { return load_bands(from.value.data()); }

inline BandIntegers load_integers(const std::uint32_t* from) {
    BandIntegers v;
    std::memcpy(&v, from, sizeof v);
    return v;
}

inline void store_integers(const BandIntegers& v, std::uint32_t* to) {
    std::memcpy(to, &v, sizeof v);
}

inline void store_bands(const BandVector& v, float* to) { std::memcpy(to, &v, sizeof v); }

/// The sum over all bands, in each of them.
inline BandVector sum_of_bands(BandVector v) {
    v += __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3);
    v += __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5);
    return v + __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6);
}

inline BandVector square_roots(BandVector v) {
    for (int b = 0; b < 8; ++b) v[b] = std::sqrt(v[b]);
    return v;
}

inline BandVector max_of(const BandVector& a, const BandVector& b) { return a > b ? a : b; }

/// Reduces the bands of each of eight vectors by `joined`: [vector]. The order of operations is the
/// same for all vectors, so that equal vectors give equal results.
template <typename Joined>
[[gnu::always_inline]] inline BandVector over_bands(const std::array<BandVector, 8>& v,
                                                    const Joined& joined) {
    std::array<BandVector, 4> fours;
    for (std::size_t i = 0; i < 4; ++i) {
        fours[i] = joined(__builtin_shufflevector(v[i], v[i + 4], 0, 1, 2, 3, 8, 9, 10, 11),
                          __builtin_shufflevector(v[i], v[i + 4], 4, 5, 6, 7, 12, 13, 14, 15));
    }
    std::array<BandVector, 2> twos;
    for (std::size_t i = 0; i < 2; ++i) {
        const BandVector& a = fours[2 * i];
        const BandVector& b = fours[2 * i + 1];
        twos[i] = joined(__builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13),
                         __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15));
    }
    return joined(__builtin_shufflevector(twos[0], twos[1], 0, 2, 8, 10, 4, 6, 12, 14),
                  __builtin_shufflevector(twos[0], twos[1], 1, 3, 9, 11, 5, 7, 13, 15));
}

/// The sum of the bands of each vector: [vector].
[[gnu::always_inline]] inline BandVector sums_over_bands(const std::array<BandVector, 8>& v) {
    return over_bands(v, [](const BandVector& a, const BandVector& b) { return a + b; });
}

/// The largest band of each vector: [vector].
[[gnu::always_inline]] inline BandVector maxima_over_bands(const std::array<BandVector, 8>& v) {
    return over_bands(v, [](const BandVector& a, const BandVector& b) { return max_of(a, b); });
}

/// The largest of all bands, in each of them.
inline BandVector max_of_bands(BandVector v) {
    v = max_of(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
    v = max_of(v, __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
    return max_of(v, __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6));
}

/// The moments in the order of their declaration.
inline BandVector load_moments(const DirectionMoments& from) {
    static_assert(sizeof from == sizeof(BandVector));
    BandVector v;
    std::memcpy(&v, &from, sizeof v);
    return v;
}

}  // namespace aula
