#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace aula {

/// Output of the program that reads directivities in SOFA: this header, then in double precision 3
/// * directions coordinates, the frequencies in Hz, and directions * frequencies squared pressures.
/// Native byte order.
struct DirectivityHeader {
    enum class Verdict : std::uint32_t { usable, unreadable, other_kind, incomplete, too_large };

    static constexpr std::array<char, 8> kMagic{'A', 'U', 'L', 'A', 'D', 'I', 'R', '1'};
    /// Limits of a file: directions, frequencies, values of all measurements.
    static constexpr std::size_t kMaxDirections = 16384;
    static constexpr std::size_t kMaxFrequencies = 16384;
    static constexpr std::size_t kMaxValues = std::size_t{1} << 24;

    std::array<char, 8> magic = kMagic;
    Verdict verdict = Verdict::unreadable;
    std::uint32_t directions = 0;
    std::uint32_t frequencies = 0;
    std::uint32_t spherical = 0;  ///< 1: coordinates are azimuth, elevation (degrees), radius
    std::array<double, 3> view{1, 0, 0};  ///< front of the source
    std::array<double, 3> up{0, 0, 1};
};

}  // namespace aula
