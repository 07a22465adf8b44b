#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace aula {

/// Number of octave bands.
inline constexpr std::size_t kBandCount = 8;

/// Nominal centre frequencies of the octave bands in Hz (IEC 61260-1).
inline constexpr std::array<float, kBandCount> kBandCentres_hz{63,   125,  250,  500,
                                                               1000, 2000, 4000, 8000};

/// One number for each octave band. Band b has the centre kBandCentres_hz[b]. Arithmetic is band by
/// band. The alignment lets compilers use one vector register.
struct alignas(32) Bands {
    std::array<float, kBandCount> value{};  ///< [band], 63 Hz first; initially 0

    /// The number x in each band.
    static constexpr Bands filled(float x) {
        Bands b;
        b.value.fill(x);
        return b;
    }

    /// The number of a band; `band` < kBandCount is not checked.
    constexpr float& operator[](std::size_t band) { return value[band]; }
    /// The number of a band; `band` < kBandCount is not checked.
    constexpr float operator[](std::size_t band) const { return value[band]; }

    /// Adds in each band.
    constexpr Bands& operator+=(const Bands& o) {
        for (std::size_t b = 0; b < kBandCount; ++b) value[b] += o.value[b];
        return *this;
    }
    /// Multiplies in each band.
    constexpr Bands& operator*=(const Bands& o) {
        for (std::size_t b = 0; b < kBandCount; ++b) value[b] *= o.value[b];
        return *this;
    }
    /// Multiplies each band by the same factor.
    constexpr Bands& operator*=(float k) {
        for (std::size_t b = 0; b < kBandCount; ++b) value[b] *= k;
        return *this;
    }
    /// The sum in each band.
    friend constexpr Bands operator+(Bands a, const Bands& b) { return a += b; }
    /// The product in each band.
    friend constexpr Bands operator*(Bands a, const Bands& b) { return a *= b; }
    /// The product of each band and the same factor.
    friend constexpr Bands operator*(Bands a, float k) { return a *= k; }
    /// True if all bands are equal.
    friend constexpr bool operator==(const Bands&, const Bands&) = default;

    /// The sum over all bands. Added in pairs, for a short dependency chain.
    constexpr float sum() const {
        return ((value[0] + value[4]) + (value[2] + value[6])) +
               ((value[1] + value[5]) + (value[3] + value[7]));
    }
    /// The largest number of all bands.
    constexpr float max() const {
        return std::max(std::max(std::max(value[0], value[4]), std::max(value[2], value[6])),
                        std::max(std::max(value[1], value[5]), std::max(value[3], value[7])));
    }
};

/// 1 - x in each band.
constexpr Bands complement(const Bands& x) {
    Bands r;
    for (std::size_t b = 0; b < kBandCount; ++b) r[b] = 1.0F - x[b];
    return r;
}

}  // namespace aula
